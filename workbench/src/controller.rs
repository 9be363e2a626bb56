//! The controller in fixed point: a `no_std` crate with its certificate.

use std::path::{Path, PathBuf};

use checker::certificate::Certificate;
use checker::claims::control_law::EmittedLaw;
use checker::claims::encoder_loop_stable;
use checker::claims::outcome::ClaimOutcome;
use codegen::{CrateName, EmissionOptions, EmittedCrate, FileError, MonitorSpec};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use crate::bench_hardware::{BenchHardware, Preset};
use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::module_spec::simulated_noise;

/// An emitted controller in memory: the result of
/// [`ControlDesign::generate`](crate::ControlDesign::generate).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GeneratedController {
    /// Name of the crate.
    pub name: String,
    /// The model.
    pub model: String,
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Largest current in either direction.
    pub current_limit_a: f64,
    /// Time between two commands.
    pub sample_time_s: f64,
    /// Time constant of the observer of the angle's bias, if the model asks for one.
    pub bias_time_constant_s: Option<f64>,
    /// Properties of sensors and drive that were taken from the preset; sentences.
    pub assumed: Vec<String>,
    /// Properties of sensors and drive that may be wrong; sentences.
    pub warnings: Vec<String>,
    /// The files of the crate, by their paths in it; certificate.json is the last.
    #[serde(skip)]
    emitted: Files,
    /// The text of the model.toml that it was emitted from; empty in a result that was read from JSON.
    #[serde(skip)]
    pub(crate) model_text: String,
}

/// The options of an emitted controller, in addition to its design.
#[derive(Clone, Debug, Default)]
pub struct ControllerOptions {
    /// The bench that supplies what the model does not state; without one, this is an error.
    pub preset: Option<Preset>,
    /// Name of the crate, or of the library in C.
    pub name: CrateName,
    /// Whether a monitor is emitted: a function that says whether the measured motion is one that the model allows. It
    /// is silent at the noise of the simulated sensors.
    pub has_monitor: bool,
}

/// The emitted files; none in a result that was read from JSON.
#[derive(Clone, Debug, PartialEq)]
struct Files(EmittedCrate);

impl Default for Files {
    fn default() -> Files {
        Files(EmittedCrate { files: Vec::new() })
    }
}

impl ControlDesign {
    /// Emits the controller as readable `no_std` Rust in fixed point, from raw sensor counts to the
    /// duty of the drive, with a certificate. Properties of sensors and drive that the model does not state are
    /// taken from `preset`, and listed in the result; without a preset, they are an error.
    ///
    /// # Errors
    /// [`Error::Hardware`] if sensors or drive are not stated, or contradict each other;
    /// [`Error::Refused`] if a claim could not be kept; [`Error::Design`] if the requested observer of
    /// the angle's bias does not work.
    pub fn generate(&self, preset: Option<Preset>) -> Result<GeneratedController, Error> {
        self.generate_with(&ControllerOptions {
            preset,
            ..ControllerOptions::default()
        })
    }

    /// Emits the controller like [`ControlDesign::generate`], with the name, the preset and the monitor of `options`.
    ///
    /// # Errors
    /// As for [`ControlDesign::generate`]; [`Error::Refused`] too if a monitor is wanted and no bound of the model's
    /// motion is known.
    pub fn generate_with(&self, options: &ControllerOptions) -> Result<GeneratedController, Error> {
        let noise_std = simulated_noise();
        self.emitted(
            self.hardware(options.preset)?,
            &EmissionOptions {
                name: options.name.clone(),
                monitor: options.has_monitor.then_some(MonitorSpec { noise_std }),
            },
        )
    }

    /// Emits the controller for these sensors and this drive, under the default name and without a monitor.
    pub(crate) fn generate_for(
        &self,
        hardware: BenchHardware,
    ) -> Result<GeneratedController, Error> {
        self.emitted(hardware, &EmissionOptions::default())
    }

    fn emitted(
        &self,
        hardware: BenchHardware,
        options: &EmissionOptions,
    ) -> Result<GeneratedController, Error> {
        let assumed = hardware.assumed.clone();
        let mut warnings = self.cautions();
        warnings.extend(hardware.warnings.iter().cloned());
        let spec = self.module_spec_with(hardware)?;
        let emitted = codegen::generate_with(&spec, options).map_err(|source| Error::Refused {
            model: self.path(),
            source: Box::new(source),
        })?;
        let controller = GeneratedController {
            name: options.name.to_string(),
            model: spec.model_name.clone(),
            gains: spec.gains,
            current_limit_a: spec.current_limit_a,
            sample_time_s: spec.sample_time_s,
            bias_time_constant_s: self.wishes().bias_time_constant_s,
            assumed,
            warnings,
            emitted: Files(emitted),
            model_text: self.file().to_toml(),
        };
        controller.check_signs(&self.path())?;
        Ok(controller)
    }
}

impl GeneratedController {
    /// The same controller as a C99 library, for Arduino, PlatformIO or any firmware in C: a header, a source file, and
    /// the certificate, which states that the language is C. `prove` reads the Rust version.
    ///
    /// # Errors
    /// [`Error::Emitted`] if the emitted Rust contains something that the translation does not support, which is a
    /// fault of this program.
    pub fn in_c(&self) -> Result<GeneratedController, Error> {
        let emitted = codegen::c99::emit(&self.emitted.0).map_err(|error| Error::Emitted {
            model: PathBuf::from(&self.model),
            reason: error.to_string(),
        })?;
        Ok(GeneratedController {
            emitted: Files(emitted),
            ..self.clone()
        })
    }

    /// Path inside the crate and text of every file; certificate.json is the last.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        let files = self.emitted.0.files.iter();
        files.map(|file| (file.path.as_str(), file.contents.as_str()))
    }

    /// Path inside the crate and text of each source of the controller, without those of its harness crate.
    pub fn sources(&self) -> impl Iterator<Item = (&str, &str)> {
        self.emitted.0.sources()
    }

    /// Writes the crate into a folder (created if missing), removes the files that an earlier emission has left there, and
    /// returns the files that were written or removed.
    ///
    /// # Errors
    /// [`Error::EmittedFiles`] if a file is in the way that this program did not write, or the folder
    /// cannot be written to; then nothing is changed.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        Ok(self.emitted.0.write(folder)?)
    }

    /// The files of a folder that are missing, differ from those that [`GeneratedController::write`] would write, or
    /// are left over from another emission.
    ///
    /// # Errors
    /// [`Error::EmittedFiles`] if one cannot be read.
    pub fn differing(&self, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        match self.emitted.0.check(folder) {
            Ok(()) => Ok(Vec::new()),
            Err(FileError::Differs { paths }) => Ok(paths),
            Err(error) => Err(error.into()),
        }
    }

    /// Checks the claim `physical-signs` before anything is written: a controller that fails it must not be flashed.
    fn check_signs(&self, model: &Path) -> Result<(), Error> {
        let module = self.module(model)?;
        let certificate = self.certificate(model)?;
        let unphysical = |reason: String| Error::Unphysical {
            model: model.to_path_buf(),
            reason,
        };
        checker::claims::physical_signs::check(&certificate, &module).map_err(unphysical)?;
        if certificate.hardware.body_encoder().is_none() {
            return Ok(());
        }
        // The rate of an encoder is half a window late, and the design has ignored this delay.
        let law = EmittedLaw::read(&module).map_err(|error| unphysical(error.to_string()))?;
        match encoder_loop_stable::by_exact_arithmetic(&certificate, &law) {
            ClaimOutcome::Failed(why) => Err(unphysical(format!(
                "the rate of the encoder on the pivot is half a window late, and {why}; use an encoder with more \
                 counts per turn, a shorter sample time or smaller gains (a larger current_weight)"
            ))),
            _ => Ok(()),
        }
    }

    fn certificate(&self, model: &Path) -> Result<Certificate, Error> {
        let mut files = self.files();
        let found = files.find(|(path, _)| *path == "certificate.json");
        let text = found.map_or("", |(_, text)| text);
        Certificate::parse(text).map_err(|error| Error::Emitted {
            model: model.to_path_buf(),
            reason: error.to_string(),
        })
    }

    /// The emitted source, as the checker reads it.
    pub(crate) fn module(&self, model: &Path) -> Result<checker::Module, Error> {
        let sources: Vec<(&str, &str)> = self.sources().collect();
        checker::Module::parse(&sources).map_err(|error| Error::Emitted {
            model: model.to_path_buf(),
            reason: format!("source: {error}"),
        })
    }

    /// The matrix P of the certificate's ellipsoid xᵀ P x ≤ 1, in which no command saturates, if it has one.
    pub(crate) fn ellipsoid(&self, model: &Path) -> Result<Option<Matrix3<f64>>, Error> {
        Ok(self.certificate(model)?.closed_loop.map(|found| {
            let rows = found.ellipsoid;
            // Every decimal of the certificate is a finite number.
            let entry = |row: usize, column: usize| rows[row][column].to_string().parse();
            Matrix3::from_fn(|row, column| entry(row, column).unwrap_or(f64::NAN))
        }))
    }
}
