//! `flywheel diagnose BENCH`

use std::path::PathBuf;

use serde::Serialize;
use workbench::{AppliedDiagnosis, DesignChange, DiagnosisReport, Session};

use crate::arguments::{BenchFiles, JsonOutput, save_model};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::{Report, listed, write_files};
use crate::views::{design_change, diagnosis};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    /// Put the missing effects into model.toml, with the refitted parameters
    #[arg(long)]
    pub apply: bool,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: JsonOutput,
}

#[derive(Serialize)]
struct Diagnosed<'a> {
    #[serde(flatten)]
    report: &'a DiagnosisReport,
    figures: Vec<PathBuf>,
    /// The model.toml that was written; null where none was.
    written: Option<PathBuf>,
    /// What the added effects change in the controller; null without --apply.
    design_change: Option<DesignChange>,
}

/// Runs the command. The model is that of model.toml, its parameters fitted anew: wrong numbers are
/// not a missing effect.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let mut session = arguments.files.open_to_draw(&arguments.bench)?;
    let report = with_progress(|progress| session.diagnose(progress))?;
    let figures = write_files(&arguments.files.out_of(&session), &report.drawings()?)?;
    let (more, written, change) = if arguments.apply {
        let applied = session.apply(&report);
        save_model(&session)?;
        let path = session.model_path().to_path_buf();
        (
            applied_text(&applied, &session),
            Some(path),
            applied.design_change,
        )
    } else if session.model().is_none() {
        session.keep_first_step(&report);
        let is_kept = session.model().is_some();
        // The diagnosis stands whether or not the bench can be written to.
        match save_model(&session) {
            Ok(()) if !is_kept => (String::new(), None, None),
            Ok(()) => {
                let path = session.model_path().to_path_buf();
                let text = format!("\nWritten: {} (the base model)\n", path.display());
                (text, Some(path), None)
            }
            Err(failure) => (format!("\nNo model was written: {failure}\n"), None, None),
        }
    } else {
        (String::new(), None, None)
    };
    let more = if arguments.apply {
        more
    } else {
        would_add(&report) + &more
    };
    let text = diagnosis::text(&report) + &more + "\nFigures\n" + &listed(&figures);
    Report::new(
        text,
        &Diagnosed {
            report: &report,
            figures,
            written,
            design_change: change,
        },
    )
}

fn applied_text(applied: &AppliedDiagnosis, session: &Session) -> String {
    let mut text = String::new();
    if let Some(change) = &applied.design_change {
        text.push_str(&design_change::text(change));
    }
    if let Some(reason) = &applied.no_controller {
        text.push_str(&format!(
            "\nNo controller can be designed from this model: {reason}\n"
        ));
    }
    text.push_str(&format!("\nAdded: {}\n", some_or_nothing(&applied.added)));
    if !applied.provisional.is_empty() {
        text.push_str(&format!(
            "Provisional until an experiment has decided: {} (flywheel add with the same effect confirms it; \
             with a rival, it puts the rival in its place)\n",
            applied.provisional.join(", ")
        ));
    }
    if !applied.taken_out.is_empty() {
        text.push_str(&format!("Taken out: {}\n", applied.taken_out.join(", ")));
    }
    text + &format!("Written: {}\n", session.model_path().display())
}

/// The lines about what `--apply` would change.
fn would_add(report: &DiagnosisReport) -> String {
    let (added, taken_out) = (report.added(), report.taken_out());
    if added.is_empty() && taken_out.is_empty() {
        return String::new();
    }
    let out = match taken_out.join(", ") {
        none if none.is_empty() => none,
        names => format!(" and take out {names}"),
    };
    format!(
        "\nWould add {}{out}: `diagnose --apply` does it.\n",
        some_or_nothing(&added)
    )
}

fn some_or_nothing(names: &[String]) -> String {
    if names.is_empty() {
        "nothing".to_owned()
    } else {
        names.join(", ")
    }
}
