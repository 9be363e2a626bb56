//! The properties of a designed controller.

use bench_files::Parameter;
use design::wheel_sizing::chart;
use design::{
    ChartPoint, ExtremeCheck, Margins, Pole, PoleUncertainty, Sizing, UncertainParameters,
    UncertainPole, pole_uncertainty,
};
use plant::{GRAVITY_TORQUE, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};
use serde::{Deserialize, Serialize};

use crate::comparison::effect_names;
use crate::control_design::ControlDesign;
use crate::error::Error;
use crate::named;

/// Number of parameter sets drawn to find the effect of their uncertainty on the poles.
const DRAWN_SETS: usize = 1000;
/// Seed of that draw.
const SEED: u64 = 1;
/// Number of drawn sets whose poles are kept for the figure.
const SHOWN_SETS: usize = 200;
/// Wheel inertias in the tables, relative to the bench's own.
const WHEEL_FACTORS: [f64; 3] = [0.5, 1.0, 2.0];
/// Top speeds of the wheel in the table of sizes.
const TABLED_SPEEDS_RAD_S: [f64; 5] = [50.0, 100.0, 200.0, 400.0, 700.0];

/// Linear model, gains, poles, margins and sizing: the result of
/// [`ControlDesign::report`](crate::ControlDesign::report). States are (angle from upright in rad,
/// rate in rad/s, wheel speed in rad/s), the law is u = −K x in A.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DesignReport {
    /// The model.
    pub model: String,
    /// Its effects.
    pub effects: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Reasons to distrust the model, one sentence each: an open tie, or an error that the last diagnosis could not
    /// explain.
    pub cautions: Vec<String>,
    /// Time between two commands, s.
    pub sample_time_s: f64,
    /// Diagonal of Q: weights of angle, rate and wheel speed in 1/s per rad², (rad/s)², (rad/s)².
    pub state_weights: [f64; 3],
    /// Weight R of the current in 1/s per A².
    pub current_weight: f64,
    /// Largest current in either direction, A.
    pub current_limit_a: f64,
    /// ι, rad/s: Coulomb friction of the pivot enters the linear model as μ/ι; `None` to leave it out.
    pub friction_linearisation_speed_rad_s: Option<f64>,
    /// State matrix A (3×3) of the linear model about upright, row by row, units of row over column per second.
    #[serde(rename = "A")]
    pub a: [[f64; 3]; 3],
    /// Input matrix B (3×1) of the linear model, units of row per A and second.
    #[serde(rename = "B")]
    pub b: [f64; 3],
    /// State matrix Ad (3×3) of the zero-order hold, row by row.
    #[serde(rename = "Ad")]
    pub ad: [[f64; 3]; 3],
    /// Input matrix Bd (3×1) of the zero-order hold, units of row per A.
    #[serde(rename = "Bd")]
    pub bd: [f64; 3],
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Real and imaginary part of the eigenvalues of A, 1/s.
    pub open_loop_poles: Vec<[f64; 2]>,
    /// Real and imaginary part of the eigenvalues of Ad − Bd K, dimensionless.
    pub closed_loop_poles: Vec<[f64; 2]>,
    /// The continuous equivalents ln(λ)/T of these eigenvalues, 1/s.
    pub closed_loop_poles_per_s: Vec<[f64; 2]>,
    /// The effect of the parameters' errors on the poles; `None` if the model states no errors.
    pub pole_uncertainty: Option<PoleErrors>,
    /// Rank of (B, AB, A²B).
    pub controllability_rank: usize,
    /// Condition number of the scaled controllability matrix; infinite (null) if a state cannot be reached.
    #[serde(with = "named::unbounded")]
    pub controllability_condition: f64,
    /// Rank of the observability matrix with all sensors.
    pub observability_rank: usize,
    /// Condition number of the scaled observability matrix; infinite (null) if a state is not observable.
    #[serde(with = "named::unbounded")]
    pub observability_condition: f64,
    /// Rank of the observability matrix with one sensor alone, by the sensor's name.
    pub observability_rank_of_sensor: Vec<(String, usize)>,
    /// Condition number of the observability matrix with one sensor alone.
    pub observability_condition_of_sensor: Vec<SensorCondition>,
    /// asin(τ u_max/G): the largest angle at which the motor is stronger than gravity.
    pub recovery_angle_rad: f64,
    /// Relative residual of the Riccati equation.
    pub dare_residual: f64,
    /// Gain, phase, delay and modulus margins.
    pub margins: LoopMargins,
    /// Steady wheel speed per rad of bias of the measured angle, rad/s per rad.
    pub wheel_speed_per_angle_bias: f64,
    /// Sentences about the learned curves and the effects of users in the linear model.
    pub upright: Vec<String>,
    /// The loop with none and with all of the Coulomb friction, where there is any.
    pub friction_extremes: Option<[FrictionExtreme; 2]>,
    /// The oscillation around upright that dry friction maintains (describing function); `None` if there
    /// is none.
    pub hunting: Option<HuntingSwing>,
    /// The smallest push that brings the body up from rest, for three angles.
    pub least_pushes: Vec<LeastPush>,
    /// The angles from which three wheels recover, by their top speed.
    pub wheel_sizing: Vec<WheelSize>,
    /// The angles of [`DesignReport::wheel_sizing`] in finer steps of the top speed, for a figure.
    #[serde(skip)]
    pub wheel_curves: Vec<WheelSize>,
}

/// The conditioning of the observability with one sensor alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorCondition {
    /// The sensor.
    pub sensor: String,
    /// Condition number; infinite (null) if a state is not observable.
    #[serde(with = "named::unbounded")]
    pub condition: f64,
}

/// Standard errors of the poles.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PoleErrors {
    /// Whether the model states the correlations of the errors of its parameters; otherwise they are treated as
    /// independent.
    pub correlated: bool,
    /// Standard deviation of the real part and of the imaginary part of each open-loop pole, 1/s.
    pub open_loop_std: Vec<[f64; 2]>,
    /// Standard deviation of the real part and of the imaginary part of each closed-loop pole, 1/s.
    pub closed_loop_std_per_s: Vec<[f64; 2]>,
    /// For each open-loop pole, the parameter whose error alone moves it farthest; empty if none does.
    pub open_loop_moved_most_by: Vec<String>,
    /// For each closed-loop pole, the parameter whose error alone moves it farthest; empty if none does.
    pub closed_loop_moved_most_by: Vec<String>,
    /// Number of parameter sets that were drawn within the errors.
    pub drawn: usize,
    /// Number of those that are not a pendulum.
    pub impossible: usize,
    /// Number of those whose loop is unstable.
    pub unstable: usize,
    /// Largest spectral radius of the closed loop among the drawn sets.
    pub worst_spectral_radius: f64,
    /// Open-loop poles of some drawn sets, 1/s.
    #[serde(skip)]
    pub open_loop_cloud: Vec<[f64; 2]>,
    /// Closed-loop poles of some drawn sets, 1/s.
    #[serde(skip)]
    pub closed_loop_cloud: Vec<[f64; 2]>,
}

/// The margins within which a loop stays stable.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopMargins {
    /// Smallest factor on the gain.
    pub least_gain_factor: f64,
    /// Largest factor on the gain; infinite (null) if there is none.
    #[serde(with = "named::unbounded")]
    pub largest_gain_factor: f64,
    /// Phase margin; infinite (null) if there is none.
    #[serde(with = "named::unbounded")]
    pub phase_margin_rad: f64,
    /// Delay beyond the hold; infinite (null) if there is none.
    #[serde(with = "named::unbounded")]
    pub delay_margin_s: f64,
    /// Smallest distance of the loop's frequency response from −1.
    pub modulus_margin: f64,
}

/// The loop at one extreme of Coulomb friction.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FrictionExtreme {
    /// "none" or "all".
    pub coulomb_friction: String,
    /// Real and imaginary part, as continuous equivalents, 1/s.
    pub closed_loop_poles_per_s: Vec<[f64; 2]>,
    /// Largest |λ| of the sampled loop.
    pub spectral_radius: f64,
    /// Whether the spectral radius is below one.
    pub stable: bool,
    /// The margins; `None` if the loop is unstable.
    pub margins: Option<LoopMargins>,
}

/// An oscillation around upright that dry friction maintains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HuntingSwing {
    /// Amplitude of the angle.
    pub angle_rad: f64,
    /// Amplitude of the rate.
    pub rate_rad_s: f64,
    /// Angular frequency.
    pub frequency_rad_s: f64,
}

/// The smallest push of the wheel that brings the body up from rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeastPush {
    /// Angle of the body at rest, from upright.
    pub angle_rad: f64,
    /// Energy that the body lacks there.
    pub energy_j: f64,
    /// Time during which the current is at its limit.
    pub duration_s: f64,
    /// Change of the wheel's speed.
    pub wheel_speed_rad_s: f64,
}

/// One wheel at one top speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WheelSize {
    /// Inertia, kg m².
    pub wheel_inertia: f64,
    /// The inertia relative to that of the bench's own wheel.
    pub wheel_factor: f64,
    /// Top speed.
    pub wheel_speed_rad_s: f64,
    /// Energy of the wheel at that speed.
    pub wheel_energy_j: f64,
    /// Largest angle at rest from which the body can be brought up.
    pub recoverable_angle_rad: f64,
    /// Energy that the body lacks there.
    pub recovered_energy_j: f64,
}

impl ControlDesign {
    /// All properties of the controller that need no simulation.
    ///
    /// # Errors
    /// [`Error::Design`] if the numbers give no result.
    pub fn report(&self) -> Result<DesignReport, Error> {
        let in_design = |source| self.design_error(source);
        let uncertainty = self.pole_uncertainty().map_err(in_design)?;
        let sizing = self.sizing();
        let wheels = WHEEL_FACTORS.map(|factor| factor * sizing.wheel_inertia);
        let sizes = |speeds: &[f64]| -> Result<Vec<WheelSize>, Error> {
            let points = chart(&sizing, &wheels, speeds).map_err(in_design)?;
            let wheels = points.chunks(speeds.len()).zip(WHEEL_FACTORS);
            Ok(wheels
                .flat_map(|(points, factor)| points.iter().map(move |p| WheelSize::of(p, factor)))
                .collect())
        };
        let fine: Vec<f64> = (1..=70).map(|step| 10.0 * f64::from(step)).collect();
        let design = self.design();
        let wishes = self.wishes();
        let sensors = design.observability_of_sensor.iter();
        Ok(DesignReport {
            model: self.name().to_owned(),
            effects: effect_names(self.model()),
            parameters: self.file().parameters.clone(),
            cautions: self.cautions(),
            sample_time_s: wishes.sample_time_s,
            state_weights: wishes.state_weights,
            current_weight: wishes.current_weight,
            current_limit_a: wishes.current_limit_a,
            friction_linearisation_speed_rad_s: wishes.friction_linearisation_speed_rad_s,
            a: matrix(|row, column| design.model.state[(row, column)]),
            b: [0, 1, 2].map(|row| design.model.input[row]),
            ad: matrix(|row, column| design.discrete.state[(row, column)]),
            bd: [0, 1, 2].map(|row| design.discrete.input[row]),
            gains: self.gains(),
            open_loop_poles: pairs(&design.open_loop_poles),
            closed_loop_poles: pairs(&design.closed_loop_poles),
            closed_loop_poles_per_s: design
                .closed_loop_poles_per_s()
                .iter()
                .map(|pole| [pole.re, pole.im])
                .collect(),
            pole_uncertainty: uncertainty
                .map(|found| PoleErrors::of(&found, self.file().correlation.is_some())),
            controllability_rank: design.controllability.rank,
            controllability_condition: design.controllability.condition,
            observability_rank: design.observability.rank,
            observability_condition: design.observability.condition,
            observability_rank_of_sensor: sensors
                .clone()
                .map(|(sensor, rank)| ((*sensor).to_owned(), rank.rank))
                .collect(),
            observability_condition_of_sensor: sensors
                .map(|(sensor, rank)| SensorCondition {
                    sensor: (*sensor).to_owned(),
                    condition: rank.condition,
                })
                .collect(),
            recovery_angle_rad: design.recovery_angle_rad,
            dare_residual: design.dare_residual(),
            margins: LoopMargins::of(&design.margins),
            wheel_speed_per_angle_bias: design.wheel_speed_per_angle_bias,
            upright: self.upright_notes(),
            friction_extremes: design.friction.as_ref().map(|check| {
                [("none", &check.none), ("all", &check.all)]
                    .map(|(name, extreme)| FrictionExtreme::of(name, extreme))
            }),
            hunting: design
                .friction
                .as_ref()
                .and_then(|check| check.hunting)
                .map(|swing| HuntingSwing {
                    angle_rad: swing.angle_rad,
                    rate_rad_s: swing.rate_rad_s,
                    frequency_rad_s: swing.frequency_rad_s,
                }),
            least_pushes: self.least_pushes(&sizing)?,
            wheel_sizing: sizes(&TABLED_SPEEDS_RAD_S)?,
            wheel_curves: sizes(&fine)?,
        })
    }

    /// The parameters with their standard errors and correlations; none where the file states no errors.
    pub(crate) fn uncertain_parameters(&self) -> Option<UncertainParameters> {
        let infos = self.model().parameters();
        let parameters: Vec<(&str, f64, f64)> = infos
            .iter()
            .zip(self.values())
            .map(|(info, &value)| {
                let parameter = self.file().parameter(info.name);
                let std = parameter.and_then(|parameter| parameter.std);
                (info.name, value, std.unwrap_or(0.0))
            })
            .collect();
        if parameters.iter().all(|(_, _, std)| *std == 0.0) {
            return None;
        }
        Some(match &self.file().correlation {
            Some(known) => UncertainParameters::correlated(&parameters, |a, b| known.between(a, b)),
            None => UncertainParameters::independent(&parameters),
        })
    }

    /// The effect of the parameters' errors on the poles; `None` if the file states no errors.
    fn pole_uncertainty(&self) -> Result<Option<PoleUncertainty>, design::DesignError> {
        let Some(parameters) = self.uncertain_parameters() else {
            return Ok(None);
        };
        pole_uncertainty(
            &parameters,
            &|values| self.linearise(values),
            &self.design().gains,
            self.wishes().sample_time_s,
            DRAWN_SETS,
            SEED,
        )
        .map(Some)
    }

    fn sizing(&self) -> Sizing {
        let values = self.values();
        Sizing {
            total_inertia: values[TOTAL_INERTIA],
            wheel_inertia: values[WHEEL_INERTIA],
            gravity_torque: values[GRAVITY_TORQUE],
            largest_torque: values[TORQUE_CONSTANT] * self.wishes().current_limit_a,
        }
    }

    /// The smallest push from rest at a third, two thirds and nine tenths of the largest angle.
    fn least_pushes(&self, sizing: &Sizing) -> Result<Vec<LeastPush>, Error> {
        let mut pushes = Vec::new();
        for share in [1.0 / 3.0, 2.0 / 3.0, 0.9] {
            let angle_rad = share * self.design().recovery_angle_rad;
            let found = sizing.least_push(angle_rad);
            if let Some(push) = found.map_err(|source| self.design_error(source))? {
                pushes.push(LeastPush {
                    angle_rad,
                    energy_j: push.energy_j,
                    duration_s: push.duration_s,
                    wheel_speed_rad_s: push.wheel_speed_rad_s,
                });
            }
        }
        Ok(pushes)
    }
}

impl PoleErrors {
    fn of(found: &PoleUncertainty, correlated: bool) -> PoleErrors {
        let stds = |poles: &[UncertainPole]| poles.iter().map(|p| [p.std_re, p.std_im]).collect();
        let culprits = |poles: &[UncertainPole]| poles.iter().map(culprit).collect();
        let cloud = |poles: &[nalgebra::Complex<f64>]| {
            let shown = poles.iter().take(SHOWN_SETS * 3);
            shown.map(|pole| [pole.re, pole.im]).collect()
        };
        PoleErrors {
            correlated,
            open_loop_std: stds(&found.open_loop),
            closed_loop_std_per_s: stds(&found.closed_loop),
            open_loop_moved_most_by: culprits(&found.open_loop),
            closed_loop_moved_most_by: culprits(&found.closed_loop),
            drawn: found.samples,
            impossible: found.impossible,
            unstable: found.unstable,
            worst_spectral_radius: found.worst_spectral_radius,
            open_loop_cloud: cloud(&found.open_loop_drawn),
            closed_loop_cloud: cloud(&found.closed_loop_drawn),
        }
    }

    /// Number of drawn sets with a stable loop.
    pub fn stable(&self) -> usize {
        self.drawn - self.unstable - self.impossible
    }
}

/// The parameter whose standard error alone moves the pole farthest.
fn culprit(pole: &UncertainPole) -> String {
    pole.per_parameter
        .iter()
        .filter(|(_, moves)| moves.norm() > 0.0)
        .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))
        .map_or(String::new(), |(name, _)| name.clone())
}

impl LoopMargins {
    pub(crate) fn of(margins: &Margins) -> LoopMargins {
        LoopMargins {
            least_gain_factor: margins.least_gain_factor,
            largest_gain_factor: margins.largest_gain_factor,
            phase_margin_rad: margins.phase_margin_rad,
            delay_margin_s: margins.delay_margin_s,
            modulus_margin: margins.modulus_margin,
        }
    }
}

impl FrictionExtreme {
    fn of(name: &str, extreme: &ExtremeCheck) -> FrictionExtreme {
        FrictionExtreme {
            coulomb_friction: name.to_owned(),
            closed_loop_poles_per_s: extreme
                .closed_loop_poles_per_s
                .iter()
                .map(|pole| [pole.re, pole.im])
                .collect(),
            spectral_radius: extreme.spectral_radius,
            stable: extreme.is_stable(),
            margins: extreme.margins.as_ref().map(LoopMargins::of),
        }
    }
}

impl WheelSize {
    fn of(point: &ChartPoint, wheel_factor: f64) -> WheelSize {
        WheelSize {
            wheel_inertia: point.wheel_inertia,
            wheel_factor,
            wheel_speed_rad_s: point.wheel_speed_rad_s,
            wheel_energy_j: point.wheel_energy_j,
            recoverable_angle_rad: point.recoverable_angle_rad,
            recovered_energy_j: point.recovered_energy_j,
        }
    }
}

fn pairs(poles: &[Pole]) -> Vec<[f64; 2]> {
    let poles = poles.iter();
    poles.map(|pole| [pole.value.re, pole.value.im]).collect()
}

fn matrix(entry: impl Fn(usize, usize) -> f64) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| entry(row, column)))
}
