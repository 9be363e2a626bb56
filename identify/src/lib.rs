//! From logs to parameters with their uncertainty.
//!
//! | file | job |
//! |---|---|
//! | `record` | a log as the fit sees it |
//! | `noise` | the noise of a sensor, from the log alone |
//! | `start` | a first guess, straight from the samples |
//! | `sensitivity` | one window simulated with exact derivatives |
//! | `solver` | nonlinear least squares over shared parameters and each window's start |
//! | `fit` | the schedule from a plain start; model against measurement |
//! | `covariance` | standard errors that account for correlated residuals |
//! | `contradiction` | experiments and knowns that cannot all be right |
//! | `missing_torque` | the torque that a model lacks, over time |
//! | `breakdown` | where a model fails: its residual over time, amplitude, angle, speed, current |
//! | `decay` | how a free swing dies out: amplitude, decay and period |
//! | `pushes` | pushes that nobody recorded: found, sized, kept out of the fit |
//! | `cogging` | where a fit of cogging may start: its order, and the teeth on which windows begin |
//! | `progress` | what long work says, and how it is called off |
//! | `kinematics` | the rate against the angle, without a model of the motion |
//! | `whiteness` | what is left in a residual: noise or structure |
//! | `identification` | a whole bench: what is known, what is free, what is open |

mod breakdown;
mod cogging;
mod contradiction;
mod covariance;
mod decay;
mod fit;
mod identification;
mod kinematics;
mod missing_torque;
mod noise;
mod progress;
mod pushes;
mod record;
mod sensitivity;
mod solver;
mod start;
mod whiteness;

pub use breakdown::{
    Bin, Breakdown, Coordinate, Explained, FailureMap, Quantity, Region, breakdown,
};
pub use cogging::{CoggingStart, cogging_start, settled};
pub use contradiction::{
    Contradiction, Side, body_inertia, body_inertia_contradiction, contradictions,
};
pub use covariance::{pseudo_inverse, stuck};
pub use decay::{AtAmplitude, Decay, DecayLaw, Estimate, decay};
pub use fit::{
    Fit, Trace, final_windows, finish, fit_from_scratch, fit_windowed, guessed, joined, period_s,
    refit, traces,
};
pub use identification::{
    Identification, IdentifyError, Setup, carry_over, describe, extend, identify,
};
pub use kinematics::{RateAgainstAngle, rate_against_angle};
pub use missing_torque::{
    MeasuredMotion, MissingTorque, TorqueOn, half_bump, missing_torque, missing_torques,
};
pub use noise::{input_noise_std, noise_std, resolution};
pub use progress::{Cancelled, Progress};
pub use pushes::{Push, PushModel, find_pushes, leave_out};
pub use record::{BALANCE_WINDOW_S, Channel, Output, Record, RecordedCurrent};
pub use sensitivity::{
    Local, MAX_UNKNOWNS, Observation, Unknowns, Window, WindowNormal, acts, normal,
    normal_observed, relevant, simulate,
};
pub use solver::{
    Effort, KnownPromise, Minimum, Outcome, Promise, PromisedStep, RecordPromise, cost, minimise,
    promise,
};
pub use start::{Ratios, angle_samples, base_values, ratios};
pub use whiteness::{
    CorrelationTest, LAGS, SIGNIFICANT, Structure, autocorrelation, cross_correlation,
    effective_samples, structure, without_rounding,
};
