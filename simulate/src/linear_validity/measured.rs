//! Helpers for the comparison of a measurement with the models.

use crate::error::SimulateError;

/// An error unless all series have the same number of samples, and at least two.
pub(super) fn check_lengths(series: &[(&'static str, usize)]) -> Result<(), SimulateError> {
    let expected = series.first().map_or(2, |(_, length)| (*length).max(2));
    for &(what, found) in series {
        if found != expected {
            return Err(SimulateError::WrongLength {
                what,
                found,
                expected,
            });
        }
    }
    Ok(())
}

/// Root mean square of measured − modelled over the finite samples.
pub(super) fn rmse(measured: &[f64], modelled: &[f64]) -> f64 {
    let differences = measured.iter().zip(modelled).map(|(y, m)| y - m);
    let counted: Vec<f64> = differences.filter(|d| d.is_finite()).collect();
    let squares: f64 = counted.iter().map(|d| d * d).sum();
    (squares / counted.len().max(1) as f64).sqrt()
}
