//! What a record keeps once it has computed it from its samples.

use std::sync::OnceLock;

/// What the samples say about the time before a window. It is computed once; a clone of a record computes its own,
/// because its samples may be changed.
#[derive(Debug, Default)]
pub(super) struct Past {
    pub(super) wheel_angle_rad: OnceLock<Vec<f64>>,
    /// The cache of [`super::Record::body_travel_before`], over the whole log.
    pub(super) travel_rad: OnceLock<Travel>,
}

impl Clone for Past {
    fn clone(&self) -> Past {
        Past::default()
    }
}

/// The movement of the body from each sample to the next, as measured.
#[derive(Debug)]
pub(super) struct Travel {
    /// From the rate if there is one, otherwise from the angle, rad.
    pub(super) step_rad: Vec<f64>,
    /// Accumulated disagreement between angle and rate up to each sample, rad; empty unless both are measured.
    pub(super) disagreement_rad: Vec<f64>,
}
