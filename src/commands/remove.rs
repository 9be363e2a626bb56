//! `flywheel remove EFFECT --bench BENCH`

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;

use crate::arguments::{BenchFiles, JsonOutput};
use crate::commands::add::{change, effect_names};
use crate::failure::Failure;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The effect
    #[arg(value_parser = PossibleValuesParser::new(effect_names()), hide_possible_values = true)]
    pub effect: String,
    /// The bench: a folder with a bench.toml, or that file
    #[arg(long)]
    pub bench: PathBuf,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let session = arguments.files.open_to_change(&arguments.bench)?;
    change(session, |session, progress| {
        session.remove_effect(&arguments.effect, progress)
    })
}
