//! From the linear model of the bench to a controller, and the properties of its loop.
//!
//! [`Design::new`] is the entry point: it samples the model, solves for the gains and checks the loop.
//! The other files:
//!
//! | file | job |
//! |---|---|
//! | [`zero_order_hold`], [`sampled_cost`] | the discretisation of model and cost |
//! | [`dare`], [`care`], [`lqr`] | Riccati equations and the gains |
//! | [`poles`], [`structural`], [`singular_values`] | eigenvalues, controllability, observability, and their conditioning |
//! | [`controller`], [`margins`] | loops, with their gain, phase, delay and modulus margins |
//! | [`disturbance`] | the response of the loop to a disturbing torque |
//! | [`friction`], [`uncertainty`] | the loop on benches that differ from the model |
//! | [`recovery`], [`wheel_sizing`] | the limits that current and wheel speed set |
//! | [`angle_bias`], [`bias_observer`] | the effect of a bias of the angle, and an observer against it |
//!
//! States are (angle from upright in rad, rate in rad/s, wheel speed in rad/s), the input is the
//! motor current in A, and the law is u = −K x throughout.

#![warn(missing_docs)]

pub mod angle_bias;
pub mod bias_observer;
pub mod care;
pub mod controller;
pub mod dare;
mod design;
pub mod disturbance;
mod double_double;
mod error;
mod extended;
pub mod friction;
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
pub mod uncertainty;
pub mod wheel_sizing;
pub mod zero_order_hold;

pub use angle_bias::{rest_per_angle_bias, sampled_rest_per_angle_bias};
pub use bias_observer::BiasObserver;
pub use care::{CareSolution, solve_care};
pub use controller::LinearController;
pub use dare::{DareSolution, solve_dare};
pub use design::{Design, Settings};
pub use disturbance::{TorqueResponse, torque_response};
pub use error::DesignError;
pub use friction::{ExtremeCheck, FrictionCheck, FrictionExtremes, Hunting, friction_check};
pub use lqr::{
    ContinuousRegulator, DiscreteRegulator, Weights, continuous_regulator, discrete_regulator,
};
pub use margins::Margins;
pub use poles::{Pole, eigenvalues, spectral_radius};
pub use recovery::recovery_angle_rad;
pub use sampled_cost::QuadraticCost;
pub use structural::{StructuralRank, controllability, observability};
pub use uncertainty::{PoleUncertainty, UncertainParameters, UncertainPole, pole_uncertainty};
pub use wheel_sizing::{ChartPoint, Sizing, SizingPush, wheel_energy_j};
pub use zero_order_hold::{DelayedDiscrete, Discrete};
