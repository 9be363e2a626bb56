//! `flywheel remove EFFECT --bench BENCH`

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use plant::EffectId;

use crate::bench_folder::BenchFolder;
use crate::cli::{BenchFiles, Output};
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
    pub output: Output,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = BenchFolder::load(&arguments.bench, &arguments.files)?;
    let file = folder.required_model()?;
    let before = file.model();
    match EffectId::from_name(&arguments.effect).filter(|effect| before.has(*effect)) {
        Some(effect) => change(&folder, file, &before, &before.without(effect)),
        None => {
            let present: Vec<&str> = before.effects().iter().map(|e| e.name()).collect();
            Err(Failure::in_file(
                &folder.model_path,
                format!(
                    "the model does not have {}; it has {}",
                    arguments.effect,
                    present.join(", ")
                ),
            ))
        }
    }
}
