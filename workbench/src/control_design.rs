//! A controller for a model: its gains, and the results that follow from them.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use bench_files::{DesignSection, ModelFile, OWN_PREFIX};
use design::{Design, DesignError, FrictionExtremes, Settings, Weights};
use plant::{EffectId, LinearModel, Linearised, Model, Smoothing};

use crate::error::Error;
use crate::session::Session;
use crate::words;

/// A model with its linear-quadratic controller.
///
/// Next steps: [`ControlDesign::report`] (poles, margins, sizing), [`ControlDesign::generate`]
/// (the controller in fixed point), [`ControlDesign::simulate`] (the closed loop).
#[derive(Clone, Debug)]
pub struct ControlDesign {
    file: ModelFile,
    name: String,
    wishes: DesignSection,
    model: Model,
    values: Vec<f64>,
    design: Design,
}

impl Session {
    /// Designs the controller for the model's `[design]` section, or the usual one if there is
    /// none (see [`Session::usual_design`]).
    ///
    /// # Errors
    /// [`Error::NoModel`]; a missing parameter; [`Error::Design`] if the weights give no controller.
    pub fn design(&self) -> Result<ControlDesign, Error> {
        let wishes = self.required_model()?.design;
        self.design_for(wishes.unwrap_or_else(|| self.usual_design()))
    }

    /// Designs the controller for the weights, sample time and current limit in `wishes`.
    ///
    /// # Errors
    /// [`Error::NoModel`]; a missing parameter; [`Error::Design`] if the weights give no controller.
    pub fn design_for(&self, wishes: DesignSection) -> Result<ControlDesign, Error> {
        let mut file = self.required_model()?.clone().named(self.model_path());
        file.design = Some(wishes);
        let name = if self.bench().folder.as_os_str().is_empty() {
            self.bench().name.clone()
        } else {
            name_of(self.model_path())
        };
        ControlDesign::new(file, name)
    }
}

impl ControlDesign {
    /// Reads a model.toml and designs the controller for its `[design]` section.
    ///
    /// # Errors
    /// An error in the file; [`Error::Design`] if its weights give no controller.
    pub fn read(path: &Path) -> Result<ControlDesign, Error> {
        ControlDesign::of(ModelFile::read(path)?)
    }

    /// Designs the controller for the `[design]` section of a model.
    ///
    /// # Errors
    /// A missing `[design]` or parameter; [`Error::Linearise`]; [`Error::Design`] if the weights give no controller.
    pub fn of(file: ModelFile) -> Result<ControlDesign, Error> {
        let name = name_of(file.path());
        ControlDesign::new(file, name)
    }

    /// The design of the same model for other wishes.
    ///
    /// # Errors
    /// [`Error::Design`] if the weights give no controller.
    pub fn with_wishes(&self, wishes: DesignSection) -> Result<ControlDesign, Error> {
        let mut file = self.file.clone();
        file.design = Some(wishes);
        ControlDesign::new(file, self.name.clone())
    }

    /// The delay of the current by the model's effect `input-delay`, s; 0 without it.
    pub(crate) fn own_delay_s(&self) -> f64 {
        let plant = plant::Plant::new(&self.model, &self.values, plant::Kind::Balance);
        plant.delay_s().unwrap_or(0.0)
    }

    fn new(file: ModelFile, name: String) -> Result<ControlDesign, Error> {
        let wishes = file.require_design()?;
        let model = file.model();
        let values = file.parameter_vector()?;
        let path = file.path().to_path_buf();
        refuse_open_scale(&file)?;
        let iota = wishes.friction_linearisation_speed_rad_s;
        let model_upright = file.model_upright();
        let upright = |iota| {
            linearise(&model, &model_upright, &values, iota).map_err(|reason| Error::Linearise {
                model: path.clone(),
                reason,
            })
        };
        let linear = upright(iota)?;

        let dry = model
            .effects()
            .iter()
            .any(|effect| effect.info().linearised == Linearised::AsDryFriction);
        let friction_extremes = if dry {
            // Without a stated speed ι, the largest damping is the slope that the simulations have at rest.
            let steepest = iota.unwrap_or(Smoothing::SIMULATION.body_rad_s);
            Some(FrictionExtremes {
                none: upright(None)?,
                all: upright(Some(steepest))?,
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
        let design = Design::new(&linear, &settings).map_err(|source| Error::Design {
            model: path,
            source,
        })?;
        Ok(ControlDesign {
            file,
            name,
            wishes,
            model,
            values,
            design,
        })
    }

    /// The name of the model: its file's name, or the folder's name if the file is called model.toml, or the bench's
    /// name for a model in memory.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reasons to distrust the model, one sentence each: an open tie, or an error that the last diagnosis could not
    /// explain.
    pub(crate) fn cautions(&self) -> Vec<String> {
        let tie = self.file.tie.as_ref().map(|tie| {
            let names = words::set(tie.provisional.iter().map(|effect| effect.name()));
            format!(
                "the model uses {names} provisionally: the logs cannot tell it from its rivals. `flywheel diagnose` names \
                 the experiment that can"
            )
        });
        let verdict = self.file.unexplained.as_ref().map(|sentence| {
            format!(
                "the last diagnosis does not explain the measurements, and the controller inherits this error. {sentence}"
            )
        });
        tie.into_iter().chain(verdict).collect()
    }

    /// The model's file.
    pub fn file(&self) -> &ModelFile {
        &self.file
    }

    /// The requirements of the design.
    pub fn wishes(&self) -> &DesignSection {
        &self.wishes
    }

    /// The structure of the model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Its parameter vector, SI units.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The controller, as the crate `design` has it.
    pub fn design(&self) -> &Design {
        &self.design
    }

    /// K of u = −K x in A/rad, A s/rad, A s/rad.
    pub fn gains(&self) -> [f64; 3] {
        [0, 1, 2].map(|index| self.design.gains[index])
    }

    /// The linear model for other parameter values.
    pub(crate) fn linearise(&self, values: &[f64]) -> Result<LinearModel, String> {
        linearise(
            &self.model,
            &self.file.model_upright(),
            values,
            self.wishes.friction_linearisation_speed_rad_s,
        )
    }

    /// One sentence for each learned curve and each effect of a user: whether the linear model contains its slope.
    pub fn upright_notes(&self) -> Vec<String> {
        let upright = self.file.model_upright();
        let effects = self.model.effects().iter().copied();
        let others = effects.filter(|effect| {
            effect.info().learned.is_some() || effect.name().starts_with(OWN_PREFIX)
        });
        let note = |effect: EffectId| {
            let name = effect.name();
            if effect.info().linearised == Linearised::LeftOut {
                format!(
                    "{name}: left out, because the linear model does not have the wheel's angle"
                )
            } else if upright.has(effect) && plant::has_seen(effect, PI) {
                format!("{name}: included with its slope upright, where the logs have been")
            } else {
                format!("{name}: included with slope zero, because no log shows it upright")
            }
        };
        others.map(note).collect()
    }

    pub(crate) fn path(&self) -> PathBuf {
        self.file.path().to_path_buf()
    }

    pub(crate) fn design_error(&self, source: DesignError) -> Error {
        Error::Design {
            model: self.path(),
            source,
        }
    }
}

/// A name for a model, from its file.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy());
    let folder = || {
        // The file may not have been written yet.
        let whole = path.canonicalize().or_else(|_| {
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder.unwrap_or(Path::new(".")).canonicalize()?;
            Ok::<PathBuf, std::io::Error>(folder.join("model.toml"))
        });
        let whole = whole.ok()?;
        Some(whole.parent()?.file_name()?.to_string_lossy().into_owned())
    };
    match stem {
        Some(stem) if stem != "model" => stem.into_owned(),
        _ => folder().unwrap_or_else(|| "model".to_owned()),
    }
}

/// The linear model of `model` about upright, without the effects that no log has shown there.
fn linearise(
    model: &Model,
    upright: &Model,
    values: &[f64],
    iota: Option<f64>,
) -> Result<LinearModel, String> {
    let infos = upright.parameters();
    let value_of = |name: &str| model.position_of(name).map_or(0.0, |at| values[at]);
    let values: Vec<f64> = infos.iter().map(|info| value_of(info.name)).collect();
    plant::linearise(upright, &values, PI, iota).map_err(|error| error.to_string())
}

/// Rejects a model whose inertias are not known on one scale. If no log relates the wheel to the body, one of them was
/// set to 1, and no motion of both together can be computed.
///
/// # Errors
/// [`Error::OpenScale`].
fn refuse_open_scale(file: &ModelFile) -> Result<(), Error> {
    let inertias = ["total_inertia", "wheel_inertia"].map(|name| file.parameter(name));
    let [Some(total), Some(wheel)] = inertias else {
        return Ok(());
    };
    let is_set_to_one = wheel.is_per_inertia() && wheel.std.is_none() && wheel.value == 1.0;
    if total.is_per_inertia() == wheel.is_per_inertia() && !is_set_to_one {
        return Ok(());
    }
    let open = [total, wheel]
        .into_iter()
        .filter(|one| one.is_per_inertia());
    let names: Vec<&str> = open.map(|one| one.name.as_str()).collect();
    Err(Error::OpenScale {
        model: file.path().to_path_buf(),
        unknown: names.join(" and "),
    })
}
