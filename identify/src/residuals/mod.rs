//! The residual of a model: noise, or a missing effect, and where it acts.
//!
//! | file | job |
//! |---|---|
//! | `correlation` | whether the residual is correlated with itself or with the input |
//! | `structure` | how much of the residual is more than noise |
//! | `discrepancy` | what no model explains, as a random process beside the noise |
//! | `residual_torque` | the missing torque, over time |
//! | `pushes` | unrecorded pushes: found, sized, left out of the fit |
//! | `breakdown` | where a model fails: its residual over time, amplitude, angle, speed, current |

mod breakdown;
mod correlation;
mod discrepancy;
mod pushes;
mod residual_torque;
mod structure;
#[cfg(test)]
mod test_series;

pub use breakdown::{
    BreakdownBin, Coordinate, ExplainedTorque, FailureMap, FailureRegion, ResidualBreakdown,
    ResidualKind, breakdown,
};
pub use correlation::{
    CorrelationTest, LAGS, autocorrelation, cross_correlation, effective_samples,
};
pub use discrepancy::{Discrepancy, NoisySeries};
pub use pushes::{FoundPush, PushModel, find_pushes, leave_out};
pub(crate) use pushes::{find_disturbances, is_slow, samples_in_window};
pub use residual_torque::{
    MeasuredMotion, ResidualTorque, TorqueOn, half_bump, residual_torque, residual_torques,
};
pub use structure::{ResidualStructure, SIGNIFICANT, structure, without_rounding};
