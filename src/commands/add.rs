//! `flywheel add EFFECT --bench BENCH`

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use plant::EffectId;
use workbench::Progress;
use workbench::{EffectChange, Error, Session};

use crate::arguments::{BenchFiles, JsonOutput, save_model};
use crate::commands::identify::{has_design, written};
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;
use crate::views::comparison;

/// Arguments of the command.
#[derive(clap::Args)]
#[command(after_help = effects_help())]
pub struct Arguments {
    /// The effect: one of the library, or own:NAME for effects/NAME.toml in the bench folder
    #[arg(value_parser = EffectNameParser, required_unless_present = "learned")]
    pub effect: Option<String>,
    /// Instead of an effect: learn the missing torque from the logs, as a smooth curve over this coordinate. The curve
    /// lowers the error, but explains nothing
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

/// The coordinates of learned curves.
pub const LEARNED: [&str; 4] = ["angle", "rate", "wheel_speed", "wheel_angle"];

/// The names that EFFECT can have.
pub fn effect_names() -> Vec<&'static str> {
    EffectId::ALL.iter().map(|effect| effect.name()).collect()
}

/// Reads an effect that is named on the command line: one of the library, or one of the bench's own.
#[derive(Clone)]
pub struct EffectNameParser;

impl TypedValueParser for EffectNameParser {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &std::ffi::OsStr,
    ) -> Result<String, clap::Error> {
        match value.to_str() {
            Some(name) if name.starts_with(bench_files::OWN_PREFIX) => Ok(name.to_owned()),
            _ => PossibleValuesParser::new(effect_names()).parse_ref(command, argument, value),
        }
    }
}

/// The list of effects below the help.
fn effects_help() -> String {
    let lines = EffectId::ALL.iter().map(|effect| {
        let info = effect.info();
        format!("  {:26}{}\n", info.name, info.meaning)
    });
    format!(
        "Effects (flywheel effects NAME explains one):\n{}",
        lines.collect::<String>()
    )
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let session = arguments.files.open_to_change(&arguments.bench)?;
    change(session, |session, progress| {
        match (&arguments.learned, &arguments.effect) {
            (Some(coordinate), _) => session.add_learned(coordinate, progress),
            (None, effect) => session.add_effect(effect.as_deref().unwrap_or_default(), progress),
        }
    })
}

/// Changes the session's model, writes it, and shows what the change did.
pub fn change(
    mut session: Session,
    change: impl FnOnce(&mut Session, &Progress) -> Result<EffectChange, Error>,
) -> Result<Report, Failure> {
    let had_design = has_design(&session);
    let changed = with_progress(|progress| change(&mut session, progress))?;
    save_model(&session)?;
    let text = comparison::changed(&changed) + &written(&session, had_design);
    Report::new(text, &changed)
}
