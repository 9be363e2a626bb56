//! `flywheel generate MODEL --out DIR`

use std::path::PathBuf;

use codegen::{EmittedCrate, FileError};
use serde::Serialize;

use crate::cli::Output;
use crate::failure::Failure;
use crate::model_design::ModelDesign;
use crate::module_spec::module_spec;
use crate::report::Report;
use crate::report::numbers::significant;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Folder of the emitted crate
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Compare instead of writing: exit code 1 where DIR is not what would be written
    #[arg(long)]
    pub check: bool,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct Generated {
    model: String,
    out: PathBuf,
    gains: [f64; 3],
    current_limit_a: f64,
    sample_time_s: f64,
    /// Time constant of the observer of the angle's bias, if the model asks for one.
    bias_time_constant_s: Option<f64>,
    files: Vec<PathBuf>,
    /// Files that were written; without meaning under --check.
    changed: Vec<PathBuf>,
    /// Files that are not as emitted (only under --check).
    differing: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let designed = ModelDesign::new(&arguments.model)?;
    let spec = module_spec(&designed)?;
    let emitted =
        codegen::generate(&spec).map_err(|refusal| Failure::in_file(&arguments.model, refusal))?;
    let mut result = Generated {
        model: spec.model_name.clone(),
        out: arguments.out.clone(),
        gains: spec.gains,
        current_limit_a: spec.current_limit_a,
        sample_time_s: spec.sample_time_s,
        bias_time_constant_s: designed.wishes.bias_time_constant_s,
        files: paths(&emitted, arguments),
        changed: Vec::new(),
        differing: Vec::new(),
    };
    let mut law = format!(
        "{}: u = −K x, K = ({}), one command every {} s, at most {} A\n",
        result.model,
        result.gains.map(|gain| significant(gain, 9)).join(", "),
        result.sample_time_s,
        result.current_limit_a,
    );
    if let Some(time) = result.bias_time_constant_s {
        law.push_str(&format!(
            "A constant bias of the angle is found and taken out within about {} s;\n\
             the certificate's bound for all time is that of the loop without this observer and is left out\n",
            significant(time, 3)
        ));
    }
    if arguments.check {
        return match emitted.check(&arguments.out) {
            Ok(()) => {
                let text = format!(
                    "{law}{} is what the generator emits\n",
                    arguments.out.display()
                );
                Report::new(text, &result)
            }
            Err(error @ FileError::Differs { .. }) => {
                let text = format!("{law}{error}\n");
                if let FileError::Differs { paths } = error {
                    result.differing = paths;
                }
                Ok(Report::new(text, &result)?.failed())
            }
            Err(error) => Err(Failure::new(error.to_string())),
        };
    }
    result.changed = emitted
        .write(&arguments.out)
        .map_err(|error| Failure::new(error.to_string()))?;
    let mut text = law;
    for path in &result.files {
        let state = if result.changed.contains(path) {
            "written  "
        } else {
            "unchanged"
        };
        text.push_str(&format!("  {state}  {}\n", path.display()));
    }
    Report::new(text, &result)
}

fn paths(emitted: &EmittedCrate, arguments: &Arguments) -> Vec<PathBuf> {
    emitted
        .files
        .iter()
        .map(|file| arguments.out.join(&file.path))
        .collect()
}
