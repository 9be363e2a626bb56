//! The motion of the controlled pendulum, fast enough for a slider.

use plant::{Kind, Plant};
use serde::Serialize;
use simulate::scenario::Scale;
use simulate::{ClosedLoop, ExactLaw, LoopTrace, Motion, Scenario, Sensors};

use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::simulated_drive::{actuator_of, supplied};

/// A run of the law in floating point on the nonlinear bench, with the noise of its sensors. For the emitted law,
/// see [`ControlDesign::simulate`].
#[derive(Clone, Debug, Serialize)]
pub struct LoopResponse {
    /// `transient` or `disturbance`.
    pub scenario: String,
    /// The scenario in one sentence.
    pub about: String,
    /// Whether the body fell.
    pub fell: bool,
    /// Time of the samples, s.
    pub time_s: Vec<f64>,
    /// Body angle from upright.
    pub angle_rad: Vec<f64>,
    /// Speed of the wheel relative to the body.
    pub wheel_speed_rad_s: Vec<f64>,
    /// Commanded current.
    pub current_a: Vec<f64>,
}

/// Seed of the sensors' noise: the same noise for every design, so that designs can be compared.
const SEED: u64 = 1;

impl ControlDesign {
    /// The two shorter runs of [`ControlDesign::simulate`], release and push, without emitting the law.
    ///
    /// # Errors
    /// [`Error::Simulate`].
    pub fn responses(&self) -> Result<Vec<LoopResponse>, Error> {
        let failed = |source| self.simulate_error(source);
        let wishes = self.wishes();
        let drive = self.drive_for_simulation();
        let (model, values) = supplied(self.model(), self.values(), &drive);
        let plant = Plant::new(&model, &values, Kind::Balance);
        let scale = Scale::new(self.values(), wishes.current_limit_a).map_err(failed)?;
        let bench = ClosedLoop {
            motion: Motion::Nonlinear(&plant),
            sensors: Sensors::of_the_thesis(),
            actuator: actuator_of(&drive),
            sample_time_s: wishes.sample_time_s,
            computation_s: 0.0,
            pushes: Vec::new(),
            seed: SEED,
        };
        [Scenario::transient(&scale), Scenario::disturbance(&scale)]
            .iter()
            .map(|scenario| {
                let mut law = ExactLaw {
                    gains: self.design().gains,
                    limit_a: wishes.current_limit_a,
                };
                let traces = scenario.run(&bench, &mut [&mut law]).map_err(failed)?;
                let trace = traces.into_iter().next().unwrap_or_default();
                Ok(LoopResponse::of(scenario, trace))
            })
            .collect()
    }
}

impl LoopResponse {
    fn of(scenario: &Scenario, trace: LoopTrace) -> LoopResponse {
        LoopResponse {
            scenario: scenario.name.to_owned(),
            about: scenario.about.to_owned(),
            fell: trace.fell_at_s.is_some(),
            time_s: trace.time_s,
            angle_rad: trace.angle_rad,
            wheel_speed_rad_s: trace.wheel_speed_rad_s,
            current_a: trace.current_a,
        }
    }
}
