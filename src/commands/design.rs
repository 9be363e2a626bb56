//! `flywheel design MODEL`

use std::path::PathBuf;

use workbench::ControlDesign;

use crate::arguments::{JsonOutput, out_beside};
use crate::failure::Failure;
use crate::report::{Report, WithFigures, listed, write_files};
use crate::views::design;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Folder for the figure [default: out beside MODEL]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| out_beside(&arguments.model));
    bench_files::can_write_into(&out)?;
    let result = ControlDesign::read(&arguments.model)?.report()?;
    let figures = write_files(&out, &result.drawings()?)?;
    let text = design::text(&result) + "\nFigures\n" + &listed(&figures);
    let result = &result;
    Report::new(text, &WithFigures { result, figures })
}
