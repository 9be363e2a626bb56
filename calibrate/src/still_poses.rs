//! Accelerometer from still poses (thesis 3.2.1: six poses of 2,000 samples).
//!
//! At rest, the true vector has the length g in every pose. Bias and scales therefore follow from
//! lengths alone, and no pose has to be aligned. Six poses determine the bias and three scales;
//! cross-axis terms need nine sufficiently different poses.

use crate::error::CalibrationError;
use crate::error::positive;
use crate::sensor_calibration::SensorCalibration;
use crate::sphere_fit::{CONDITION_MAX, Shape, SphereFit, fit_sphere};
use crate::still::{Still, still};
use attitude::SensorLine;
use nalgebra::Vector3;

/// Calibrated accelerometer.
#[derive(Clone, Debug, PartialEq)]
pub struct AccelerometerCalibration {
    /// Line in m/s² per count.
    pub sensor: SensorCalibration,
    /// The fitted shape: with cross-axis terms if the poses determine them.
    pub shape: Shape,
    /// Mean, noise and standard error in each pose, counts.
    pub poses: Vec<Still>,
    /// Length minus g in each pose after calibration, m/s². Zero for six poses, which determine six
    /// unknowns exactly.
    pub residuals_m_s2: Vec<f64>,
    /// Condition number of the fit.
    pub condition: f64,
}

/// Calibrates from the raw counts of at least six still poses; `gravity_m_s2` is the local g.
///
/// # Errors
/// If there are fewer than six poses, or fewer than 40 samples in one; if the poses do not determine the result.
pub fn accelerometer(
    poses: &[Vec<[i16; 3]>],
    gravity_m_s2: f64,
) -> Result<AccelerometerCalibration, CalibrationError> {
    let gravity = positive("gravity", gravity_m_s2)?;
    crate::error::at_least("still poses", poses.len(), Shape::Diagonal.parameters())?;
    let poses = poses
        .iter()
        .map(|samples| still(samples))
        .collect::<Result<Vec<_>, _>>()?;
    let points: Vec<Vector3<f64>> = poses.iter().map(|pose| pose.mean).collect();
    let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    // The error of a length is the component of the mean's error along the field. For a sensor without noise, this
    // error is the rounding that `still` adds.
    let deviation: Vec<f64> = poses
        .iter()
        .map(|pose| {
            let along = (pose.mean - middle)
                .try_normalize(0.0)
                .unwrap_or_else(Vector3::x);
            along.component_mul(&pose.mean_std).norm()
        })
        .collect();
    let with_cross_axis = if points.len() >= Shape::Symmetric.parameters() {
        fit_sphere(&points, &deviation, Shape::Symmetric, true)
            .ok()
            .filter(|fit| fit.condition <= CONDITION_MAX)
            .map(|fit| (fit, Shape::Symmetric))
    } else {
        None
    };
    let (fit, shape) = match with_cross_axis {
        Some(found) => found,
        None => (
            fit_sphere(&points, &deviation, Shape::Diagonal, true)?,
            Shape::Diagonal,
        ),
    };
    let line = SensorLine {
        bias_counts: fit.bias,
        matrix: fit.matrix * gravity,
    };
    let residuals_m_s2 = points
        .iter()
        .map(|point| (line.matrix * (point - fit.bias)).norm() - gravity)
        .collect();
    let SphereFit {
        bias_std,
        matrix_std,
        condition,
        ..
    } = fit;
    Ok(AccelerometerCalibration {
        sensor: SensorCalibration {
            line,
            bias_std,
            matrix_std: matrix_std * gravity,
        },
        shape,
        poses,
        residuals_m_s2,
        condition,
    })
}
