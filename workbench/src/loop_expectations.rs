//! Properties of a designed loop before anything is generated: over frequency, under torques and noise, and the largest
//! start from which it recovers.

use bench_files::DesignSection;
use design::{
    BandedResponse, DisturbanceTorque, Excursions, LinearController, LoopFrequency,
    ResponseSettings, SensorNoise, UncertainLoop, Weights, banded_response, drawn_plants,
    frequency_response, linear_response, margins_with_delay, noise_in_loop,
};
use nalgebra::{DMatrix, Vector3};
use plant::{
    GRAVITY_TORQUE, Kind, Plant, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA, torque_inputs,
};
use serde::{Deserialize, Serialize};
use simulate::scenario::Scale;
use simulate::{Actuator, ClosedLoop, ExactLaw, Motion, Sensors, largest_recoverable_angle};

use crate::control_design::ControlDesign;
use crate::design_report::LoopMargins;
use crate::error::Error;
use crate::sensor_noise::BenchNoise;
use crate::simulated_drive::{actuator_of, supplied};

/// Parameter sets drawn for the bands.
const DRAWN_SETS: usize = 200;
/// Seed of that draw.
const SEED: u64 = 1;
/// Points of a response.
const POINTS: usize = 300;
/// Frequencies of the open loop.
const FREQUENCIES: usize = 400;
/// Torque of the step, as a share of the motor's largest torque. A tenth leaves nine tenths for everything else.
const STEP_SHARE: f64 = 0.1;
/// A response is shown over this many time constants of the slowest motion of the loop. If all three poles coincide,
/// e⁻¹⁰ (1 + 10 + 50) = 0.3 % of the motion then remains.
const TIME_CONSTANTS: f64 = 10.0;
/// Shortest and longest duration of a response, s.
const DURATION_S: (f64, f64) = (0.5, 40.0);
/// Resolution of the largest recoverable angle, rad: a fiftieth of a degree.
const ANGLE_RESOLUTION_RAD: f64 = 3.5e-4;

/// Settings of the expectations, in addition to the model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExpectationSettings {
    /// Delay of the current in s, in addition to the delay of the model.
    pub delay_s: f64,
    /// The noise of the bench's sensors. For a sensor without a known noise, that of the thesis bench is used.
    pub noise: BenchNoise,
}

/// Properties of a loop: the result of [`ControlDesign::expectations`]. The curves are not part of the JSON; the
/// figures have them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopExpectations {
    /// The excursions that have equal cost with these weights (Bryson's rule).
    pub excursions: AllowedExcursions,
    /// Delay of the current in s: the delay in the model plus the delay that was asked for.
    pub delay_s: f64,
    /// Whether the loop is stable with that delay. If it is not, all fields below are `None`.
    pub stable: bool,
    /// Margins of the loop with that delay; the delay margin is a further delay.
    pub margins: Option<LoopMargins>,
    /// The frequency in rad/s at which the open loop has the magnitude 1, with the smallest phase margin.
    pub crossover_rad_s: Option<f64>,
    /// Largest angle at rest from which the nonlinear bench comes up under this law, with that delay and no noise.
    pub recoverable_angle_rad: Option<f64>,
    /// The response to a constant torque that begins at time zero.
    pub step: Option<TorqueAnswer>,
    /// The response to a push.
    pub push: Option<TorqueAnswer>,
    /// The effect of the sensors' noise.
    pub noise: Option<NoiseExpectation>,
    /// The open loop.
    #[serde(skip)]
    pub frequencies: Vec<LoopFrequency>,
}

/// The excursions that have equal cost; infinite (null) for a quantity without weight.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedExcursions {
    /// Angle.
    #[serde(with = "crate::named::unbounded")]
    pub angle_rad: f64,
    /// Rate.
    #[serde(with = "crate::named::unbounded")]
    pub rate_rad_s: f64,
    /// Wheel speed.
    #[serde(with = "crate::named::unbounded")]
    pub wheel_speed_rad_s: f64,
    /// Current.
    #[serde(with = "crate::named::unbounded")]
    pub current_a: f64,
}

/// The linear loop's response to a torque on the body.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TorqueAnswer {
    /// Size of the torque in N m; for a push, its impulse in N m s. Both are per kg m² on a bench whose torques are
    /// known only per unit of inertia.
    pub size: f64,
    /// Unit of `size`.
    pub unit: String,
    /// Largest angle.
    pub largest_angle_rad: f64,
    /// The band of the largest angle: the ends between which 95 % of the parameter sets lie. `None` if the parameters
    /// have no errors.
    pub largest_angle_band_rad: Option<[f64; 2]>,
    /// Largest wheel speed.
    pub largest_wheel_speed_rad_s: f64,
    /// Largest current of the loop without a current limit.
    pub largest_current_a: f64,
    /// The curves.
    #[serde(skip)]
    pub curves: BandedResponse,
}

/// Noise in the loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseExpectation {
    /// Standard deviations of the sensors' noise in a sample: rad, rad/s, rad/s.
    pub sensors: [f64; 3],
    /// The source of each of these numbers: an experiment, or the assumption.
    pub sources: [String; 3],
    /// Standard deviation of the true angle.
    pub angle_rad: f64,
    /// Standard deviation of the wheel speed.
    pub wheel_speed_rad_s: f64,
    /// Standard deviation of the commanded current.
    pub current_a: f64,
}

impl ControlDesign {
    /// The properties of the loop. Takes a few hundredths of a second.
    ///
    /// # Errors
    /// [`Error::Design`] if a number is not finite; [`Error::Simulate`].
    pub fn expectations(&self, settings: &ExpectationSettings) -> Result<LoopExpectations, Error> {
        let (a, b) = self.matrices();
        let (gains, sample_time_s) = (self.design().gains, self.wishes().sample_time_s);
        let controller = LinearController::state_feedback(&gains);
        let in_design = |source| self.design_error(source);
        let drive = self.drive_for_simulation();
        let (model, values) = supplied(self.model(), self.values(), &drive);
        let plant = Plant::new(&model, &values, Kind::Balance);
        let delay_s = settings.delay_s + plant.delay_s().unwrap_or(0.0);
        let frequencies =
            frequency_response(&a, &b, &controller, sample_time_s, delay_s, FREQUENCIES)
                .map_err(in_design)?;
        let mut found = LoopExpectations {
            excursions: AllowedExcursions::of(self.wishes()),
            delay_s,
            stable: false,
            margins: None,
            crossover_rad_s: None,
            recoverable_angle_rad: None,
            step: None,
            push: None,
            noise: None,
            frequencies,
        };
        let margins = match margins_with_delay(&a, &b, &controller, sample_time_s, delay_s) {
            Ok(margins) => margins,
            Err(design::DesignError::UnstableLoop { .. }) => return Ok(found),
            Err(error) => return Err(in_design(error)),
        };
        found.stable = true;
        found.crossover_rad_s = Some(margins.crossover_rad_s).filter(|value| value.is_finite());
        found.margins = Some(LoopMargins::of(&margins));
        let actuator = actuator_of(&drive);
        found.recoverable_angle_rad =
            Some(self.recoverable_angle_rad(&plant, actuator, settings.delay_s)?);
        let (step, push) = self.torque_answers(delay_s)?;
        (found.step, found.push) = (Some(step), Some(push));
        found.noise = Some(self.noise_expectation(delay_s, &settings.noise)?);
        Ok(found)
    }

    /// A (3×3) and B (3×1) of the linear model.
    pub(crate) fn matrices(&self) -> (DMatrix<f64>, DMatrix<f64>) {
        let model = &self.design().model;
        (
            DMatrix::from_iterator(3, 3, model.state.iter().copied()),
            DMatrix::from_iterator(3, 1, model.input.iter().copied()),
        )
    }

    fn recoverable_angle_rad(
        &self,
        plant: &Plant<f64>,
        actuator: Actuator,
        computation_s: f64,
    ) -> Result<f64, Error> {
        let failed = |source| self.simulate_error(source);
        let limit_a = self.wishes().current_limit_a;
        let scale = Scale::new(self.values(), limit_a).map_err(failed)?;
        let bench = ClosedLoop {
            motion: Motion::Nonlinear(plant),
            sensors: Sensors::PERFECT,
            actuator: Actuator {
                limit_a: actuator.limit_a.min(limit_a),
                step_a: 0.0,
            },
            sample_time_s: self.wishes().sample_time_s,
            computation_s,
            pushes: Vec::new(),
            seed: SEED,
        };
        let mut law = ExactLaw {
            gains: self.design().gains,
            limit_a,
        };
        largest_recoverable_angle(&bench, &scale, &mut law, ANGLE_RESOLUTION_RAD)
            .map(|found| found.recovered_rad)
            .map_err(failed)
    }

    /// The responses to a step and to a push, with bands if the model states errors of its parameters.
    fn torque_answers(&self, delay_s: f64) -> Result<(TorqueAnswer, TorqueAnswer), Error> {
        let in_design = |source| self.design_error(source);
        let nominal = UncertainLoop {
            model: self.design().model,
            torque_input: self.torque_input(self.values()),
        };
        let plant_of = |values: &[f64]| {
            let model = self.linearise(values).ok()?;
            let torque_input = self.torque_input(values);
            torque_input
                .iter()
                .all(|entry| entry.is_finite())
                .then_some(UncertainLoop {
                    model,
                    torque_input,
                })
        };
        let drawn = match self.uncertain_parameters() {
            Some(parameters) => {
                drawn_plants(&parameters, &plant_of, DRAWN_SETS, SEED).map_err(in_design)?
            }
            None => Vec::new(),
        };
        let settings = ResponseSettings {
            sample_time_s: self.wishes().sample_time_s,
            delay_s,
            duration_s: self.response_duration_s(),
            points: POINTS,
        };
        let values = self.values();
        let torque = STEP_SHARE * values[TORQUE_CONSTANT] * self.wishes().current_limit_a;
        // The push has the impulse of the step's torque over the time in which a fall grows by a factor e.
        let inertia = values[TOTAL_INERTIA] - values[WHEEL_INERTIA];
        let impulse = torque * (inertia / values[GRAVITY_TORQUE]).sqrt();
        let of = |disturbance| {
            banded_response(
                &nominal,
                &drawn,
                &self.design().gains,
                &settings,
                disturbance,
            )
            .map_err(in_design)
        };
        let per_inertia = self
            .file()
            .parameter("gravity_torque")
            .is_some_and(|one| one.is_per_inertia());
        let unit = |unit: &str| match per_inertia {
            true => format!("{unit} per kg m2"),
            false => unit.to_owned(),
        };
        Ok((
            TorqueAnswer::of(torque, unit("N m"), of(DisturbanceTorque::Step(torque))?),
            TorqueAnswer::of(
                impulse,
                unit("N m s"),
                of(DisturbanceTorque::Push(impulse))?,
            ),
        ))
    }

    fn torque_input(&self, values: &[f64]) -> Vector3<f64> {
        torque_inputs(self.model(), values)[0]
    }

    /// The duration of a response in s: [`TIME_CONSTANTS`] of the slowest motion, within [`DURATION_S`].
    pub(crate) fn response_duration_s(&self) -> f64 {
        let poles = self.design().closed_loop_poles_per_s();
        let slowest = poles
            .iter()
            .map(|pole| -pole.re)
            .fold(f64::INFINITY, f64::min);
        (TIME_CONSTANTS / slowest).clamp(DURATION_S.0, DURATION_S.1)
    }

    /// The effect of noise on the loop with this delay.
    pub(crate) fn noise_expectation(
        &self,
        delay_s: f64,
        noise: &BenchNoise,
    ) -> Result<NoiseExpectation, Error> {
        let (sensors, sources) = noise.or_assumed();
        let [angle_rad, rate_rad_s, wheel_speed_rad_s] = sensors;
        let found = noise_in_loop(
            &self.design().model,
            &self.design().gains,
            self.wishes().sample_time_s,
            delay_s,
            &SensorNoise {
                angle_rad,
                rate_rad_s,
                wheel_speed_rad_s,
            },
        )
        .map_err(|source| self.design_error(source))?;
        Ok(NoiseExpectation {
            sensors,
            sources,
            angle_rad: found.angle_rad,
            wheel_speed_rad_s: found.wheel_speed_rad_s,
            current_a: found.current_a,
        })
    }

    /// Largest angle in rad of the loop's response to the step of [`LoopExpectations::step`], for a sweep.
    pub(crate) fn largest_angle_of_step_rad(&self, delay_s: f64) -> Result<f64, Error> {
        let torque = STEP_SHARE * self.values()[TORQUE_CONSTANT] * self.wishes().current_limit_a;
        let plant = UncertainLoop {
            model: self.design().model,
            torque_input: self.torque_input(self.values()),
        };
        linear_response(
            &plant,
            &self.design().gains,
            self.wishes().sample_time_s,
            delay_s,
            DisturbanceTorque::Step(torque),
            self.response_duration_s(),
            POINTS,
        )
        .map(|found| largest(&found.angle_rad))
        .map_err(|source| self.design_error(source))
    }
}

impl AllowedExcursions {
    fn of(wishes: &DesignSection) -> AllowedExcursions {
        let allowed = Excursions::of(&Weights {
            state: wishes.state_weights.into(),
            current: wishes.current_weight,
        });
        AllowedExcursions {
            angle_rad: allowed.angle_rad,
            rate_rad_s: allowed.rate_rad_s,
            wheel_speed_rad_s: allowed.wheel_speed_rad_s,
            current_a: allowed.current_a,
        }
    }
}

/// The weights of angle (1/rad²), rate (s²/rad²), wheel speed (s²/rad²) and current (1/A²) that allow these excursions
/// at equal cost: rad, rad/s, rad/s, A (Bryson's rule).
///
/// # Errors
/// A sentence: an excursion that is not positive.
pub fn weights_of_excursions(excursions: [f64; 4]) -> Result<[f64; 4], String> {
    let [angle_rad, rate_rad_s, wheel_speed_rad_s, current_a] = excursions;
    let allowed = Excursions {
        angle_rad,
        rate_rad_s,
        wheel_speed_rad_s,
        current_a,
    };
    let weights = allowed.weights().map_err(|error| error.to_string())?;
    Ok([
        weights.state[0],
        weights.state[1],
        weights.state[2],
        weights.current,
    ])
}

impl TorqueAnswer {
    fn of(size: f64, unit: String, curves: BandedResponse) -> TorqueAnswer {
        let band = &curves.angle_band;
        let ends = (curves.sets > 0).then(|| {
            // At the time of the largest angle.
            let at = index_of_largest(&curves.nominal.angle_rad);
            [band.low[at].abs(), band.high[at].abs()]
        });
        TorqueAnswer {
            size,
            unit,
            largest_angle_rad: largest(&curves.nominal.angle_rad),
            largest_angle_band_rad: ends.map(|[a, b]| [a.min(b), a.max(b)]),
            largest_wheel_speed_rad_s: largest(&curves.nominal.wheel_speed_rad_s),
            largest_current_a: largest(&curves.nominal.current_a),
            curves,
        }
    }
}

fn largest(values: &[f64]) -> f64 {
    values
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()))
}

fn index_of_largest(values: &[f64]) -> usize {
    let indices = 0..values.len();
    indices
        .max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs()))
        .unwrap_or(0)
}
