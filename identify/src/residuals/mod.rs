//! What a model leaves of the measurements: noise, or something that it lacks, and where.
//!
//! | file | job |
//! |---|---|
//! | `correlation` | does a residual remember itself or the input |
//! | `structure` | how much of it is more than noise |
//! | `missing_torque` | the torque that a model lacks, over time |
//! | `pushes` | pushes that nobody recorded: found, sized, kept out of the fit |
//! | `breakdown` | where a model fails: its residual over time, amplitude, angle, speed, current |

mod breakdown;
mod correlation;
mod missing_torque;
mod pushes;
mod structure;
#[cfg(test)]
mod test_series;

pub use breakdown::{
    Bin, Breakdown, Coordinate, Explained, FailureMap, Quantity, Region, breakdown,
};
pub use correlation::{
    CorrelationTest, LAGS, autocorrelation, cross_correlation, effective_samples,
};
pub use missing_torque::{
    MeasuredMotion, MissingTorque, TorqueOn, half_bump, missing_torque, missing_torques,
};
pub use pushes::{Push, PushModel, find_pushes, leave_out};
pub(crate) use pushes::{find_disturbances, is_slow, samples_in_window};
pub use structure::{SIGNIFICANT, Structure, structure, without_rounding};
