//! From the linear model of the bench to a controller, and the properties of its loop.
//!
//! [`Design::new`] is the entry point: it samples the model, solves for the gains and checks the loop.
//! The other files:
//!
//! | file | job |
//! |---|---|
//! | [`zero_order_hold`], [`sampled_cost`] | the discretisation of model and cost |
//! | [`dare`], [`care`], [`lqr`] | Riccati equations and the gains |
//! | [`poles`], [`structural`], [`singular_values`] | eigenvalues, controllability, observability; conditioning |
//! | [`controller`], [`margins`] | loops, their gain, phase, delay and modulus margins |
//! | [`late`] | the sampled plant with delays of the current and delays and filters of the sensors |
//! | `late_loop` | the loop around that plant; the law that predicts over a delay |
//! | [`excursions`] | weights from allowed excursions (Bryson's rule), and back |
//! | [`frequency_response`] | the open loop over frequency: Bode and Nyquist |
//! | [`linear_response`] | the loop's response to a constant torque and to a push, with bands |
//! | [`sensor_noise`] | standard deviations of angle, wheel speed and current that the sensors' noise causes |
//! | [`disturbance`] | largest gains of the loop from a disturbing torque |
//! | [`friction`], [`uncertainty`] | the loop around benches that differ from the model |
//! | [`recovery`], [`wheel_sizing`] | the angle from which the limits of current and wheel speed let the body recover |
//! | [`angle_bias`], [`bias_observer`] | the wheel speed that a bias of the angle causes, and the observer against it |
//!
//! States are (angle from upright in rad, rate in rad/s, wheel speed in rad/s), the input is the
//! motor current in A, and the law is u = −K x throughout.

#![warn(missing_docs)]

mod accepted;
pub mod angle_bias;
pub mod bias_observer;
pub mod care;
pub mod controller;
pub mod dare;
mod design;
pub mod disturbance;
mod double_double;
mod error;
pub mod excursions;
mod extended;
pub mod frequency_response;
pub mod friction;
pub mod late;
mod late_loop;
pub mod linear_response;
pub mod lqr;
pub mod margins;
mod matrix;
pub mod poles;
pub mod recovery;
pub mod sampled_cost;
pub mod sensor_noise;
mod settings;
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
pub use design::Design;
pub use disturbance::{TorqueResponse, torque_response};
pub use error::DesignError;
pub use excursions::Excursions;
pub use frequency_response::{LoopFrequency, frequency_response};
pub use friction::{ExtremeCheck, FrictionCheck, FrictionExtremes, Hunting, friction_check};
pub use late::{Lateness, SensorLateness};
pub use linear_response::{
    Band, BandedResponse, DisturbanceTorque, LinearResponse, ResponseSettings, UncertainLoop,
    banded_response, drawn_plants, linear_response,
};
pub use lqr::{
    ContinuousRegulator, DiscreteRegulator, Weights, continuous_regulator, discrete_regulator,
};
pub use margins::{Margins, late_margins, margins, margins_with_delay};
pub use poles::{Pole, eigenvalues, spectral_radius};
pub use recovery::recovery_angle_rad;
pub use sampled_cost::QuadraticCost;
pub use sensor_noise::{NoiseInLoop, SensorNoise, noise_in_late_loop, noise_in_loop};
pub use settings::Settings;
pub use structural::{StructuralRank, controllability, observability};
pub use uncertainty::{PoleUncertainty, UncertainParameters, UncertainPole, pole_uncertainty};
pub use wheel_sizing::{ChartPoint, Sizing, SizingPush, wheel_energy_j};
pub use zero_order_hold::{DelayedDiscrete, Discrete};
