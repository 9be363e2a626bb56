//! `flywheel compare BENCH`

use std::path::PathBuf;

use crate::arguments::{BenchFiles, JsonOutput};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::{Report, WithFigures, listed, write_files};
use crate::views::comparison;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let session = arguments.files.open_to_draw(&arguments.bench)?;
    let result = with_progress(|progress| session.compare(progress))?;
    let drawings = result.drawings()?;
    let figures = write_files(&arguments.files.out_of(&session), &drawings)?;
    let text = comparison::whole(&result) + "\nFigures\n" + &listed(&figures);
    let result = &result;
    Report::new(text, &WithFigures { result, figures })
}
