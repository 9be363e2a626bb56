//! Straight lines: the converter's wheel speed over its counts, the drive's duty over current.

use crate::error::CalibrationError;
use crate::error::at_least;

/// y = `slope` x + `offset` by least squares.
#[derive(Clone, Debug, PartialEq)]
pub struct LineFit {
    /// Points that were left out because they do not lie on the line; empty for a plain fit.
    pub left_out: Vec<LeftOut>,
    /// Unit of y per unit of x.
    pub slope: f64,
    /// Standard error of the slope.
    pub slope_std: f64,
    /// y at x = 0, in the unit of y.
    pub offset: f64,
    /// Standard error of the offset. The errors of offset and slope are correlated unless the mean of x is zero.
    pub offset_std: f64,
    /// Correlation of the errors of slope and offset, −1 to 1.
    pub correlation: f64,
    /// y minus the line at each point, in the unit of y.
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

/// A point that was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeftOut {
    /// The abscissa of the point.
    pub x: f64,
    /// The ordinate of the point.
    pub y: f64,
    /// y minus the line of the other points, in the unit of y.
    pub residual: f64,
}

/// A residual beyond this many robust standard deviations is not noise.
const NOISE_DEVIATIONS: f64 = 6.0;

/// The variable of a line that is in whole counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counts {
    /// The abscissa: a converter's count.
    X,
    /// The ordinate: a drive's duty.
    Y,
}

/// A residual up to this many counts is accepted in any case: rounding causes up to half a count.
const ROUNDING_COUNTS: f64 = 2.0;

/// The line through points (x, y), without the points that do not lie on the line of the others. Such points occur at
/// the ends of a converter's range, where the count stays constant while the speed changes.
///
/// First, the line with the median of all slopes is computed (H. Theil, 1950; P. K. Sen, 1968); up to a
/// quarter of wrong points hardly changes it. Then follows least squares through the points near that line.
///
/// # Errors
/// If fewer than three points are given or left, a number is not finite, or there is only one value of x.
pub fn fit_line_within_range(
    points: &[(f64, f64)],
    counts: Counts,
) -> Result<LineFit, CalibrationError> {
    fit_line(points)?;
    // For a long recording, the pairs of every n-th point are enough.
    let few: Vec<_> = points
        .iter()
        .step_by(1 + points.len() / 400)
        .copied()
        .collect();
    let mut slopes = Vec::new();
    for (index, a) in few.iter().enumerate() {
        for b in &few[index + 1..] {
            if a.0 != b.0 {
                slopes.push((b.1 - a.1) / (b.0 - a.0));
            }
        }
    }
    let slope = middle(slopes);
    let offset = middle(points.iter().map(|(x, y)| y - slope * x).collect());
    let residual = |(x, y): &(f64, f64)| y - slope * x - offset;
    // 1.4826 times the median absolute deviation is the standard deviation of Gaussian noise.
    let noise = 1.4826 * middle(points.iter().map(|point| residual(point).abs()).collect());
    let count = match counts {
        Counts::X => slope.abs(),
        Counts::Y => 1.0,
    };
    let allowed = (NOISE_DEVIATIONS * noise).max(ROUNDING_COUNTS * count);
    let (near, far): (Vec<_>, Vec<_>) = points
        .iter()
        .copied()
        .partition(|point| residual(point).abs() <= allowed);
    let mut fit = fit_line(&near)?;
    fit.left_out = far
        .into_iter()
        .map(|(x, y)| LeftOut {
            x,
            y,
            residual: y - fit.at(x),
        })
        .collect();
    Ok(fit)
}

fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// The line through at least three points (x, y); the noise is estimated from the residuals.
///
/// # Errors
/// If there are fewer than three points, numbers that are not finite, or only one value of x.
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
        left_out: Vec::new(),
        slope,
        slope_std: (variance / spread).sqrt(),
        offset,
        offset_std: (variance * offset_share).sqrt(),
        correlation: -x_mean / (spread * offset_share).sqrt(),
        residuals,
        residual_std: variance.sqrt(),
    })
}
