//! `flywheel bring-up BENCH`

use std::path::PathBuf;

use workbench::{BringUpRecordings, bring_up};

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;
use crate::views;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml that has a [bring_up] section, or that file
    pub bench: PathBuf,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let recordings = BringUpRecordings::load(&arguments.bench)?;
    let report = bring_up(&recordings);
    Report::new(views::bring_up::text(&report), &report)
}
