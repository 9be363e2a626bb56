//! `flywheel record BENCH --port DEV --experiment KIND`

use std::path::PathBuf;

use workbench::{RecordSettings, RecordedExperiment, record};

use super::generate::PresetName;
use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;
use crate::views::recording;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    /// The serial device of the firmware, for example /dev/ttyACM0
    #[arg(long, value_name = "DEV")]
    pub port: PathBuf,
    /// What to record: free-swing, spin-up, coast-down or balance; for bring-up hanging, tilted, wheel-spun or
    /// current-step
    #[arg(long, value_name = "KIND")]
    pub experiment: RecordedExperiment,
    /// Currents in A, separated by commas; spin-up makes one log for each [default: shares of the current limit]
    #[arg(
        long,
        value_name = "A",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub current: Vec<f64>,
    /// Length of a log in s [default: the usual length of the experiment]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    /// Name of the log in bench.toml [default: the name of the experiment]
    #[arg(long)]
    pub name: Option<String>,
    /// Record every N-th step of the controller
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..))]
    pub every: u8,
    /// Bits a second on the serial line; the USB port of the chip itself accepts any number
    #[arg(long, default_value_t = 921_600, value_parser = clap::value_parser!(u32).range(1..))]
    pub baud: u32,
    /// The emitted crate that runs in the firmware [default: the crate that follows from [hardware]]
    #[arg(long, value_name = "DIR")]
    pub module: Option<PathBuf>,
    /// Bench that supplies the sensors and the drive that this bench does not state
    #[arg(long, value_name = "NAME")]
    pub preset: Option<PresetName>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command. Ctrl-C ends the record, and what was recorded is kept.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    eprintln!(
        "{}: {}",
        arguments.experiment,
        arguments.experiment.instruction()
    );
    let settings = RecordSettings {
        port: arguments.port.clone(),
        baud: arguments.baud,
        experiment: arguments.experiment,
        currents_a: arguments.current.clone(),
        seconds: arguments.seconds,
        name: arguments.name.clone(),
        every: arguments.every,
        module: arguments.module.clone(),
        preset: arguments.preset.map(PresetName::preset),
    };
    let recorded =
        with_progress(|progress| record(&arguments.bench, &settings, progress, &mut |_| {}))?;
    Report::new(recording::text(&arguments.bench, &recorded), &recorded)
}
