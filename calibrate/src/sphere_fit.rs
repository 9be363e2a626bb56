//! The distortion that maps a sphere to the measured ellipsoid.
//!
//! A field of constant length R, measured as counts m with bias b and a symmetric
//! distortion S, satisfies |S (m − b)| = R. A rotation in front of S would not change the length,
//! so lengths determine only a symmetric S (6 numbers, or 3 on the diagonal); the
//! rotation is part of the mounting.
//!
//! The start is the quadric through the points by linear least squares (m scaled to order one). Then
//! Gauss–Newton minimises the geometric residuals |S (m − b)|/R − 1 in units of the noise.

use crate::error::CalibrationError;
use crate::error::{at_least, positive};
use nalgebra::{DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};

/// The form of the distortion that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Bias and one scale for each axis: 6 numbers.
    Diagonal,
    /// Bias, scales and cross-axis terms: 9 numbers.
    Symmetric,
}

impl Shape {
    /// Number of unknowns.
    pub fn parameters(self) -> usize {
        match self {
            Shape::Diagonal => 6,
            Shape::Symmetric => 9,
        }
    }

    /// Entries of S: (row, column), row ≤ column.
    fn entries(self) -> &'static [(usize, usize)] {
        const ALL: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];
        match self {
            Shape::Diagonal => &ALL[..3],
            Shape::Symmetric => &ALL,
        }
    }
}

/// A fitted distortion.
#[derive(Clone, Debug, PartialEq)]
pub struct SphereFit {
    /// b, counts.
    pub bias: Vector3<f64>,
    /// S for a sphere of radius 1, 1/counts.
    pub matrix: Matrix3<f64>,
    /// Standard errors of b, counts.
    pub bias_std: Vector3<f64>,
    /// Standard errors of S, 1/counts.
    pub matrix_std: Matrix3<f64>,
    /// Root mean square of |S (m − b)| − 1.
    pub residual_rms: f64,
    /// Condition number of the weighted Jacobian with columns of unit length. Above about 1000,
    /// the points do not determine the unknowns separately.
    pub condition: f64,
}

/// Largest condition number that is accepted.
pub const CONDITION_MAX: f64 = 1e3;

/// Largest accepted standard error of a scale (relative to it) or of a bias (relative to the radius).
/// Beyond it, linearised standard errors are meaningless.
pub const LOOSE_MAX: f64 = 0.05;

/// Fits `shape` to points (counts) whose lengths have the standard deviations `deviation`
/// (counts). `known_noise` says whether these are known; otherwise only their ratios are, and the size
/// is estimated from the residuals.
///
/// # Errors
/// If there are too few points, or the points lie on no ellipsoid or do not determine it.
pub fn fit_sphere(
    points: &[Vector3<f64>],
    deviation: &[f64],
    shape: Shape,
    known_noise: bool,
) -> Result<SphereFit, CalibrationError> {
    let parameters = shape.parameters();
    at_least("directions of the field", points.len(), parameters)?;
    for value in deviation {
        positive("the standard deviation of a reading", *value)?;
    }
    let (mut bias, mut matrix) = start(points, shape)?;
    // Weights are relative to the mean scale, so that residuals are in standard deviations.
    let mut normal = (DMatrix::zeros(0, 0), DVector::zeros(0));
    let mut jacobian = DMatrix::zeros(points.len(), parameters);
    let mut residuals = DVector::zeros(points.len());
    for _ in 0..50 {
        let scale = matrix.trace() / 3.0;
        for (row, (point, deviation)) in points.iter().zip(deviation).enumerate() {
            let arm = point - bias;
            let image = matrix * arm;
            let length = image.norm();
            let unit = image / length;
            let weight = 1.0 / (deviation * scale);
            residuals[row] = (length - 1.0) * weight;
            let along = matrix * unit;
            for axis in 0..3 {
                jacobian[(row, axis)] = -along[axis] * weight;
            }
            for (column, &(i, j)) in shape.entries().iter().enumerate() {
                let slope = if i == j {
                    unit[i] * arm[i]
                } else {
                    unit[i] * arm[j] + unit[j] * arm[i]
                };
                jacobian[(row, 3 + column)] = slope * weight;
            }
        }
        normal = (
            jacobian.transpose() * &jacobian,
            jacobian.transpose() * &residuals,
        );
        let Some(step) = scaled_solve(&normal.0, &normal.1) else {
            return Err(undetermined());
        };
        bias -= Vector3::new(step[0], step[1], step[2]);
        for (column, &(i, j)) in shape.entries().iter().enumerate() {
            matrix[(i, j)] -= step[3 + column];
            if i != j {
                matrix[(j, i)] = matrix[(i, j)];
            }
        }
        if !bias.iter().chain(matrix.iter()).all(|x| x.is_finite()) {
            return Err(undetermined());
        }
        if step.dot(&normal.1).abs() < 1e-12 {
            break;
        }
    }
    let condition = scaled_condition(&jacobian);
    if condition.is_nan() || condition > CONDITION_MAX {
        return Err(undetermined());
    }
    let freedom = points.len() - parameters;
    let chi_squared = residuals.norm_squared();
    // Even known noise is enlarged if the residuals contradict it.
    let variance = match (freedom, known_noise) {
        (0, _) => 1.0,
        (_, true) => (chi_squared / freedom as f64).max(1.0),
        (_, false) => chi_squared / freedom as f64,
    };
    let covariance = scaled_inverse(&normal.0).ok_or_else(undetermined)? * variance;
    let std = |index: usize| covariance[(index, index)].max(0.0).sqrt();
    let mut matrix_std = Matrix3::zeros();
    for (column, &(i, j)) in shape.entries().iter().enumerate() {
        matrix_std[(i, j)] = std(3 + column);
        matrix_std[(j, i)] = std(3 + column);
    }
    let is_loose = (0..3).any(|axis| {
        let scale = matrix[(axis, axis)];
        let loosest = (matrix_std[(axis, axis)] / scale).max(std(axis) * scale);
        loosest.is_nan() || loosest > LOOSE_MAX
    });
    if is_loose {
        return Err(undetermined());
    }
    let lengths: Vec<f64> = points
        .iter()
        .map(|point| (matrix * (point - bias)).norm() - 1.0)
        .collect();
    let residual_rms = (lengths.iter().map(|x| x * x).sum::<f64>() / lengths.len() as f64).sqrt();
    Ok(SphereFit {
        bias,
        matrix,
        bias_std: Vector3::new(std(0), std(1), std(2)),
        matrix_std,
        residual_rms,
        condition,
    })
}

fn undetermined() -> CalibrationError {
    CalibrationError::NotDetermined {
        what: "bias and scale from lengths",
        why: "the recorded directions do not determine an ellipsoid",
        cure: "record directions all round, each axis up and down at least",
    }
}

/// Bias and S from the quadric mᵀ Q m + 2 gᵀ m = 1 through the points.
fn start(
    points: &[Vector3<f64>],
    shape: Shape,
) -> Result<(Vector3<f64>, Matrix3<f64>), CalibrationError> {
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let size = points
        .iter()
        .map(|point| (point - middle).norm())
        .fold(0.0, f64::max);
    if size == 0.0 || !size.is_finite() {
        return Err(undetermined());
    }
    let entries = shape.entries();
    let mut rows = DMatrix::zeros(points.len(), 3 + entries.len());
    for (row, point) in points.iter().enumerate() {
        let m = (point - middle) / size;
        for axis in 0..3 {
            rows[(row, axis)] = 2.0 * m[axis];
        }
        for (column, &(i, j)) in entries.iter().enumerate() {
            rows[(row, 3 + column)] = if i == j {
                m[i] * m[i]
            } else {
                2.0 * m[i] * m[j]
            };
        }
    }
    let ones = DVector::from_element(points.len(), 1.0);
    let solution = rows
        .svd(true, true)
        .solve(&ones, 1e-10)
        .map_err(|_| undetermined())?;
    let linear = Vector3::new(solution[0], solution[1], solution[2]);
    let mut quadric = Matrix3::zeros();
    for (column, &(i, j)) in entries.iter().enumerate() {
        quadric[(i, j)] = solution[3 + column];
        quadric[(j, i)] = solution[3 + column];
    }
    // (m − c)ᵀ Q (m − c) = 1 + cᵀ Q c with c = −Q⁻¹ g.
    let centre = -quadric.try_inverse().ok_or_else(undetermined)? * linear;
    let level = 1.0 + (quadric * centre).dot(&centre);
    let eigen = SymmetricEigen::new(quadric / level);
    if eigen
        .eigenvalues
        .iter()
        .any(|&value| value.is_nan() || value <= 0.0)
    {
        return Err(undetermined());
    }
    let root = eigen.eigenvectors
        * Matrix3::from_diagonal(&eigen.eigenvalues.map(f64::sqrt))
        * eigen.eigenvectors.transpose();
    Ok((middle + centre * size, root / size))
}

/// Solves with columns scaled to a unit diagonal (bias and scale differ by many orders).
fn scaled_solve(normal: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = normal.diagonal().map(|x| 1.0 / x.sqrt());
    let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] * scale[i] * scale[j]
    });
    let solution = scaled.lu().solve(&right.component_mul(&scale))?;
    Some(solution.component_mul(&scale))
}

fn scaled_inverse(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = normal.diagonal().map(|x| 1.0 / x.sqrt());
    let scaled = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] * scale[i] * scale[j]
    });
    let inverse = scaled.try_inverse()?;
    Some(DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}

/// Condition number of a Jacobian after scaling its columns to unit length.
fn scaled_condition(jacobian: &DMatrix<f64>) -> f64 {
    let mut scaled = jacobian.clone();
    for mut column in scaled.column_iter_mut() {
        let length = column.norm();
        column /= length;
    }
    let values = scaled.singular_values();
    values.max() / values.min()
}
