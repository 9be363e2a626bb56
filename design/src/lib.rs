//! From the linear model of the bench to a controller and what can be expected of it.
//!
//! [`Design::new`] is the entry: it samples the model, solves for the gains and checks the loop.
//! Below it, one file per job: [`zero_order_hold`], [`sampled_cost`], [`dare`], [`care`], [`lqr`],
//! [`poles`], [`structural`], [`singular_values`], [`recovery`].
//!
//! States are (angle from upright in rad, rate in rad/s, wheel speed in rad/s), the input is the
//! motor current in A, and the law is u = −K x throughout.

#![warn(missing_docs)]

pub mod care;
pub mod controller;
pub mod dare;
mod error;
pub mod lqr;
pub mod margins;
mod matrix;
pub mod poles;
pub mod recovery;
pub mod sampled_cost;
pub mod singular_values;
pub mod structural;
#[cfg(test)]
mod thesis;
pub mod zero_order_hold;

pub use care::{CareSolution, solve_care};
pub use controller::LinearController;
pub use dare::{DareSolution, solve_dare};
pub use error::DesignError;
pub use lqr::{
    ContinuousRegulator, DiscreteRegulator, Weights, continuous_regulator, discrete_regulator,
};
pub use margins::{Margins, margins};
pub use poles::{Pole, eigenvalues, poles, spectral_radius};
pub use recovery::recovery_angle_rad;
pub use sampled_cost::QuadraticCost;
pub use structural::{StructuralRank, controllability, observability};
pub use zero_order_hold::{DelayedDiscrete, Discrete};
