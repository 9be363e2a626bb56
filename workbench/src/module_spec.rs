//! The inputs of the generator for a model: the only place where a model.toml becomes a
//! [`ModuleSpec`].

use codegen::hardware::{BiasObserverSpec, HardwareSpec, RateNeeds};
use codegen::spec::{ModelParameter, ModuleSpec, ParameterCorrelation, PhysicalRanges};
use design::BiasObserver;
use nalgebra::Vector3;
use simulate::Sensors;

use crate::bench_hardware::{BenchHardware, HardwareError, Preset, bench_hardware};
use crate::control_design::ControlDesign;
use crate::error::Error;

/// Limit of the estimated bias of the angle, rad: 5.7°. A calibrated sensor has a smaller
/// bias; at this one, the loop still has nearly two thirds of the angle that its current limit allows.
const BIAS_LIMIT_RAD: f64 = 0.1;

impl ControlDesign {
    /// The inputs of the generator. Sensors and drive are those that the model states; `preset` fills in
    /// what the model does not state.
    ///
    /// # Errors
    /// [`Error::Hardware`] if sensors or drive are not stated, or contradict each other;
    /// [`Error::Design`] if the model allows no observer of the angle's bias.
    pub fn module_spec(&self, preset: Option<Preset>) -> Result<ModuleSpec, Error> {
        self.module_spec_with(self.hardware(preset)?)
    }

    /// The sensors and the drive of the model's bench.
    pub(crate) fn hardware(&self, preset: Option<Preset>) -> Result<BenchHardware, Error> {
        bench_hardware(self.file(), self.rate_needs(), preset).map_err(|source| Error::Hardware {
            model: self.path(),
            source,
        })
    }

    /// The loop's requirements for an encoder on the pivot.
    pub(crate) fn rate_needs(&self) -> RateNeeds {
        let (design, wishes) = (self.design(), self.wishes());
        RateNeeds {
            sample_time_s: wishes.sample_time_s,
            rate_gain: design.gains[1],
            current_limit_a: wishes.current_limit_a,
            delay_margin_s: design.margins.delay_margin_s,
        }
    }

    /// The sensors and the drive for a simulation. The bench of the thesis replaces hardware that is not stated, or
    /// that cannot be emitted.
    pub(crate) fn hardware_for_simulation(&self) -> Result<BenchHardware, Error> {
        let preset = Some(Preset::ThesisBench);
        match self.hardware(preset) {
            Err(Error::Hardware {
                source: HardwareError::NotEmitted(reason),
                model,
            }) => {
                let mut file = self.file().clone();
                file.hardware = None;
                let mut found = bench_hardware(&file, self.rate_needs(), preset)
                    .map_err(|source| Error::Hardware { model, source })?;
                found.assumed.insert(0, reason);
                Ok(found)
            }
            other => other,
        }
    }

    /// The inputs of the generator for a bench with these sensors and this drive.
    pub(crate) fn module_spec_with(&self, found: BenchHardware) -> Result<ModuleSpec, Error> {
        let design = self.design();
        let wishes = self.wishes();
        let rows = |value: &dyn Fn(usize, usize) -> f64| {
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| value(row, column)))
        };
        if found.sensors.body_encoder().is_some() && wishes.bias_time_constant_s.is_some() {
            return Err(Error::Hardware {
                model: self.path(),
                source: HardwareError::Contradiction(
                    "bias_time_constant of [design] is for inertial sensors, whose angle drifts; the angle \
                     of an encoder does not: leave bias_time_constant out, and state the count upright as \
                     zero under [hardware.angle]"
                        .to_owned(),
                ),
            });
        }
        let hardware = HardwareSpec {
            bias_observer: bias_observer(self)?,
            ..found.sensors
        };
        Ok(ModuleSpec {
            model_name: self.name().to_owned(),
            gains: [0, 1, 2].map(|index| design.gains[index]),
            current_limit_a: wishes.current_limit_a,
            sample_time_s: wishes.sample_time_s,
            ranges: PhysicalRanges::of(&hardware),
            drive: found.drive,
            hardware,
            assumed: found.assumed,
            parameters: self
                .file()
                .parameters
                .iter()
                .map(|parameter| ModelParameter {
                    name: parameter.name.clone(),
                    value: parameter.value,
                    std: parameter.std,
                    unit: parameter.unit.clone(),
                })
                .collect(),
            correlation: self
                .file()
                .correlation
                .as_ref()
                .map(|known| ParameterCorrelation {
                    parameters: known.parameters.clone(),
                    matrix: known.matrix.clone(),
                }),
            state_weights: wishes.state_weights,
            current_weight: wishes.current_weight,
            a: rows(&|row, column| design.model.state[(row, column)]),
            b: [0, 1, 2].map(|row| design.model.input[row]),
            ad: rows(&|row, column| design.discrete.state[(row, column)]),
            bd: [0, 1, 2].map(|row| design.discrete.input[row]),
            closed_loop: None,
        })
    }
}

/// The observer for `bias_time_constant`. Only the ratios of the sensors' noise matter;
/// they are those of the simulated sensors.
fn bias_observer(designed: &ControlDesign) -> Result<Option<BiasObserverSpec>, Error> {
    let wishes = designed.wishes();
    let Some(time_constant_s) = wishes.bias_time_constant_s else {
        return Ok(None);
    };
    let noise = Vector3::from(simulated_noise());
    let observer = BiasObserver::new(
        &designed.design().model,
        wishes.sample_time_s,
        time_constant_s,
        &noise,
    )
    .map_err(|source| designed.design_error(source))?;
    Ok(Some(BiasObserverSpec {
        decay: observer.decay,
        direct: observer.direct.into(),
        from_states: observer.from_measurement.into(),
        from_current: observer.from_current,
        limit_rad: BIAS_LIMIT_RAD,
    }))
}

/// Standard deviations of the simulated sensors: angle (rad), rate and wheel speed (rad/s).
pub(crate) fn simulated_noise() -> [f64; 3] {
    let sensors = Sensors::of_the_thesis();
    [
        sensors.angle.noise_std,
        sensors.rate.noise_std,
        sensors.wheel_speed.noise_std,
    ]
}
