//! `flywheel compare BENCH`

use std::path::PathBuf;

use identify::{Effort, PushModel};

use crate::bench_folder::BenchFolder;
use crate::cli::{BenchFiles, Output};
use crate::failure::Failure;
use crate::fitted::Fitted;
use crate::progress::while_doing;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml, or that file
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
    let fitted = against_measurement(&folder, &file)?;
    let figures = while_doing("drawing", || fitted.figures())?;
    let mut text = fitted.head()
        + &fitted.parameter_table()
        + &fitted.error_table()
        + &fitted.place_table()
        + &fitted.remarks()
        + "\nFigures\n";
    for path in &figures {
        text.push_str(&format!("  {}\n", path.display()));
    }
    Report::new(text, &fitted.json(figures))
}

/// The model of `file` as it is against every experiment: only the start of each log (its angle,
/// its speed) is fitted, for no log says where it began.
pub fn against_measurement<'a>(
    folder: &'a BenchFolder,
    file: &bench_files::ModelFile,
) -> Result<Fitted<'a>, Failure> {
    let values = parameter_values(folder, file)?;
    let model = file.model();
    let setup = folder.setup.suited_to(&model);
    let records = setup.all_records();
    let minimum = while_doing("simulating all experiments", || {
        let windows = records
            .iter()
            .map(|record| identify::final_windows(record, &values))
            .collect();
        identify::refit(&records, &model, values, windows, &[], Effort::FULL)
    });
    let push_model = PushModel::of(&model, &minimum.values);
    let traces = records
        .iter()
        .zip(&minimum.windows)
        .map(|(record, windows)| identify::traces(record, windows, &model, &minimum.values))
        .collect();
    let pushes = records
        .iter()
        .map(|record| identify::find_pushes(record, &push_model))
        .collect();
    let mut fitted = Fitted::from_model_file(
        folder,
        file,
        &minimum.values,
        &minimum.windows,
        traces,
        pushes,
    );
    fitted.statements = while_doing("looking for contradictions", || {
        let windows = &minimum.windows;
        identify::contradictions(&folder.setup, &model, &minimum.values, windows, &[])
            .iter()
            .map(identify::Contradiction::sentence)
            .collect()
    });
    Ok(fitted)
}

/// The parameter vector of the file. What no log of this bench can show may be missing in it.
fn parameter_values(
    folder: &BenchFolder,
    file: &bench_files::ModelFile,
) -> Result<Vec<f64>, Failure> {
    let setup = &folder.setup;
    let model = file.model();
    let free = setup.free(&model);
    let again = format!("run: flywheel identify {}", folder.bench.folder.display());
    let mut values = setup.start_values(&model);
    for (position, info) in model.parameters().iter().enumerate() {
        match file.parameter(info.name) {
            Some(parameter) => {
                let unit = setup.unit(&model, position);
                if parameter.is_per_inertia() != unit.ends_with("per kg m2") {
                    return Err(Failure::in_file(
                        file.path(),
                        format!(
                            "{} is in \"{}\", but the bench as it is now gives \"{unit}\"; {again}",
                            info.name, parameter.unit
                        ),
                    ));
                }
                values[position] = parameter.value;
            }
            None if free.contains(&position) => {
                return Err(Failure::in_file(
                    file.path(),
                    format!("lacks [parameters.{}]; {again}", info.name),
                ));
            }
            None => {}
        }
    }
    Ok(values)
}
