//! `flywheel check BENCH`

use std::path::PathBuf;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;
use crate::views::findings;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command. Where a finding refuses the data, the exit code is 2, as that of every command that
/// would use them.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let found = workbench::check_data(&arguments.bench)?;
    let report = Report::new(findings::report(&found), &found)?;
    Ok(if found.is_refused() {
        report.refused()
    } else {
        report
    })
}
