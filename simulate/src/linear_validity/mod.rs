//! How far the linear model can be trusted: free swing (thesis figure 3.5, 20° against 60°) and
//! spin-up (figure 3.6), as curves and as numbers.
//!
//! The linear model is the exact Jacobian at rest of the terms that have one there; dry friction
//! and what lies between command and current have none and are left out, as in the design. Two
//! nonlinear models are set against it: the whole one, which is what the bench does, and the one
//! with just the terms that were linearised, which is what the large angle alone does.
//!
//! A pendulum's period grows as T/T₀ = 1 + A²/16 + 11A⁴/3072 + …, so the linear swing drifts out of
//! phase however small A is: after n periods by 2πn A²/16. "Good" therefore needs a horizon. Here
//! it is good while the root mean square of the error over n periods is below a share of the
//! amplitude.
//!
//! Against a measured swing both models run from the start that the whole one was fitted to, and the
//! amplitudes at which the measured period is that of the linear model are found without any start.

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
