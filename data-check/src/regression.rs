//! Straight lines through two noisy series, and least squares with standard errors.

use nalgebra::{DMatrix, DVector};

use crate::thresholds::fit::INDEPENDENT;

/// A line y = factor · x + const through two series that both have noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ratio {
    /// The factor: the geometric mean of the two regressions, with the sign of the correlation.
    pub factor: f64,
    /// The correlation of x and y. The two regressions are factor · |correlation| and factor / |correlation|. For any
    /// noise of x and of y, the true factor lies between them (Frisch, *Statistical Confluence Analysis*,
    /// 1934).
    pub correlation: f64,
    /// Number of points.
    pub points: usize,
}

/// The ratio of two series; `None` for fewer than `fewest` finite points, or if one of the series is constant.
pub(crate) fn ratio(points: &[(f64, f64)], fewest: usize) -> Option<Ratio> {
    let finite: Vec<(f64, f64)> = points
        .iter()
        .copied()
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect();
    if finite.len() < fewest.max(3) {
        return None;
    }
    let n = finite.len() as f64;
    let (mean_x, mean_y) = finite
        .iter()
        .fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / n, sum.1 + p.1 / n));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in &finite {
        let (x, y) = (x - mean_x, y - mean_y);
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    let correlation = xy / (xx * yy).sqrt();
    correlation.is_finite().then(|| Ratio {
        factor: (yy / xx).sqrt().copysign(xy),
        correlation,
        points: finite.len(),
    })
}

/// The result of least squares: coefficients with their standard errors, and the share of the right-hand side's
/// variance that they explain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LeastSquares {
    pub coefficients: Vec<f64>,
    pub std: Vec<f64>,
    pub explained: f64,
    /// Number of rows used.
    pub rows: usize,
    /// Number of rows that share one sample.
    overlap: f64,
}

impl LeastSquares {
    /// Share of the variance left by the other columns that this column explains. Noise in the column draws its
    /// coefficient towards 0, but by no more than this factor (Frisch's bounds, as in [`Ratio`]).
    pub fn partial(&self, column: usize) -> f64 {
        let sharpness = (self.coefficients[column] / self.std[column]).powi(2) * self.overlap;
        sharpness / (sharpness + self.rows as f64)
    }
}

/// Solves rows · coefficients = right. `overlap` is the number of rows that share one sample; the standard errors are
/// computed for that many times fewer rows. Rows with values that are not finite are left out. `None` if too few rows
/// are left or the columns are linearly dependent.
pub(crate) fn least_squares<const N: usize>(
    rows: &[([f64; N], f64)],
    overlap: f64,
) -> Option<LeastSquares> {
    let finite: Vec<&([f64; N], f64)> = rows
        .iter()
        .filter(|(row, right)| row.iter().all(|x| x.is_finite()) && right.is_finite())
        .collect();
    let count = finite.len();
    if count < 3 * N {
        return None;
    }
    // Columns are scaled to equal size, so that a dependent column can be distinguished from a small one.
    let mut scale = [0.0_f64; N];
    for (row, _) in &finite {
        for (size, x) in scale.iter_mut().zip(row) {
            *size += x * x;
        }
    }
    let scale = scale.map(|square| square.sqrt());
    if scale.contains(&0.0) {
        return None;
    }
    let matrix = DMatrix::from_fn(count, N, |row, column| {
        finite[row].0[column] / scale[column]
    });
    let right = DVector::from_fn(count, |row, _| finite[row].1);
    let normal = matrix.transpose() * &matrix;
    if normal.clone().symmetric_eigenvalues().min() < INDEPENDENT {
        return None;
    }
    let inverse = normal.try_inverse()?;
    let found = &inverse * matrix.transpose() * &right;
    let left_over = (&right - &matrix * &found).norm_squared();
    let mean = right.mean();
    let total = right.map(|y| (y - mean) * (y - mean)).sum();
    let scatter = left_over / (count - N) as f64;
    let coefficients = (0..N).map(|k| found[k] / scale[k]).collect();
    let std = (0..N)
        .map(|k| (inverse[(k, k)] * scatter * overlap).sqrt() / scale[k])
        .collect();
    Some(LeastSquares {
        coefficients,
        std,
        rows: count,
        overlap,
        explained: 1.0 - left_over / total.max(f64::MIN_POSITIVE),
    })
}
