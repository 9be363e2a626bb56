//! `flywheel new DIR FILE.csv…`

use std::path::PathBuf;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;
use crate::views::new_bench;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder of the bench; created if it is missing
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The logs: CSV files, in any of the dialects that spreadsheets write
    #[arg(value_name = "FILE", required = true)]
    pub logs: Vec<PathBuf>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let begun = workbench::new_bench(&arguments.folder, &arguments.logs)?;
    Report::new(new_bench::text(&arguments.folder, &begun), &begun)
}
