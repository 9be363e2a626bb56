//! From raw counts to the attitude: calibration, lever arm, the rule for unusable measurements and
//! Madgwick's step, combined as in the emitted filter.

use crate::lever_arm::LeverArm;
use crate::madgwick::Madgwick;
use crate::measurement::{GRAVITY_SHARE_MIN, is_saturated};
use crate::pivot_angle::pivot_angle;
use crate::spec::AttitudeSpec;
use nalgebra::{Quaternion, Vector3};

/// The reference filter on raw counts.
#[derive(Clone, Copy, Debug)]
pub struct RawFilter {
    spec: AttitudeSpec,
    filter: Madgwick,
    lever_arm: LeverArm,
    drift_rad_s: Vector3<f64>,
}

impl RawFilter {
    /// Starts with the sensor frame on the earth frame.
    pub fn new(spec: &AttitudeSpec) -> Self {
        RawFilter {
            spec: *spec,
            filter: Madgwick::new(spec.beta_rad_s, spec.sample_time_s),
            lever_arm: LeverArm::new(spec.lever_arm_m, spec.sample_time_s),
            drift_rad_s: Vector3::zeros(),
        }
    }

    /// Sets the attitude from the accelerometer alone, if its reading can be used; returns
    /// whether it could.
    pub fn align(&mut self, accel: [i16; 3]) -> bool {
        let up = self.spec.accel.apply(accel);
        let usable = self.gravity_usable(accel, &up);
        if usable {
            self.filter.align(&up);
        }
        usable
    }

    /// One step with gyroscope and accelerometer.
    pub fn update_imu(&mut self, gyro: [i16; 3], accel: [i16; 3]) {
        let rate = self.spec.gyro.apply(gyro);
        match self.gravity(accel, rate.z) {
            Some(up) => self.filter.step_imu(&rate, &up),
            None => self.filter.step_gyro(&rate),
        }
    }

    /// One step with gyroscope and accelerometer that also estimates the gyroscope's drift b and subtracts it (Madgwick
    /// 2010, eq. 47 to 49): b ← b + ζ T ω_ε, where ζ is β divided by `drift_time_s`.
    pub fn update_imu_tracked(&mut self, gyro: [i16; 3], accel: [i16; 3]) {
        let rate = self.spec.gyro.apply(gyro) - self.drift_rad_s;
        let error = match self.gravity(accel, rate.z) {
            Some(up) => self.filter.step_imu_with_error(&rate, &up),
            None => {
                self.filter.step_gyro(&rate);
                Vector3::zeros()
            }
        };
        let zeta = self.spec.beta_rad_s / self.spec.drift_time_s;
        let limit = self.spec.drift_limit_rad_s;
        let next = self.drift_rad_s + 2.0 * zeta * self.spec.sample_time_s * error;
        self.drift_rad_s = next.map(|drift| drift.clamp(-limit, limit));
    }

    /// The estimate of the gyroscope's drift, rad/s.
    pub fn drift_rad_s(&self) -> Vector3<f64> {
        self.drift_rad_s
    }

    /// One step with gyroscope, accelerometer and estimate of the drift, then a turn about the vertical towards
    /// magnetic north.
    pub fn update_marg(&mut self, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
        self.update_imu_tracked(gyro, accel);
        self.turn_to_north(mag);
    }

    /// The part of [`RawFilter::update_marg`] that the magnetometer does: a turn about the vertical towards north, by
    /// at most 2 β T; none if the reading cannot be used.
    pub fn turn_to_north(&mut self, mag: [i16; 3]) {
        if let Some(field) = self.field(mag) {
            self.filter.turn_to_north(&field);
        }
    }

    /// One step with gyroscope, accelerometer and magnetometer as Madgwick's report of 2010 has it: one gradient of
    /// both errors, without an estimate of the drift; the field may tilt the estimate. For comparison.
    pub fn update_marg_of_2010(&mut self, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
        let rate = self.spec.gyro.apply(gyro);
        match (self.gravity(accel, rate.z), self.field(mag)) {
            (Some(up), Some(field)) => self.filter.step_marg(&rate, &up, &field),
            (Some(up), None) => self.filter.step_imu(&rate, &up),
            (None, _) => self.filter.step_gyro(&rate),
        }
    }

    /// The attitude, a unit quaternion.
    pub fn quaternion(&self) -> Quaternion<f64> {
        self.filter.quaternion()
    }

    /// The body angle relative to upright, rad in [−π, π).
    pub fn angle_rad(&self) -> f64 {
        pivot_angle(&self.filter.quaternion(), self.spec.mounting_angle_rad)
    }

    /// The reaction to gravity at the sensor; `None` if the reading cannot be used (see `measurement`).
    fn gravity(&mut self, accel: [i16; 3], rate_rad_s: f64) -> Option<Vector3<f64>> {
        let reading = self.spec.accel.apply(accel);
        let up = self.lever_arm.correct(reading, rate_rad_s);
        self.gravity_usable(accel, &up).then_some(up)
    }

    /// The magnetic field; `None` if the reading cannot be used.
    fn field(&self, mag: [i16; 3]) -> Option<Vector3<f64>> {
        let field = self.spec.mag.apply(mag);
        let usable =
            !is_saturated(mag, self.spec.mag_clip) && field.norm() >= self.spec.field_min_ut;
        usable.then_some(field)
    }

    fn gravity_usable(&self, accel: [i16; 3], up: &Vector3<f64>) -> bool {
        !is_saturated(accel, self.spec.accel_clip)
            && up.norm() >= GRAVITY_SHARE_MIN * self.spec.gravity_m_s2
    }
}
