//! Recordings that cannot be calibrated from.

/// Why a recording yields no calibration.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrationError {
    /// Not enough data.
    #[error("{what}: {found} given, at least {needed} needed")]
    TooFew {
        /// What there is too little of.
        what: &'static str,
        /// How much there is.
        found: usize,
        /// How much is needed.
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
    /// The sensor turned while it was to lie still.
    #[error(
        "the sensor turned while it was to lie still: over parts of the recording its {axis} axis reads up to {wander:.1} counts ({rate_deg_s:.2} °/s) away from the rest, where its noise allows {noise:.2}; record it again on a firm table, with nobody touching it"
    )]
    NotStill {
        /// x, y or z.
        axis: &'static str,
        /// Farthest that the mean of a part is away, counts.
        wander: f64,
        /// The same in °/s.
        rate_deg_s: f64,
        /// Standard deviation that the noise gives such a mean, counts.
        noise: f64,
    },
    /// The data leaves a direction open.
    #[error("{what}: {why}; {cure}")]
    NotDetermined {
        /// What was to be found.
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
