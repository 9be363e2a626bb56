//! `flywheel add EFFECT --bench BENCH`

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use plant::{EffectId, Model};
use serde::Serialize;

use crate::bench_folder::BenchFolder;
use crate::cli::{BenchFiles, Output};
use crate::commands::identify::{fit, save};
use crate::failure::Failure;
use crate::fitted::{Fitted, FittedJson};
use crate::report::Report;
use crate::report::json::Keyed;
use crate::report::numbers::with_prefix;
use crate::report::table::{Align, Table};

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

/// The names that EFFECT can have.
pub fn effect_names() -> Vec<&'static str> {
    EffectId::ALL.iter().map(|effect| effect.name()).collect()
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = BenchFolder::load(&arguments.bench, &arguments.files)?;
    let file = folder.model_or_base()?;
    let before = file.model();
    let effect = EffectId::from_name(&arguments.effect)
        .ok_or_else(|| Failure::new(format!("there is no effect \"{}\"", arguments.effect)))?;
    let after = before.with(effect);
    if after == before {
        let reason = match before
            .effects()
            .iter()
            .find(|present| present.info().replaces.contains(&effect.name()))
        {
            Some(larger) => format!("{} contains it already", larger.name()),
            None => "the model has it already".to_owned(),
        };
        return Err(Failure::in_file(
            &folder.model_path,
            format!("{} is not added: {reason}", effect.name()),
        ));
    }
    change(&folder, file, &before, &after)
}

/// What changed, beside what the new model says.
#[derive(Serialize)]
struct ChangeJson {
    #[serde(flatten)]
    after: FittedJson,
    effects_before: Vec<&'static str>,
    rmse_before: Keyed,
}

/// Fits both models, writes the second, and shows what it changes.
pub fn change(
    folder: &BenchFolder,
    file: bench_files::ModelFile,
    before: &Model,
    after: &Model,
) -> Result<Report, Failure> {
    let old = fit(folder, before)?;
    let new = fit(folder, after)?;
    let saved = save(folder, file, &new)?;
    let text = new.head()
        + &new.parameter_table()
        + &difference_table(&old, &new)
        + &new.place_table()
        + &new.remarks()
        + &saved;
    Report::new(
        text,
        &ChangeJson {
            after: new.json(Vec::new()),
            effects_before: before.effects().iter().map(|e| e.name()).collect(),
            rmse_before: old.keyed(|_, trace| trace.rmse),
        },
    )
}

fn difference_table(old: &Fitted, new: &Fitted) -> String {
    let mut table = Table::new(&[
        ("experiment/channel", Align::Left),
        ("RMSE before", Align::Right),
        ("after", Align::Right),
        ("sensor noise", Align::Right),
        ("fit before", Align::Right),
        ("after", Align::Right),
    ]);
    let units: Vec<&str> = new
        .traces
        .iter()
        .flatten()
        .map(|trace| trace.output.unit())
        .collect();
    let rows = old
        .keyed(|_, trace| trace.rmse)
        .0
        .into_iter()
        .zip(new.keyed(|_, trace| trace.rmse).0)
        .zip(new.keyed(|noise, _| noise).0)
        .zip(old.keyed(|_, trace| trace.fit_percent).0)
        .zip(new.keyed(|_, trace| trace.fit_percent).0)
        .zip(units);
    for (((((before, after), noise), fit_before), fit_after), unit) in rows {
        table.row([
            before.0,
            with_prefix(before.1, unit),
            with_prefix(after.1, unit),
            with_prefix(noise.1, unit),
            format!("{:.2} %", fit_before.1),
            format!("{:.2} %", fit_after.1),
        ]);
    }
    format!("\nModel against measurement\n{}", table.text())
}
