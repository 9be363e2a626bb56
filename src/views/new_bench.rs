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
    let place = folder.display();
    let file = begun.written.display();
    let first = match &begun.proposal.open {
        Some(open) => {
            text.push_str(&format!("\nNot yet a bench: {open}\n"));
            format!("mend this in {file}, and write what you know of the bench under [known]")
        }
        None => format!("write what you know of the bench under [known] in {file}"),
    };
    text + &format!(
        "\nNext: {first}; then\n  flywheel check {place}\n  flywheel diagnose {place}\n"
    )
}
