//! `flywheel simulate MODEL`

use std::path::PathBuf;

use bench_files::Bench;
use serde::Serialize;
use workbench::{ControlDesign, SimulationReport, SimulationSettings};

use crate::arguments::{JsonOutput, out_beside};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::{Report, listed, write_files};
use crate::views::closed_loop;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Overlay the free swings and balance logs of this bench
    #[arg(long)]
    pub bench: Option<PathBuf>,
    /// Seed of the sensors' noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Folder for figures and tables [default: out beside MODEL]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub output: JsonOutput,
}

#[derive(Serialize)]
struct Simulated<'a> {
    #[serde(flatten)]
    report: &'a SimulationReport,
    files: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let out = arguments.out.clone();
    let out = out.unwrap_or_else(|| out_beside(&arguments.model));
    bench_files::can_write_into(&out)?;
    let bench = arguments.bench.as_deref().map(Bench::load).transpose()?;
    let designed = ControlDesign::read(&arguments.model)?;
    let settings = SimulationSettings {
        seed: arguments.seed,
        bench: bench.as_ref(),
        ..Default::default()
    };
    let report = with_progress(|progress| designed.simulate(&settings, progress))?;
    let files = write_files(&out, &report.files()?)?;
    let text = closed_loop::text(&report) + "\nFigures and tables\n" + &listed(&files);
    Report::new(
        text,
        &Simulated {
            report: &report,
            files,
        },
    )
}
