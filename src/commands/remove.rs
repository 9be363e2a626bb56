//! `flywheel remove EFFECT --bench BENCH`

use std::path::PathBuf;

use crate::arguments::{BenchFiles, JsonOutput};
use crate::commands::add::{EffectNameParser, LEARNED, change};
use crate::failure::Failure;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The effect: one of the library, or own:NAME for effects/NAME.toml in the bench folder
    #[arg(value_parser = EffectNameParser, required_unless_present = "learned")]
    pub effect: Option<String>,
    /// Instead of an effect: the learned curve over this coordinate
    #[arg(long, value_name = "COORDINATE", value_parser = LEARNED, conflicts_with = "effect")]
    pub learned: Option<String>,
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
        match (&arguments.learned, &arguments.effect) {
            (Some(coordinate), _) => session.remove_learned(coordinate, progress),
            (None, effect) => {
                session.remove_effect(effect.as_deref().unwrap_or_default(), progress)
            }
        }
    })
}
