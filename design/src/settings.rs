//! The requirements for a design.

use crate::friction::FrictionExtremes;
use crate::lqr::Weights;

/// The requirements for a design; the section `[design]` of model.toml.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Sample time in s.
    pub sample_time_s: f64,
    /// Weights of the cost.
    pub weights: Weights,
    /// Largest current in A.
    pub current_limit_a: f64,
    /// The linear models of the bench without and with all of its Coulomb friction, if it has any. The loop must be
    /// stable without the friction.
    pub friction_extremes: Option<FrictionExtremes>,
}

/// Sample time of the thesis' loop, s.
const SAMPLE_TIME_OF_THE_THESIS_S: f64 = 0.001;
/// Largest current of the thesis' drive, A.
const CURRENT_LIMIT_OF_THE_THESIS_A: f64 = 2.0;

impl Settings {
    /// The requirements for a model that states none: weights and sample time of the thesis, and the current limit of
    /// the bench if it is known, or else that of the thesis.
    pub fn usual(current_limit_a: Option<f64>) -> Settings {
        Settings {
            sample_time_s: SAMPLE_TIME_OF_THE_THESIS_S,
            weights: Weights::OF_THE_THESIS,
            current_limit_a: current_limit_a.unwrap_or(CURRENT_LIMIT_OF_THE_THESIS_A),
            friction_extremes: None,
        }
    }
}
