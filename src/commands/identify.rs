//! `flywheel identify BENCH`

use std::path::PathBuf;

use bench_files::{Correlation, ModelFile, Parameter};
use plant::Model;

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
    /// Fit the base model, whatever effects model.toml has
    #[arg(long)]
    pub reset: bool,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: Output,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = BenchFolder::load(&arguments.bench, &arguments.files)?;
    let file = folder.model_or_base()?;
    let model = if arguments.reset {
        Model::base()
    } else {
        file.model()
    };
    let fitted = fit(&folder, &model)?;
    let text = save(&folder, file, &fitted)?;
    Report::new(
        fitted.head()
            + &fitted.parameter_table()
            + &fitted.error_table()
            + &fitted.place_table()
            + &fitted.remarks()
            + &text,
        &fitted.json(Vec::new()),
    )
}

/// Fits `model` to all experiments of the bench.
pub fn fit<'a>(folder: &'a BenchFolder, model: &Model) -> Result<Fitted<'a>, Failure> {
    let found = while_doing("fitting the model to all experiments", || {
        identify::identify(&folder.setup, model, None)
    })
    .map_err(|error| Failure::in_file(&folder.bench.folder, error))?;
    Ok(Fitted::from_identification(folder, found))
}

/// The bench's model.toml with another model in it; `file` is what stood there.
pub fn with_model(
    folder: &BenchFolder,
    mut file: ModelFile,
    model: &Model,
    parameters: Vec<Parameter>,
    correlation: Option<Correlation>,
) -> ModelFile {
    file.replace_model_parameters(parameters, correlation);
    file.effects = model.effects().to_vec();
    file.design.get_or_insert_with(|| folder.usual_design());
    file
}

/// Writes a fit to the bench's model.toml; `file` is what stood there. Returns what to say about it.
pub fn save(folder: &BenchFolder, file: ModelFile, fitted: &Fitted) -> Result<String, Failure> {
    let had_design = file.design.is_some();
    let file = with_model(
        folder,
        file,
        &fitted.model,
        fitted.parameters.clone(),
        fitted.correlation.clone(),
    );
    folder.write_model(&file)?;
    let mut text = format!("\nWritten: {}\n", folder.model_path.display());
    if !had_design {
        text.push_str("  with the weights of the thesis under [design], where others can be set\n");
    }
    Ok(text)
}
