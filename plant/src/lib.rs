//! The reaction-wheel pendulum: motion, physical effects, sensors, experiments.
//!
//! One generic right-hand side serves simulation, the fit's sensitivities and linearisation.

mod experiment;
mod linear;

pub use experiment::Kind;
pub use linear::LinearModel;
