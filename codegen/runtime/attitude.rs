//! The attitude filter with the constants of this bench.

use fixed::types::I2F30;

use super::constants::{ANGLE_FACTOR, ANGLE_MAX, ANGLE_SHIFT, FILTER, MOUNTING_ANGLE, RATE_LINE};
use super::control::{Angle, Rate};
use super::filter::{FilterState, START, align, step_imu, step_marg};
use super::line::on_line;
use super::pivot_angle::pivot_angle;
use super::product::clamp;

/// Attitude of the sensor from raw counts, by Madgwick's filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attitude {
    state: FilterState,
}

impl Attitude {
    /// Starts with the sensor's frame on the earth's (z upwards), at rest.
    pub const fn new() -> Self {
        Attitude { state: START }
    }

    /// Sets the attitude by the accelerometer alone; nothing changes if the reading cannot be
    /// used. Returns whether it could.
    pub fn align(&mut self, accel: [i16; 3]) -> bool {
        let (state, is_usable) = align(&self.state, accel, &FILTER);
        self.state = state;
        is_usable
    }

    /// One step with gyroscope and accelerometer, raw counts.
    pub fn update_imu(&mut self, gyro: [i16; 3], accel: [i16; 3]) {
        self.state = step_imu(&self.state, gyro, accel, &FILTER);
    }

    /// One step with gyroscope, accelerometer and magnetometer, raw counts.
    pub fn update_marg(&mut self, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
        self.state = step_marg(&self.state, gyro, accel, mag, &FILTER);
    }

    /// The attitude as a unit quaternion w, x, y, z: v in the earth's frame is q* v q in the
    /// sensor's.
    pub fn quaternion(&self) -> [I2F30; 4] {
        [
            I2F30::from_bits(self.state.quaternion[0]),
            I2F30::from_bits(self.state.quaternion[1]),
            I2F30::from_bits(self.state.quaternion[2]),
            I2F30::from_bits(self.state.quaternion[3]),
        ]
    }

    /// The body's angle about the pivot axis relative to upright, rad within ±π.
    pub fn angle(&self) -> Angle {
        let radians = pivot_angle(self.state.quaternion, MOUNTING_ANGLE);
        let clamped = clamp(radians, -ANGLE_MAX, ANGLE_MAX);
        Angle::from_bits((clamped * ANGLE_FACTOR) >> ANGLE_SHIFT)
    }

    /// The body's rate about the pivot axis in the last step, rad/s.
    pub fn rate(&self) -> Rate {
        Rate::from_bits(on_line(self.state.rate, &RATE_LINE))
    }
}

impl Default for Attitude {
    fn default() -> Self {
        Attitude::new()
    }
}
