//! A new bench, in words.

use std::path::Path;

use workbench::NewBench;

use super::findings;

/// The proposal, the open questions, and the next commands.
pub fn text(folder: &Path, begun: &NewBench) -> String {
    let mut text = format!("Written: {}\n", begun.written.display());
    for experiment in &begun.proposal.experiments {
        text.push_str(&format!("\n{}  ({})\n", experiment.name, experiment.file));
        for reason in &experiment.reasons {
            text.push_str(&format!("  {reason}\n"));
        }
        for question in &experiment.questions {
            text.push_str(&format!("  TO DECIDE: {question}\n"));
        }
    }
    text.push_str(&findings::list(&begun.proposal.findings));
    if let Some(open) = &begun.proposal.open {
        text.push_str(&format!("\nNot yet a bench: {open}\n"));
    }
    let place = folder.display();
    text + &format!(
        "\nNext: what is known under [known], then\n  flywheel check {place}\n  flywheel diagnose {place}\n"
    )
}
