//! Numbers with their standard errors, and the amplitude at which they were found.

/// A number with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error, same unit.
    pub std: f64,
}

/// A quantity at a certain amplitude of the swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtAmplitude {
    /// Time, s.
    pub time_s: f64,
    /// Amplitude of the swing, rad.
    pub amplitude_rad: f64,
    /// The quantity.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}
