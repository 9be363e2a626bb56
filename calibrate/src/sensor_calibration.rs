//! A sensor's line with its standard errors.

use attitude::SensorLine;
use nalgebra::{Matrix3, Vector3};

/// A three-axis sensor's line with its standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorCalibration {
    /// Bias (counts) and matrix (SI per count).
    pub line: SensorLine,
    /// Standard errors of the bias, counts.
    pub bias_std: Vector3<f64>,
    /// Standard errors of the matrix, SI per count; zero for entries that are not identified.
    pub matrix_std: Matrix3<f64>,
}
