//! What can go wrong in a simulation.

use crate::law::LawFailure;

/// Why a simulation gave no result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulateError {
    /// A quantity that must be positive is not (or is not finite).
    #[error("{what} is {value}; it must be a finite number greater than zero")]
    NotPositive {
        /// The quantity, with its unit.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The law did not give a command.
    #[error("at {time_s:.3} s: {failure}")]
    Law {
        /// When, in s.
        time_s: f64,
        /// What the law said.
        failure: LawFailure,
    },
    /// The motion left all bounds.
    #[error("the simulated motion is no longer finite at {time_s:.3} s; check the parameters")]
    NotFinite {
        /// When, in s.
        time_s: f64,
    },
    /// Series that do not fit together.
    #[error("{what} has {found} samples; {expected} are needed")]
    WrongLength {
        /// The series.
        what: &'static str,
        /// Samples that it has.
        found: usize,
        /// Samples that it must have.
        expected: usize,
    },
    /// A matrix could not be computed.
    #[error(transparent)]
    Design(#[from] design::DesignError),
}

/// Errors unless `value` is finite and greater than zero.
pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), SimulateError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(SimulateError::NotPositive { what, value })
    }
}
