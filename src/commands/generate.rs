//! `flywheel generate MODEL --out DIR`

use std::path::PathBuf;

use bench_files::Calibration;
use codegen::hardware::HardwareSpec;
use codegen::spec::{Drive, ModuleSpec, Parameter, PhysicalRanges};
use codegen::{EmittedCrate, FileError};
use nalgebra::{Matrix3, Rotation3};
use serde::Serialize;

use crate::cli::Output;
use crate::failure::Failure;
use crate::model_design::ModelDesign;
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
    files: Vec<PathBuf>,
    /// Files that were written; without meaning under --check.
    changed: Vec<PathBuf>,
    /// Files that are not as emitted (only under --check).
    differing: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let designed = ModelDesign::new(&arguments.model)?;
    let spec = spec(&designed);
    let emitted =
        codegen::generate(&spec).map_err(|refusal| Failure::in_file(&arguments.model, refusal))?;
    let mut result = Generated {
        model: spec.model_name.clone(),
        out: arguments.out.clone(),
        gains: spec.gains,
        current_limit_a: spec.current_limit_a,
        sample_time_s: spec.sample_time_s,
        files: paths(&emitted, arguments),
        changed: Vec::new(),
        differing: Vec::new(),
    };
    let law = format!(
        "{}: u = −K x, K = ({}), one command every {} s, at most {} A\n",
        result.model,
        result.gains.map(|gain| significant(gain, 9)).join(", "),
        result.sample_time_s,
        result.current_limit_a,
    );
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

/// What the generator is told. Ranges are those of the thesis bench, and so are sensors and drive
/// where they are not calibrated.
fn spec(designed: &ModelDesign) -> ModuleSpec {
    let design = &designed.design;
    let calibration = &designed.file.calibration.unwrap_or_default();
    let rows = |value: &dyn Fn(usize, usize) -> f64| {
        [0, 1, 2].map(|row| [0, 1, 2].map(|column| value(row, column)))
    };
    ModuleSpec {
        model_name: designed.name(),
        gains: [0, 1, 2].map(|index| design.gains[index]),
        current_limit_a: designed.wishes.current_limit_a,
        sample_time_s: designed.wishes.sample_time_s,
        ranges: PhysicalRanges::THESIS_BENCH,
        drive: drive(calibration),
        hardware: hardware(calibration),
        parameters: designed
            .file
            .parameters
            .iter()
            .map(|parameter| Parameter {
                name: parameter.name.clone(),
                value: parameter.value,
                std: parameter.std,
                unit: parameter.unit.clone(),
            })
            .collect(),
        state_weights: designed.wishes.state_weights,
        current_weight: designed.wishes.current_weight,
        a: rows(&|row, column| design.model.state[(row, column)]),
        b: [0, 1, 2].map(|row| design.model.input[row]),
        ad: rows(&|row, column| design.discrete.state[(row, column)]),
        bd: [0, 1, 2].map(|row| design.discrete.input[row]),
        closed_loop: None,
    }
}

/// The sensors of the thesis bench, with the calibrated ones in their places.
fn hardware(calibration: &Calibration) -> HardwareSpec {
    let mut hardware = HardwareSpec::thesis_bench();
    let attitude = &mut hardware.attitude;
    let alignment = calibration
        .mounting
        .map_or_else(Rotation3::identity, |mounting| {
            calibrate::alignment(&mounting.axis.into())
        });
    for (line, calibrated) in [
        (&mut attitude.gyro, &calibration.gyroscope),
        (&mut attitude.accel, &calibration.accelerometer),
        (&mut attitude.mag, &calibration.magnetometer),
    ] {
        if let Some(sensor) = calibrated {
            line.bias_counts = sensor.bias_counts.into();
            line.matrix = Matrix3::from_fn(|row, column| sensor.matrix[row][column]);
        }
        line.matrix = alignment.matrix() * line.matrix;
    }
    if let Some(beta) = calibration.beta_rad_s {
        attitude.beta_rad_s = beta;
    }
    if let Some(mounting) = calibration.mounting {
        attitude.mounting_angle_rad = mounting.angle_rad;
    }
    if let Some(line) = calibration.wheel_speed {
        hardware.wheel_speed_per_count = line.slope;
        hardware.wheel_speed_at_zero = line.offset;
    }
    hardware
}

/// The drive of the thesis bench, its line as calibrated: the largest duty stays, and the current
/// that it stands for follows.
fn drive(calibration: &Calibration) -> Drive {
    let thesis = Drive::THESIS_BENCH;
    let Some(line) = calibration.duty else {
        return thesis;
    };
    let duty_zero = line.offset.round().clamp(0.0, f64::from(thesis.duty_max)) as u16;
    Drive {
        current_range_a: f64::from(thesis.duty_max - duty_zero) / line.slope,
        duty_zero,
        ..thesis
    }
}
