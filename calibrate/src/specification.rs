//! From calibrations to what the attitude filter needs.

use crate::mounting::Mounting;
use crate::sensor_calibration::SensorCalibration;
use attitude::{AttitudeSpec, SensorLine};

/// What has been calibrated; what has not keeps the value of the base.
#[derive(Clone, Copy, Debug, Default)]
pub struct Calibrated<'a> {
    /// Accelerometer, m/s² per count.
    pub accelerometer: Option<&'a SensorCalibration>,
    /// Gyroscope, rad/s per count.
    pub gyroscope: Option<&'a SensorCalibration>,
    /// Magnetometer, µT per count.
    pub magnetometer: Option<&'a SensorCalibration>,
    /// Place on the body; turns all three sensors, so that z lies along the pivot axis.
    pub mounting: Option<&'a Mounting>,
    /// Position of the accelerometer from the pivot axis along x and y of the aligned sensor, m.
    pub lever_arm_m: Option<[f64; 2]>,
    /// Madgwick's β from the gyroscope's noise, rad/s.
    pub beta_rad_s: Option<f64>,
}

/// `base` with everything that has been calibrated.
pub fn attitude_spec(base: &AttitudeSpec, calibrated: &Calibrated) -> AttitudeSpec {
    let line = |sensor: Option<&SensorCalibration>, fallback: &SensorLine| {
        let line = sensor.map_or(*fallback, |sensor| sensor.line);
        match calibrated.mounting {
            Some(mounting) => SensorLine {
                bias_counts: line.bias_counts,
                matrix: mounting.alignment.matrix() * line.matrix,
            },
            None => line,
        }
    };
    AttitudeSpec {
        beta_rad_s: calibrated.beta_rad_s.unwrap_or(base.beta_rad_s),
        gyro: line(calibrated.gyroscope, &base.gyro),
        accel: line(calibrated.accelerometer, &base.accel),
        mag: line(calibrated.magnetometer, &base.mag),
        mounting_angle_rad: calibrated
            .mounting
            .map_or(base.mounting_angle_rad, |mounting| mounting.angle_rad),
        lever_arm_m: calibrated.lever_arm_m.unwrap_or(base.lever_arm_m),
        ..*base
    }
}
