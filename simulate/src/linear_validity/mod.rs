//! Where the linear model is valid: free swing (thesis figure 3.5, 20° against 60°) and
//! spin-up (figure 3.6), as curves and as numbers.
//!
//! The linear model is the exact Jacobian at rest of those terms that have one there. Dry friction
//! and the stages between command and current have none, and are left out, as in the design. It is compared with two
//! nonlinear models: the whole one, which describes the bench, and the one
//! with only the linearised terms, which shows the influence of the large angle alone.
//!
//! A pendulum's period grows as T/T₀ = 1 + A²/16 + 11A⁴/3072 + …. The linear swing therefore drifts out of
//! phase for any A, after n periods by 2πn A²/16, and "valid" needs a time horizon. Here, the linear model
//! is valid while the root mean square of its error over n periods is below a share of the
//! amplitude.
//!
//! For a measured swing, both models start from the start to which the whole one was fitted. The
//! amplitudes at which the measured period equals that of the linear model are found without a start.

mod free_swing;
mod linear_model;
mod measured;
mod spin_up;

pub use free_swing::{
    LinearRange, MeasuredPeriod, MeasuredSwing, SwingComparison, SwingOverMeasurement,
    compare_free_swing, largest_linear_amplitude, linear_range, over_measurement,
};
pub use spin_up::{
    MeasuredSpinUp, SpinUpComparison, SpinUpOverMeasurement, compare_spin_up,
    spin_up_over_measurement,
};
