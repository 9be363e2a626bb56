//! `flywheel diagnose BENCH`

use std::path::PathBuf;

use identify::Identification;
use plant::Model;
use serde::Serialize;

use crate::bench_folder::BenchFolder;
use crate::cli::{BenchFiles, Output};
use crate::commands::identify::with_model;
use crate::design_change::DesignChange;
use crate::diagnosed::{Diagnosed, DiagnosisJson};
use crate::failure::Failure;
use crate::fitted::{correlation_of, parameters_of};
use crate::progress::while_saying;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
    pub bench: PathBuf,
    /// Put the effects that are missing into model.toml, with the refitted parameters
    #[arg(long)]
    pub apply: bool,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct DiagnoseJson {
    #[serde(flatten)]
    diagnosis: DiagnosisJson,
    /// The model.toml that was written; null where none was.
    written: Option<PathBuf>,
    /// What the added effects change in the controller; null without --apply.
    design_change: Option<DesignChange>,
}

/// Runs the command. The model is that of model.toml, its parameters fitted anew: wrong numbers are
/// not a missing effect.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = BenchFolder::load(&arguments.bench, &arguments.files)?;
    let existing = folder.existing_model()?;
    let is_new = existing.is_none();
    let file = existing.unwrap_or_default();
    let (identified, diagnosed) = diagnose(&folder, &file.model())?;
    let figures = while_saying(|say| {
        say("drawing");
        diagnosed.figures()
    })?;

    let mut text = diagnosed.text();
    let mut written = None;
    let mut design_change = None;
    let model_of = |fit: &identify::Fit| {
        let parameters = parameters_of(&folder, fit);
        let correlation = correlation_of(fit);
        with_model(&folder, file.clone(), &fit.model, parameters, correlation)
    };
    let before = model_of(&identified.fit);
    if arguments.apply {
        let after = match diagnosed.found.last() {
            Some(step) => model_of(&step.fit),
            None => before.clone(),
        };
        folder.write_model(&after)?;
        written = Some(folder.model_path.clone());
        let added: Vec<&str> = diagnosed
            .found
            .steps
            .iter()
            .filter_map(|step| Some(step.effect?.name()))
            .collect();
        if added.is_empty() {
            text.push_str("\nAdded: nothing\n");
        } else {
            match DesignChange::new(before, after, &folder.model_path) {
                Ok(change) => {
                    text.push_str(&change.text());
                    design_change = Some(change);
                }
                Err(reason) => text.push_str(&format!(
                    "\nNo controller can be designed from this model: {reason}\n"
                )),
            }
            text.push_str(&format!("\nAdded: {}\n", added.join(", ")));
        }
        text.push_str(&format!("Written: {}\n", folder.model_path.display()));
    } else if is_new {
        // The diagnosis stands whether or not the bench can be written to.
        match folder.write_model(&before) {
            Ok(()) => {
                written = Some(folder.model_path.clone());
                text.push_str(&format!(
                    "\nWritten: {} (the base model)\n",
                    folder.model_path.display()
                ));
            }
            Err(failure) => text.push_str(&format!("\nNo model was written: {failure}\n")),
        }
    }
    text.push_str("\nFigures\n");
    for path in &figures {
        text.push_str(&format!("  {}\n", path.display()));
    }
    Report::new(
        text,
        &DiagnoseJson {
            diagnosis: diagnosed.json(figures),
            written,
            design_change,
        },
    )
}

/// Fits `model` to the bench and diagnoses the fit.
pub fn diagnose<'a>(
    folder: &'a BenchFolder,
    model: &Model,
) -> Result<(Identification, Diagnosed<'a>), Failure> {
    while_saying(|say| {
        say("fitting the model to all experiments");
        let identified = identify::identify(&folder.setup, model, None)
            .map_err(|error| Failure::in_file(&folder.bench.folder, error))?;
        let diagnosed = Diagnosed::new(folder, &identified, say)?;
        Ok((identified, diagnosed))
    })
}
