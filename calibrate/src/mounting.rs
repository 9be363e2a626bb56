//! The orientation of the sensor on the body: the pivot axis from a swing, the angle from hanging at rest.
//!
//! While the body swings about the pivot, the rate's direction is that of the axis: the
//! eigenvector of Σ ω ωᵀ with the largest eigenvalue λ₁. Noise of variance σ² across it tilts it
//! by σ/√(Σω²) rad, with σ² from the two small eigenvalues.
//!
//! Hanging at rest (α = 0, θ = −π) the mounting angle is m = atan2(−v_y, v_x) − θ, with v the
//! accelerometer's mean after the axis has been turned onto z.

use crate::error::{CalibrationError, at_least};
use crate::sensor_calibration::SensorCalibration;
use attitude::{SensorLine, pivot_angle_of_gravity, wrap_angle};
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, Vector3};

/// The orientation of the sensor on the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Pivot axis in the sensor's frame, a unit vector. Neither a swing nor gravity distinguishes the two opposite
    /// directions; this is the one nearer to the direction that the caller expects.
    pub axis: Vector3<f64>,
    /// Standard error of its direction, rad.
    pub axis_std_rad: f64,
    /// The rotation that takes the axis to z; every sensor's matrix is multiplied by it from the left.
    pub alignment: Rotation3<f64>,
    /// Angle from the body's axis to the sensor's x axis after the alignment, rad in [−π, π).
    pub angle_rad: f64,
    /// Its standard error from the noise of the accelerometer's mean and the standard errors of its
    /// calibration, rad.
    pub angle_std_rad: f64,
}

/// The smallest rotation that takes the pivot `axis` (in the sensor's frame) to z. For an axis nearer to −z, the
/// result is half a turn about the sensor's x axis, followed by the smallest rotation. In both cases, a small change
/// of the axis changes the rotation little.
pub fn alignment(axis: &Vector3<f64>) -> Rotation3<f64> {
    let smallest =
        |axis: &Vector3<f64>| Rotation3::rotation_between(axis, &Vector3::z()).unwrap_or_default();
    if axis.z < 0.0 {
        let half_turn = Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        // In floating point, sin π is not zero; rounding the entries makes the matrix exact.
        let half_turn = half_turn.matrix().map(f64::round);
        let half_turn = Rotation3::from_matrix_unchecked(half_turn);
        smallest(&(half_turn * axis)) * half_turn
    } else {
        smallest(axis)
    }
}

/// Axis and angle from a swing (raw gyroscope counts) and from hanging at rest (raw
/// accelerometer counts). Of the axis' two directions, the one nearer to `nearer_to` (in the sensor's frame)
/// is used.
///
/// # Errors
/// If there are too few samples, the rate of the swing does not stand out from noise and other axes (λ₁ below a
/// hundred times λ₂), or the pivot axis is more than 45° from `nearer_to`.
pub fn mounting(
    swing: &[[i16; 3]],
    gyro: &SensorLine,
    hanging: &[[i16; 3]],
    accel: &SensorCalibration,
    nearer_to: &Vector3<f64>,
) -> Result<Mounting, CalibrationError> {
    at_least("samples of the swing", swing.len(), 100)?;
    let moment: Matrix3<f64> = swing
        .iter()
        .map(|&raw| gyro.apply(raw))
        .map(|rate| rate * rate.transpose())
        .sum();
    let eigen = SymmetricEigen::new(moment);
    let largest = eigen.eigenvalues.imax();
    let along = eigen.eigenvalues[largest];
    let across = eigen.eigenvalues.sum() - along;
    if along.is_nan() || along <= 100.0 * across {
        return Err(CalibrationError::NotDetermined {
            what: "the pivot axis",
            why: "the rate of the swing has no single direction",
            cure: "record a swing of at least 20° with the wheel locked, and calibrate the gyroscope's bias first",
        });
    }
    let axis: Vector3<f64> = eigen.eigenvectors.column(largest).into_owned();
    let axis = if axis.dot(nearer_to) < 0.0 {
        -axis
    } else {
        axis
    };
    if axis.dot(nearer_to) < 0.5_f64.sqrt() {
        return Err(CalibrationError::NotDetermined {
            what: "the mounting",
            why: "the pivot axis is more than 45° from the sensor's stated z axis",
            cure: "state under [hardware.accelerometer] which body axis each of its axes shows",
        });
    }
    let alignment = alignment(&axis);
    // Noise tilts the axis in two directions across it. Each direction has swing.len() − 1 degrees of freedom, and the
    // variance of its tilt is σ²/λ₁.
    let variance = across / (2.0 * (swing.len() - 1) as f64);
    let axis_std_rad = (2.0 * variance / along).sqrt();

    let rest = crate::still::still(hanging)?;
    let line = &accel.line;
    let field_counts = rest.mean - line.bias_counts;
    let up = alignment * line.matrix * field_counts;
    let across_axis = up.x.hypot(up.y);
    if across_axis.is_nan() || across_axis <= 0.5 * up.norm() {
        return Err(CalibrationError::NotDetermined {
            what: "the mounting angle",
            why: "hanging at rest, gravity lies along the pivot axis",
            cure: "set up the bench so that the pivot axis is level, and record again",
        });
    }
    let tangent = Vector3::new(-up.y, up.x, 0.0) / (across_axis * across_axis);
    // The change of the angle per change of the calibrated reading, and per count on each axis.
    let per_reading = alignment.inverse() * tangent;
    let per_count = line.matrix.transpose() * per_reading;
    let mut variance = per_count.component_mul(&rest.mean_std).norm_squared()
        + per_count.component_mul(&accel.bias_std).norm_squared();
    for row in 0..3 {
        for column in 0..3 {
            let std = accel.matrix_std[(row, column)];
            variance += (per_reading[row] * field_counts[column] * std).powi(2);
        }
    }
    let angle = pivot_angle_of_gravity(&up, 0.0) + std::f64::consts::PI;
    Ok(Mounting {
        axis,
        axis_std_rad,
        alignment,
        angle_rad: wrap_angle(angle),
        angle_std_rad: variance.sqrt(),
    })
}
