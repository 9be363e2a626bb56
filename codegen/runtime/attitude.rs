//! The attitude filter with the constants of this bench.

use fixed::types::I2F30;

use super::calibration::{calibrate, is_saturated};
use super::constants::{
    ANGLE_FACTOR, ANGLE_MAX, ANGLE_SHIFT, FILTER, LIMITS, MOUNTING_ANGLE, RATE_LINE,
};
use super::control::{Angle, Rate};
use super::filter::{FilterState, START, align, align_to, headed, is_gravity_usable, step_tracked};
use super::lever_arm::length_squared;
use super::line::on_line;
use super::pivot_angle::pivot_angle;
use super::product::clamp;
use super::scaling::is_within;

/// Attitude of the sensor from raw counts, by Madgwick's filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attitude {
    state: FilterState,
    drift: [i32; 3],
}

impl Attitude {
    /// A filter at rest whose sensor frame coincides with the earth's frame (z upwards).
    pub const fn new() -> Self {
        Attitude {
            state: START,
            drift: [0, 0, 0],
        }
    }

    /// Sets the attitude from the accelerometer alone. Nothing changes if the reading cannot be used.
    /// Returns whether the attitude was set.
    pub fn align(&mut self, accel: [i16; 3]) -> bool {
        let (state, is_usable) = align(&self.state, accel, &FILTER);
        self.state = state;
        is_usable
    }

    /// Sets the attitude from a mean reading of the accelerometer, in its calibrated units within ±2²⁹.
    /// Nothing changes if the reading is too short to be gravity.
    pub fn align_to(&mut self, up: [i32; 3]) {
        let within = [
            clamp(up[0], -0x2000_0000, 0x2000_0000),
            clamp(up[1], -0x2000_0000, 0x2000_0000),
            clamp(up[2], -0x2000_0000, 0x2000_0000),
        ];
        self.state = align_to(&self.state, within, &FILTER);
    }

    /// The accelerometer's reading in its calibrated units.
    pub fn reading(&self, accel: [i16; 3]) -> [i32; 3] {
        calibrate(accel, &FILTER.accel)
    }

    /// Whether an accelerometer reading can be used as the vertical, without a correction for motion.
    pub fn shows_gravity(&self, accel: [i16; 3]) -> bool {
        is_gravity_usable(accel, calibrate(accel, &FILTER.accel), &FILTER)
    }

    /// Whether the gyroscope or the accelerometer is at or beyond the end of its range.
    pub fn is_clipped(&self, gyro: [i16; 3], accel: [i16; 3]) -> bool {
        is_saturated(gyro, LIMITS.gyro_clip) || is_saturated(accel, FILTER.accel_clip)
    }

    /// Whether a sample looks like a body at rest: nearly no turn, and a reading as long as gravity.
    pub fn is_quiet(&self, gyro: [i16; 3], accel: [i16; 3]) -> bool {
        let turn = calibrate(gyro, &FILTER.gyro);
        let squared = length_squared(calibrate(accel, &FILTER.accel));
        is_within(turn[0], LIMITS.quiet_turn)
            && is_within(turn[1], LIMITS.quiet_turn)
            && is_within(turn[2], LIMITS.quiet_turn)
            && !is_saturated(accel, FILTER.accel_clip)
            && clamp(squared, LIMITS.gravity_low, LIMITS.gravity_high) == squared
    }

    /// One step with gyroscope and accelerometer, raw counts; the gyroscope's drift is followed.
    pub fn update_imu(&mut self, gyro: [i16; 3], accel: [i16; 3]) {
        let (state, drift) = step_tracked(&self.state, self.drift, gyro, accel, &FILTER);
        self.state = state;
        self.drift = drift;
    }

    /// As [`Attitude::update_imu`]; then the estimate is turned about the vertical towards magnetic north,
    /// by at most 2 β T. A turn about the vertical leaves the body's angle about the pivot as it is. The
    /// controller therefore has no use for the heading and does not call this.
    pub fn update_marg(&mut self, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
        self.update_imu(gyro, accel);
        self.state = headed(&self.state, mag, &FILTER);
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
