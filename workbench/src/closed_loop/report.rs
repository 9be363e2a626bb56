//! The result of a simulation of the closed loop, as the library returns it and as JSON states it.

use serde::{Deserialize, Serialize};
use simulate::attitude_filters::FilterComparison;
use simulate::linear_validity::{SpinUpComparison, SwingComparison};
use simulate::{LoggedLoop, LoopTrace};

use crate::measured_linearity::{MeasuredSwings, SpinUpLinearity};
use crate::named;

/// The emitted law, executed from its source, on the nonlinear bench with all effects of
/// its model: the result of [`ControlDesign::simulate`](crate::ControlDesign::simulate).
///
/// The JSON does not contain the curves; [`SimulationReport::files`] returns them as figures and tables.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SimulationReport {
    /// The model.
    pub model: String,
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: [f64; 3],
    /// Largest current in either direction.
    pub current_limit_a: f64,
    /// Properties of sensors and drive that the model does not state, and that the simulation takes from the
    /// bench of the thesis; sentences.
    pub assumed: Vec<String>,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Transient, disturbance, half a minute with pushes.
    pub runs: Vec<LoopRun>,
    /// The half minute with pushes, simulated from raw counts to duty.
    pub raw_counts: RawCountsRun,
    /// The largest angle from which the loop recovers.
    pub recovery: RecoveryAngles,
    /// The region of attraction, if the certificate states an ellipsoid to enlarge.
    pub attraction: Option<AttractionRegion>,
    /// The methods for the angle, on one free swing.
    pub attitude_filters: Vec<FilterError>,
    /// The transient with each effect of the model.
    pub effects: Vec<EffectOnTransient>,
    /// Where the linear model is valid.
    pub linear_model: LinearRangeReport,
    /// Both models compared with the measured free swings, if a bench was given and has any.
    pub measured_swings: Option<MeasuredSwings>,
    /// Both models compared with the measured spin-ups of the bench.
    pub measured_spin_ups: Vec<SpinUpLinearity>,
    /// The simulated loop compared with the balance logs of the bench.
    pub overlays: Vec<LoopOverlay>,
    /// The attitude filters on the swing.
    #[serde(skip)]
    pub filters: Option<FilterRun>,
}

/// One run of the emitted law, compared with the exact one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopRun {
    /// Its name.
    pub scenario: String,
    /// The course of the run, in one sentence.
    pub about: String,
    /// Whether the body fell.
    pub fell: bool,
    /// Largest angle from upright.
    pub largest_angle_rad: f64,
    /// Largest speed of the wheel.
    pub largest_wheel_speed_rad_s: f64,
    /// Largest current.
    pub largest_current_a: f64,
    /// Time at which the body was last beyond 2 % of the largest angle.
    pub settling_s: f64,
    /// Largest difference of the angle between the emitted and the exact law.
    pub difference_angle_rad: f64,
    /// Largest difference of the current between the emitted and the exact law.
    pub difference_current_a: f64,
    /// The pushes on the body: time (s) and impulse (N m s).
    #[serde(skip)]
    pub pushes: Vec<(f64, f64)>,
    /// The run under the exact law in floating point.
    #[serde(skip)]
    pub exact: LoopTrace,
    /// The run under the emitted law.
    #[serde(skip)]
    pub emitted: LoopTrace,
}

/// The half minute from raw counts to duty, through the emitted controller.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RawCountsRun {
    /// Whether the body fell.
    pub fell: bool,
    /// Largest angle from upright.
    pub largest_angle_rad: f64,
    /// Largest speed of the wheel.
    pub largest_wheel_speed_rad_s: f64,
    /// Largest current.
    pub largest_current_a: f64,
    /// Root mean square error of the measured angle.
    pub angle_error_rad: f64,
    /// The run.
    #[serde(skip)]
    pub trace: LoopTrace,
}

/// Largest angles from rest, without sensor noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecoveryAngles {
    /// Under the emitted law.
    pub emitted_law_rad: f64,
    /// Under the exact law.
    pub exact_law_rad: f64,
    /// asin(τ u_max/G).
    pub limit_rad: f64,
    /// Resolution of these angles.
    pub resolution_rad: f64,
}

/// The largest ellipsoid of starts from which the emitted law returns, with sensor noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttractionRegion {
    /// Largest size, relative to the certificate's ellipsoid, with return from every start.
    pub size: f64,
    /// Smallest size with a start without return.
    pub lost_size: f64,
    /// The start of this size that did not return: rad, rad/s, rad/s.
    pub lost: [f64; 3],
    /// Largest angle, rate and wheel speed of the set: rad, rad/s, rad/s.
    pub extents: [f64; 3],
    /// Starts on each boundary.
    pub starts: usize,
}

/// The error of an attitude filter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilterError {
    /// The filter.
    pub filter: String,
    /// Root mean square error of its angle over the swing.
    pub error_rad: f64,
}

/// The attitude filters on one swing.
#[derive(Clone, Debug)]
pub struct FilterRun {
    /// Position of the sensor, along body x and y.
    pub lever_arm_m: [f64; 2],
    /// Truth and estimates.
    pub found: FilterComparison,
}

/// The influence of effects beyond viscous friction on the transient.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectOnTransient {
    /// The effects; none for the base model.
    pub effects: Vec<String>,
    /// Number of swings to the other side.
    pub swings: usize,
    /// Largest angle on the side opposite to the start.
    pub overshoot_rad: f64,
    /// Time at which the body was last beyond the threshold.
    pub settling_s: f64,
    /// Root mean square of the angle over the last quarter.
    pub residual_rad: f64,
    /// Whether the body fell.
    pub fell: bool,
}

/// Where the linear model is valid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LinearRangeReport {
    /// Largest relative error with which it counts as valid.
    pub share: f64,
    /// Amplitude up to which ten periods of the linear free swing follow the nonlinear one.
    pub good_up_to_amplitude_rad: f64,
    /// Amplitude in rad and error over the first period, of two swings.
    pub free_swing_error: Vec<[f64; 2]>,
    /// Current of the spin-up.
    pub spin_up_current_a: f64,
    /// Speed up to which the linear spin-up follows; `None` if it follows during the whole run.
    pub spin_up_good_up_to_rad_s: Option<f64>,
    /// The two swings.
    #[serde(skip)]
    pub swings: Vec<SwingComparison>,
    /// The spin-up.
    #[serde(skip)]
    pub spin_up: Option<SpinUpComparison>,
}

/// The simulated loop compared with a measured balance log, with the pushes that were found in the log.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LoopOverlay {
    /// The experiment.
    pub experiment: String,
    /// Number of pushes.
    pub pushes: usize,
    /// Its channels.
    pub channels: Vec<OverlayStatistics>,
    /// The curves.
    #[serde(skip)]
    pub found: Option<LoggedLoop>,
}

/// A channel of an overlay in numbers, in the SI unit of the channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OverlayStatistics {
    /// angle, rate, wheel_speed or current.
    pub channel: String,
    /// Root mean square of the difference.
    #[serde(with = "named::gap")]
    pub rms_difference: f64,
    /// Standard deviation of the measurement.
    #[serde(with = "named::gap")]
    pub measured_std: f64,
    /// Standard deviation of the simulation.
    #[serde(with = "named::gap")]
    pub simulated_std: f64,
}
