//! `flywheel remove EFFECT --bench BENCH`

use std::path::PathBuf;

use crate::arguments::{BenchFiles, JsonOutput};
use crate::commands::add::{EffectNameParser, change};
use crate::failure::Failure;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The effect: one of the library, or own:NAME for effects/NAME.toml in the bench folder
    #[arg(value_parser = EffectNameParser)]
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
