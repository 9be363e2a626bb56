//! Errors: recordings that do not allow a calibration.

/// The reason why a recording gives no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Fewer data than the calibration needs.
    #[error("{what}: there are {found}, and at least {needed} are needed")]
    TooFew {
        /// The kind of data that is missing.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The number needed.
        needed: usize,
    },
    /// A number is NaN or infinite, or not positive where it must be.
    #[error(
        "{what} is {value}: a finite number is needed, greater than zero where it is a scale or a deviation"
    )]
    BadNumber {
        /// The quantity.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// The sensor turned although it should have been at rest.
    #[error(
        "the sensor turned although it should have been at rest: over parts of the recording, its {axis} axis reads up to {wander:.1} counts ({rate_deg_s:.2} °/s) away from its median, while its noise allows {noise:.2}; record it again on a firm table, without touching it"
    )]
    NotStill {
        /// x, y or z.
        axis: &'static str,
        /// Largest distance of a part's mean from the median, counts.
        wander: f64,
        /// This distance as a rate, °/s.
        rate_deg_s: f64,
        /// Standard deviation that noise alone gives such a mean, counts.
        noise: f64,
    },
    /// The data do not determine the result.
    #[error("{what}: {why}; {cure}")]
    NotDetermined {
        /// The result.
        what: &'static str,
        /// What is missing.
        why: &'static str,
        /// What to record instead.
        cure: &'static str,
    },
}

/// `value` if it is finite and positive.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<f64, CalibrationError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(CalibrationError::BadNumber { what, value })
    }
}

/// Refuses fewer than `needed`.
pub(crate) fn at_least(
    what: &'static str,
    found: usize,
    needed: usize,
) -> Result<(), CalibrationError> {
    if found < needed {
        Err(CalibrationError::TooFew {
            what,
            found,
            needed,
        })
    } else {
        Ok(())
    }
}
