//! Magnetometer: hard-iron bias and soft-iron matrix from readings in all directions.

use crate::error::{CalibrationError, positive};
use crate::sensor_calibration::SensorCalibration;
use crate::sphere_fit::{Shape, fit_sphere};
use attitude::{SensorLine, is_saturated};
use nalgebra::{Matrix3, Vector3};

/// The readings of a magnetometer that can be used, and the reasons why others cannot.
#[derive(Clone, Debug, PartialEq)]
pub struct UsableReadings {
    /// Readings within the range of every axis.
    pub readings: Vec<[i16; 3]>,
    /// Readings at or beyond the stated limits, or far outside the sphere of the others: an
    /// overflow.
    pub overflowed: usize,
    /// Axes that stop at a value: x, y or z, with that value and the number of readings that have it.
    pub clipped: Vec<(&'static str, i16, usize)>,
}

/// A reading counts as an overflow if it is this many times farther from the middle than the median reading.
/// On an unevenly covered sphere, the farthest reading is about three times as far.
const OVERFLOW_DISTANCE: f64 = 5.0;

/// Number of times that the extreme value of an axis must occur to count as an end of the range. On a
/// sphere, all values of an axis are equally frequent (Archimedes), so the extreme occurs once or twice.
fn clip_occurrences(readings: usize, range: f64) -> f64 {
    6.0 + 10.0 * readings as f64 / range.max(1.0)
}

/// Leaves out readings at or beyond ±`clip`, overflows, and readings at a value where an axis
/// stops.
pub fn usable_readings(samples: &[[i16; 3]], clip: [i32; 3]) -> UsableReadings {
    let mut readings: Vec<[i16; 3]> = samples
        .iter()
        .copied()
        .filter(|&raw| !is_saturated(raw, clip))
        .collect();
    let middle = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let centre = Vector3::from_fn(|axis, _| {
        middle(readings.iter().map(|raw| f64::from(raw[axis])).collect())
    });
    let distance = |raw: &[i16; 3]| (Vector3::from(raw.map(f64::from)) - centre).norm();
    let usual = middle(readings.iter().map(&distance).collect());
    readings.retain(|raw| distance(raw) <= OVERFLOW_DISTANCE * usual);
    let overflowed = samples.len() - readings.len();

    let mut clipped = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let values = || readings.iter().map(|raw| raw[axis]);
        let (Some(low), Some(high)) = (values().min(), values().max()) else {
            continue;
        };
        let range = f64::from(high) - f64::from(low);
        for end in [low, high] {
            let times = values().filter(|value| *value == end).count();
            if times as f64 > clip_occurrences(readings.len(), range) {
                clipped.push((axis, name, end, times));
            }
        }
    }
    readings.retain(|raw| clipped.iter().all(|(axis, _, end, _)| raw[*axis] != *end));
    UsableReadings {
        readings,
        overflowed,
        clipped: clipped
            .into_iter()
            .map(|(_, name, end, times)| (name, end, times))
            .collect(),
    }
}

/// Share of the sphere that must be covered for a reliable result.
///
/// With half a sphere, only the curvature at its rim separates bias and scale along its axis.
pub const COVERAGE_MIN: f64 = 0.75;

/// Largest variation of the length after calibration, as a share of the length. The noise of the sensors in use is 1 %
/// of the earth's field. A larger variation comes from another field, that of a motor or of iron that moved.
pub const SPREAD_MAX: f64 = 0.03;

/// Directions of the coverage figure.
const DIRECTIONS: usize = 100;

/// A calibrated magnetometer.
#[derive(Clone, Debug, PartialEq)]
pub struct MagnetometerCalibration {
    /// Line in µT per count.
    pub sensor: SensorCalibration,
    /// Standard deviation of the length before the calibration, as a share of the mean length. The bias is not removed.
    pub spread_before: f64,
    /// Standard deviation of the length after the calibration, as a share of the mean length.
    pub spread_after: f64,
    /// Share of the sphere's directions with a reading within 15°.
    pub coverage: f64,
    /// Condition number of the fit.
    pub condition: f64,
    /// Readings in µT after calibration, for the figure.
    pub points_ut: Vec<Vector3<f64>>,
}

impl MagnetometerCalibration {
    /// Whether the readings lie on an ellipsoid: after calibration, their length varies by less than
    /// [`SPREAD_MAX`].
    pub fn fits(&self) -> bool {
        self.spread_after <= SPREAD_MAX
    }

    /// Whether enough of the sphere was covered.
    pub fn is_covered(&self) -> bool {
        self.coverage >= COVERAGE_MIN
    }
}

/// Fits bias and symmetric soft-iron matrix to raw counts taken in all directions, so that the
/// field has the length `field_ut` (µT; the local field, or mean length times the data sheet's
/// scale).
///
/// A reading with noise σ across the field is too long by σ²/R on average; this is
/// corrected, with σ from the residuals.
///
/// # Errors
/// Fewer than 50 readings; readings that lie on no ellipsoid.
pub fn magnetometer(
    samples: &[[i16; 3]],
    field_ut: f64,
) -> Result<MagnetometerCalibration, CalibrationError> {
    let field = positive("the field", field_ut)?;
    crate::error::at_least("magnetometer readings", samples.len(), 50)?;
    let points: Vec<Vector3<f64>> = samples
        .iter()
        .map(|raw| Vector3::from(raw.map(f64::from)))
        .collect();
    let fit = fit_sphere(&points, &vec![1.0; points.len()], Shape::Symmetric, false)?;
    let to_field = field * (1.0 + fit.residual_rms * fit.residual_rms);
    let matrix: Matrix3<f64> = fit.matrix * to_field;
    let line = SensorLine {
        bias_counts: fit.bias,
        matrix,
    };
    let points_ut: Vec<Vector3<f64>> = points.iter().map(|p| matrix * (p - fit.bias)).collect();
    Ok(MagnetometerCalibration {
        sensor: SensorCalibration {
            line,
            bias_std: fit.bias_std,
            matrix_std: fit.matrix_std * to_field,
        },
        spread_before: spread(&points),
        spread_after: spread(&points_ut),
        coverage: sphere_coverage(&points_ut),
        condition: fit.condition,
        points_ut,
    })
}

/// The field in µT from a sensor with the data sheet's scale `ut_per_count`: mean length of the raw
/// counts about the fitted bias.
///
/// # Errors
/// Fewer than 50 readings; readings that lie on no ellipsoid; a scale that is not positive.
pub fn mean_field_ut(samples: &[[i16; 3]], ut_per_count: f64) -> Result<f64, CalibrationError> {
    let scale = positive("the magnetometer's scale", ut_per_count)?;
    let bias = magnetometer(samples, 1.0)?.sensor.line.bias_counts;
    let lengths = samples
        .iter()
        .map(|raw| (Vector3::from(raw.map(f64::from)) - bias).norm());
    Ok(scale * lengths.sum::<f64>() / samples.len() as f64)
}

/// Standard deviation of the lengths, divided by their mean.
fn spread(points: &[Vector3<f64>]) -> f64 {
    let count = points.len() as f64;
    let mean = points.iter().map(Vector3::norm).sum::<f64>() / count;
    let variance = points
        .iter()
        .map(|point| (point.norm() - mean).powi(2))
        .sum::<f64>()
        / count;
    variance.sqrt() / mean
}

/// Share of 100 evenly spread directions (Fibonacci lattice) that have a point within 15°.
pub fn sphere_coverage(points: &[Vector3<f64>]) -> f64 {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let near = 15.0_f64.to_radians().cos();
    let covered = (0..DIRECTIONS).filter(|&index| {
        let z = 1.0 - (2.0 * index as f64 + 1.0) / DIRECTIONS as f64;
        let radius = (1.0 - z * z).sqrt();
        let turn = golden * index as f64;
        let direction = Vector3::new(radius * turn.cos(), radius * turn.sin(), z);
        points
            .iter()
            .any(|point| point.dot(&direction) >= near * point.norm() && point.norm() > 0.0)
    });
    covered.count() as f64 / DIRECTIONS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lattice on a sphere of 480 counts about a bias: 48 µT at 0.1 µT per count.
    #[test]
    fn the_mean_field_does_not_contain_the_bias() {
        let golden_angle = std::f64::consts::PI * (3.0 - 5_f64.sqrt());
        let samples: Vec<[i16; 3]> = (0..400)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 400.0;
                let across = (1.0 - z * z).sqrt();
                let (sin, cos) = (golden_angle * f64::from(i)).sin_cos();
                let counts = Vector3::new(across * cos, across * sin, z) * 480.0;
                [counts.x + 200.0, counts.y - 350.0, counts.z + 90.0].map(|c| c.round() as i16)
            })
            .collect();
        let field = mean_field_ut(&samples, 0.1).expect("covered all round");
        // Rounding to counts: 0.3 counts a reading, a hundredth of that in the mean.
        assert!((field - 48.0).abs() < 0.005, "{field}");
        assert!(mean_field_ut(&samples, 0.0).is_err());
    }
}
