//! Straight lines: the converter's wheel speed over its counts, the drive's duty over current.

use crate::error::CalibrationError;
use crate::error::at_least;

/// y = `slope` x + `offset` by least squares.
#[derive(Clone, Debug, PartialEq)]
pub struct LineFit {
    /// Unit of y per unit of x.
    pub slope: f64,
    /// Its standard error.
    pub slope_std: f64,
    /// y at x = 0.
    pub offset: f64,
    /// Its standard error. It correlates with the slope's unless the x lie about zero.
    pub offset_std: f64,
    /// Correlation of the errors of slope and offset.
    pub correlation: f64,
    /// y minus the line at each point.
    pub residuals: Vec<f64>,
    /// Standard deviation of the residuals, with n − 2 degrees of freedom.
    pub residual_std: f64,
}

impl LineFit {
    /// The line at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.slope * x + self.offset
    }
}

/// The line through at least three points (x, y), the noise taken from the residuals.
///
/// # Errors
/// Fewer than three points, numbers that are not finite, all x equal.
pub fn fit_line(points: &[(f64, f64)]) -> Result<LineFit, CalibrationError> {
    at_least("points of a line", points.len(), 3)?;
    for &(x, y) in points {
        for value in [x, y] {
            if !value.is_finite() {
                return Err(CalibrationError::BadNumber {
                    what: "a point of a line",
                    value,
                });
            }
        }
    }
    let count = points.len() as f64;
    let x_mean = points.iter().map(|p| p.0).sum::<f64>() / count;
    let y_mean = points.iter().map(|p| p.1).sum::<f64>() / count;
    let spread: f64 = points.iter().map(|p| (p.0 - x_mean).powi(2)).sum();
    if spread <= 0.0 {
        return Err(CalibrationError::NotDetermined {
            what: "a line",
            why: "all points have the same abscissa",
            cure: "record several speeds or currents",
        });
    }
    let slope = points
        .iter()
        .map(|p| (p.0 - x_mean) * (p.1 - y_mean))
        .sum::<f64>()
        / spread;
    let offset = y_mean - slope * x_mean;
    let residuals: Vec<f64> = points.iter().map(|p| p.1 - slope * p.0 - offset).collect();
    let variance = residuals.iter().map(|r| r * r).sum::<f64>() / (count - 2.0);
    let offset_share = 1.0 / count + x_mean * x_mean / spread;
    Ok(LineFit {
        slope,
        slope_std: (variance / spread).sqrt(),
        offset,
        offset_std: (variance * offset_share).sqrt(),
        correlation: -x_mean / (spread * offset_share).sqrt(),
        residuals,
        residual_std: variance.sqrt(),
    })
}
