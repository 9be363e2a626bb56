//! What a model leaves of the measurements: noise, or something that it lacks, and where.
//!
//! | file | job |
//! |---|---|
//! | `correlation` | does a residual remember itself or the input |
//! | `structure` | how much of it is more than noise |
//! | `residual_torque` | the torque that a model lacks, over time |
//! | `pushes` | pushes that nobody recorded: found, sized, kept out of the fit |
//! | `breakdown` | where a model fails: its residual over time, amplitude, angle, speed, current |

mod breakdown;
mod correlation;
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
pub use pushes::{FoundPush, PushModel, find_pushes, leave_out};
pub(crate) use pushes::{find_disturbances, is_slow, samples_in_window};
pub use residual_torque::{
    MeasuredMotion, ResidualTorque, TorqueOn, half_bump, residual_torque, residual_torques,
};
pub use structure::{ResidualStructure, SIGNIFICANT, structure, without_rounding};
