//! `flywheel generate MODEL --out DIR`

use std::path::PathBuf;

use codegen::{CrateName, FileError};
use serde::Serialize;
use workbench::numbers::significant;
use workbench::{ControlDesign, ControllerOptions, GeneratedController, Preset};

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The model: a model.toml
    pub model: PathBuf,
    /// Folder for the emitted crate
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Bench that supplies what the model states neither under [hardware] nor under [calibration]
    #[arg(long, value_name = "BENCH")]
    pub preset: Option<PresetName>,
    /// The language: a Rust crate, or a C99 library for Arduino and PlatformIO (`prove` reads the Rust)
    #[arg(long, value_name = "LANGUAGE", default_value = "rust")]
    pub language: Language,
    /// Name of the emitted crate, or of the library in C
    #[arg(long, value_name = "CRATE", default_value = "generated")]
    pub name: CrateName,
    /// Add a monitor: a function that says whether the motion is one that the model allows
    #[arg(long)]
    pub monitor: bool,
    /// Compare instead of writing: exit code 1 if DIR differs from what would be written
    #[arg(long)]
    pub check: bool,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// The benches that can supply missing sensors and drive.
#[derive(Clone, Copy, clap::ValueEnum)]
pub enum PresetName {
    /// The bench of the thesis
    ThesisBench,
}

impl PresetName {
    /// The bench as the library names it.
    pub fn preset(self) -> Preset {
        match self {
            PresetName::ThesisBench => Preset::ThesisBench,
        }
    }
}

/// The languages in which a controller is emitted.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Language {
    /// A `no_std` crate
    Rust,
    /// A header and a source in C99
    C,
}

#[derive(Serialize)]
struct Generated<'a> {
    #[serde(flatten)]
    controller: &'a GeneratedController,
    out: PathBuf,
    files: Vec<PathBuf>,
    /// Files that were written, and files of an earlier emission that were removed; without meaning under --check.
    changed: Vec<PathBuf>,
    /// Files that are not as emitted (only under --check).
    differing: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let out = &arguments.out;
    let preset = arguments.preset.map(PresetName::preset);
    let options = ControllerOptions {
        preset,
        name: arguments.name.clone(),
        has_monitor: arguments.monitor,
    };
    let controller = ControlDesign::read(&arguments.model)?.generate_with(&options)?;
    let controller = match arguments.language {
        Language::Rust => controller,
        Language::C => controller.in_c()?,
    };
    let files: Vec<PathBuf> = controller.files().map(|(path, _)| out.join(path)).collect();
    let mut text = law(&controller);
    let (mut changed, mut differing) = (Vec::new(), Vec::new());
    if arguments.check {
        differing = controller.differing(out)?;
        if differing.is_empty() {
            text.push_str(&format!("{} is what the generator emits\n", out.display()));
        } else {
            let paths = differing.clone();
            text.push_str(&format!("{}\n", FileError::Differs { paths }));
        }
    } else {
        changed = controller.write(out)?;
        for path in &files {
            let state = if changed.contains(path) {
                "written  "
            } else {
                "unchanged"
            };
            text.push_str(&format!("  {state}  {}\n", path.display()));
        }
        for path in changed.iter().filter(|path| !files.contains(path)) {
            text.push_str(&format!("  removed    {}\n", path.display()));
        }
    }
    let is_as_emitted = differing.is_empty();
    let report = Report::new(
        text,
        &Generated {
            controller: &controller,
            out: out.clone(),
            files,
            changed,
            differing,
        },
    )?;
    Ok(if is_as_emitted {
        report
    } else {
        report.failed()
    })
}

/// The law in one line, and lines about its observer, warnings and assumed properties.
fn law(controller: &GeneratedController) -> String {
    let mut law = format!(
        "{}: u = −K x, K = ({}), one command every {} s, at most {} A\n",
        controller.model,
        controller.gains.map(|gain| significant(gain, 9)).join(", "),
        controller.sample_time_s,
        controller.current_limit_a,
    );
    if let Some(time) = controller.bias_time_constant_s {
        law.push_str(&format!(
            "An observer finds a constant bias of the angle within about {} s and subtracts it;\n\
             `prove` bounds the loop with it from starts at rest, and no ellipsoid is stated\n",
            significant(time, 3)
        ));
    }
    for warning in &controller.warnings {
        law.push_str(&format!("Warning: {warning}\n"));
    }
    if !controller.assumed.is_empty() {
        law.push_str("Assumed, from the bench of the thesis:\n");
        for sentence in &controller.assumed {
            law.push_str(&format!("  {sentence}\n"));
        }
    }
    law
}
