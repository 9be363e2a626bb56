//! The errors of a simulation.

use crate::law::LawFailure;

/// The reason why a simulation gave no result.
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
    /// The law could not give a command.
    #[error("at {time_s:.3} s: {failure}")]
    Law {
        /// Time of the failure, s.
        time_s: f64,
        /// The message of the law.
        failure: LawFailure,
    },
    /// The motion did not stay finite.
    #[error("the simulated motion is no longer finite at {time_s:.3} s; check the parameters")]
    NotFinite {
        /// Time, s.
        time_s: f64,
    },
    /// Series of different lengths.
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
