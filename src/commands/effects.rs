//! `flywheel effects [NAME]`

use clap::builder::PossibleValuesParser;
use serde::Serialize;
use workbench::{EffectConfusion, EffectDescription, effect_confusions, effect_library};

use crate::arguments::JsonOutput;
use crate::commands::add::effect_names;
use crate::failure::Failure;
use crate::report::Report;
use crate::views::effects;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The effect to explain [default: list all]
    #[arg(value_parser = PossibleValuesParser::new(effect_names()), hide_possible_values = true)]
    pub name: Option<String>,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Everything about one effect.
#[derive(Serialize)]
struct Explained<'a> {
    #[serde(flatten)]
    effect: &'a EffectDescription,
    confusions: Vec<EffectConfusion>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let library = effect_library();
    let Some(name) = &arguments.name else {
        return Report::new(effects::list(&library), &library);
    };
    let mut named: Vec<EffectDescription> = library;
    named.retain(|effect| effect.name == *name);
    match named.first() {
        Some(effect) => {
            let confusions = effect_confusions(name);
            let text = effects::whole(effect, &confusions);
            Report::new(text, &Explained { effect, confusions })
        }
        None => Err(Failure::new(format!(
            "there is no effect \"{name}\"; flywheel effects lists the library"
        ))),
    }
}
