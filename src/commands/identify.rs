//! `flywheel identify BENCH`

use std::path::PathBuf;

use workbench::Session;

use crate::arguments::{BenchFiles, JsonOutput, save_model};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;
use crate::views::comparison;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    /// Fit the base model, without the effects that model.toml has
    #[arg(long)]
    pub reset: bool,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let mut session = arguments.files.open_to_change(&arguments.bench)?;
    let had_design = has_design(&session);
    let fitted = with_progress(|progress| {
        if arguments.reset {
            session.identify_base(progress)
        } else {
            session.identify(progress)
        }
    })?;
    save_model(&session)?;
    let text = comparison::whole(&fitted) + &written(&session, had_design);
    Report::new(text, &fitted)
}

/// Whether the session's model has a section [design].
pub fn has_design(session: &Session) -> bool {
    session.model().is_some_and(|model| model.design.is_some())
}

/// The lines about the model that was written.
pub fn written(session: &Session, had_design: bool) -> String {
    let mut text = format!("\nWritten: {}\n", session.model_path().display());
    if !had_design {
        text.push_str("  [design] has the weights of the thesis; change them there\n");
    }
    text
}
