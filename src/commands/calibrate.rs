//! `flywheel calibrate BENCH`

use std::path::PathBuf;

use bench_files::{CalibrationRecordings, ModelFile, Problem};
use serde::Serialize;
use workbench::{SensorCalibrationReport, calibrate};

use crate::arguments::{BenchFiles, JsonOutput};
use crate::failure::Failure;
use crate::report::{Report, listed, write_files};
use crate::views::calibration;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// The bench: a folder with a bench.toml that has a [calibration] section, or that file
    pub bench: PathBuf,
    #[command(flatten)]
    pub files: BenchFiles,
    #[command(flatten)]
    pub output: JsonOutput,
}

#[derive(Serialize)]
struct Calibrated<'a> {
    model: PathBuf,
    #[serde(flatten)]
    report: &'a SensorCalibrationReport,
    figures: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let recordings = CalibrationRecordings::load(&arguments.bench)?;
    let beside = |name: &str| recordings.folder.join(name);
    let model = arguments.files.model.clone();
    let model = model.unwrap_or_else(|| beside("model.toml"));
    let out = arguments.files.out.clone();
    let out = out.unwrap_or_else(|| beside("out"));

    let report = calibrate(&recordings)?;
    let mut file = match ModelFile::read(&model) {
        Ok(file) => file,
        Err(error) if matches!(error.problem(), Problem::NotFound) => ModelFile::new(),
        Err(error) => return Err(error.into()),
    };
    if let Some(hardware) = &recordings.hardware {
        file.hardware = Some(hardware.clone());
    }
    report.apply_to(&mut file);
    let figures = write_files(&out, &report.drawings())?;
    file.write(&model)?;
    let text = calibration::text(&report)
        + &format!("\nWritten: {}\n", model.display())
        + &listed(&figures);
    Report::new(
        text,
        &Calibrated {
            model,
            report: &report,
            figures,
        },
    )
}
