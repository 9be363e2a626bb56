//! The design of a controller from a model.toml, as `design` and `generate` use it.

use std::f64::consts::PI;
use std::path::Path;

use bench_files::{DesignSection, ModelFile};
use design::{Design, FrictionExtremes, Settings, Weights};
use plant::{LinearModel, Linearised, Model, Smoothing};

use crate::failure::Failure;

/// A model.toml with the controller that it asks for.
pub struct ModelDesign {
    /// The file.
    pub file: ModelFile,
    /// What it asks for.
    pub wishes: DesignSection,
    /// Its effects.
    pub model: Model,
    /// Its parameter vector, SI units.
    pub values: Vec<f64>,
    /// The controller and what can be expected of it.
    pub design: Design,
}

impl ModelDesign {
    /// Reads the file and designs the controller.
    pub fn new(path: &Path) -> Result<ModelDesign, Failure> {
        ModelDesign::of(ModelFile::read(path)?, path)
    }

    /// Designs the controller of a file that was read already, or is to be written to `path`.
    pub fn of(file: ModelFile, path: &Path) -> Result<ModelDesign, Failure> {
        let wishes = file.require_design()?;
        let model = file.model();
        let values = file.parameter_vector()?;
        let iota = wishes.friction_linearisation_speed_rad_s;
        let upright = |values: &[f64], iota| linearise(&model, values, iota);
        let in_file = |error: String| Failure::in_file(path, error);
        let linear = upright(&values, iota).map_err(in_file)?;

        let dry = model
            .effects()
            .iter()
            .any(|effect| effect.info().linearised == Linearised::AsDryFriction);
        let friction_extremes = if dry {
            // Without a stated speed, "all of it" is the slope that the simulations have at rest.
            let steepest = iota.unwrap_or(Smoothing::SIMULATION.body_rad_s);
            Some(FrictionExtremes {
                none: upright(&values, None).map_err(in_file)?,
                all: upright(&values, Some(steepest)).map_err(in_file)?,
                smoothing_speed_rad_s: steepest,
            })
        } else {
            None
        };
        let settings = Settings {
            sample_time_s: wishes.sample_time_s,
            weights: Weights {
                state: wishes.state_weights.into(),
                current: wishes.current_weight,
            },
            current_limit_a: wishes.current_limit_a,
            friction_extremes,
        };
        let design =
            Design::new(&linear, &settings).map_err(|error| Failure::in_file(path, error))?;
        Ok(ModelDesign {
            file,
            wishes,
            model,
            values,
            design,
        })
    }

    /// The linear model that other parameter values give.
    pub fn linearise(&self, values: &[f64]) -> Result<LinearModel, String> {
        linearise(
            &self.model,
            values,
            self.wishes.friction_linearisation_speed_rad_s,
        )
    }

    /// A name for the model: that of its file, or of its folder where the file is a model.toml.
    pub fn name(&self) -> String {
        let path = self.file.path();
        let stem = path.file_stem().map(|stem| stem.to_string_lossy());
        let folder = || {
            let path = path.canonicalize().ok()?;
            Some(path.parent()?.file_name()?.to_string_lossy().into_owned())
        };
        match stem {
            Some(stem) if stem != "model" => stem.into_owned(),
            _ => folder().unwrap_or_else(|| "model".to_owned()),
        }
    }
}

fn linearise(model: &Model, values: &[f64], iota: Option<f64>) -> Result<LinearModel, String> {
    plant::linearise(model, values, PI, iota).map_err(|error| error.to_string())
}
