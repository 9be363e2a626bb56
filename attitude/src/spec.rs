//! The properties of the sensor and its mounting that a filter needs, as plain data.

use nalgebra::{Matrix3, Vector3};

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.80665;

/// The line from raw counts of a three-axis sensor to SI units:
/// value = `matrix` · (counts − `bias_counts`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorLine {
    /// Reading at zero input, in counts.
    pub bias_counts: Vector3<f64>,
    /// Scale, cross-axis terms and alignment in one matrix, in SI units per count.
    pub matrix: Matrix3<f64>,
}

impl SensorLine {
    /// A sensor without bias or cross-axis error: `scale` SI units per count on each axis.
    pub fn ideal(scale: f64) -> Self {
        SensorLine {
            bias_counts: Vector3::zeros(),
            matrix: Matrix3::from_diagonal_element(scale),
        }
    }

    /// The measured vector in SI units.
    pub fn apply(&self, raw: [i16; 3]) -> Vector3<f64> {
        let counts = Vector3::new(f64::from(raw[0]), f64::from(raw[1]), f64::from(raw[2]));
        self.matrix * (counts - self.bias_counts)
    }
}

/// All parameters of the attitude filter, in f64 and in fixed point alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudeSpec {
    /// Time between two steps, s.
    pub sample_time_s: f64,
    /// Madgwick's β, rad/s (see [`crate::beta_from_gyro_noise`]).
    pub beta_rad_s: f64,
    /// Time constant with which the gyroscope's drift is tracked, s: β/ζ of Madgwick's equations 47 to 49.
    pub drift_time_s: f64,
    /// Largest drift that is tracked, rad/s.
    pub drift_limit_rad_s: f64,
    /// Gyroscope, rad/s per count.
    pub gyro: SensorLine,
    /// Accelerometer, m/s² per count. At rest it reads +g upwards.
    pub accel: SensorLine,
    /// Magnetometer, µT per count.
    pub mag: SensorLine,
    /// Count of the gyroscope's axes at or beyond which (in either direction) the true rate is unknown.
    pub gyro_clip: [i32; 3],
    /// Count of the accelerometer's axes at or beyond which the true value is unknown.
    pub accel_clip: [i32; 3],
    /// Count of the magnetometer's axes at or beyond which the true value is unknown.
    pub mag_clip: [i32; 3],
    /// Field below which the magnetometer is not used, µT.
    pub field_min_ut: f64,
    /// Gravity at the bench, m/s².
    pub gravity_m_s2: f64,
    /// Angle about the pivot axis from the body's axis (pivot to centre of mass) to the
    /// sensor's x axis, rad.
    pub mounting_angle_rad: f64,
    /// Position of the accelerometer from the pivot axis in the sensor's x and y, m.
    /// Zero switches the correction off.
    pub lever_arm_m: [f64; 2],
}

impl AttitudeSpec {
    /// The thesis' sensors by their data sheets: FXAS21002 at ±2000 °/s (62.5 m°/s per count),
    /// FXOS8700 at ±8 g (4096 counts/g) and 0.1 µT per count; 1 kHz; β = 0.033 rad/s, the best
    /// six-axis value of Madgwick's report. The thesis states no lever arm, so it is zero.
    pub fn thesis() -> Self {
        AttitudeSpec {
            sample_time_s: 1e-3,
            beta_rad_s: 0.033,
            // Longer than a push (a second), shorter than the warming up of the sensor (minutes).
            drift_time_s: 60.0,
            // The largest bias that data sheets allow without calibration.
            drift_limit_rad_s: 5_f64.to_radians(),
            gyro: SensorLine::ideal(62.5e-3_f64.to_radians()),
            accel: SensorLine::ideal(STANDARD_GRAVITY / 4096.0),
            mag: SensorLine::ideal(0.1),
            gyro_clip: [32_767; 3],
            // 14 bits, left-justified.
            accel_clip: [32_764; 3],
            mag_clip: [12_000; 3],
            field_min_ut: 10.0,
            gravity_m_s2: STANDARD_GRAVITY,
            mounting_angle_rad: 0.0,
            lever_arm_m: [0.0, 0.0],
        }
    }
}
