//! One step of the attitude filter, from raw counts to the next state.
//!
//! The filter leaves out measurements that it cannot use:
//! - an accelerometer or magnetometer reading is not used if any axis is at or beyond the end of its
//!   range;
//! - an accelerometer vector is not used if it is shorter than g/8 after the lever-arm correction (free
//!   fall, the zero vector); a magnetic field is not used if it is shorter than its stated minimum;
//! - a step without a usable accelerometer reading integrates the gyroscope alone; without a usable
//!   magnetometer reading the heading follows from the gyroscope;
//! - a gyroscope reading at the end of its range is integrated as it is; the controller replaces it by the
//!   last reading within the range before it calls the filter.

use super::calibration::{SensorLine, calibrate, is_saturated};
use super::drift::{DriftGain, rate_error, tracked, without_drift};
use super::lever_arm::{LeverArm, length_squared, slow_rate, without_motion};
use super::madgwick::{
    Correction, NO_CORRECTION, ONE, aligned, correction_imu, heading_turn, turned, turned_about_up,
    unit_q28,
};

/// The constants of the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilterConstants {
    /// Gyroscope counts to half-angles ω T/2 in Q32.
    pub gyro: SensorLine,
    /// Accelerometer counts to the accelerometer's units: the sensor's range is 2²⁸ of them, or a little
    /// more.
    pub accel: SensorLine,
    /// Magnetometer counts to the magnetometer's units, chosen in the same way.
    pub mag: SensorLine,
    /// Squared length of the shortest usable accelerometer vector, in units of 2³²; at least 1.
    pub gravity_squared_min: i32,
    /// Squared length of the weakest usable field, in units of 2³²; at least 1.
    pub field_squared_min: i32,
    /// Lever-arm correction.
    pub lever_arm: LeverArm,
    /// β T in Q35, below 2²⁹.
    pub beta: i32,
    /// Largest magnitude of the accelerometer's counts; a reading at or beyond it is not used.
    pub accel_clip: [i32; 3],
    /// Largest magnitude of the magnetometer's counts; a reading at or beyond it is not used.
    pub mag_clip: [i32; 3],
    /// How the gyroscope's drift is estimated.
    pub drift: DriftGain,
}

/// The state of the filter after a step. Invariant: components of the quaternion within
/// [`super::madgwick::COMPONENT_MAX`], its length within 1 ± 2⁻¹², rates within ±2²⁹.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilterState {
    /// w, x, y, z in Q30.
    pub quaternion: [i32; 4],
    /// Half-angle of the last step about the pivot axis in Q32.
    pub rate: i32,
    /// The same, with a lag of two steps.
    pub slow_rate: i32,
}

/// At rest, with the sensor's frame on the earth's frame.
pub const START: FilterState = FilterState {
    quaternion: [ONE, 0, 0, 0],
    rate: 0,
    slow_rate: 0,
};

/// One step with gyroscope and accelerometer.
#[inline]
pub fn step_imu(
    state: &FilterState,
    gyro: [i16; 3],
    accel: [i16; 3],
    constants: &FilterConstants,
) -> FilterState {
    let turn = calibrate(gyro, &constants.gyro);
    let up = gravity(accel, turn[2], state.slow_rate, constants);
    let correction = if is_gravity_usable(accel, up, constants) {
        correction_imu(state.quaternion, unit_q28(up), constants.beta)
    } else {
        NO_CORRECTION
    };
    next(state, turn, &correction)
}

/// As [`step_imu`], with the gyroscope's drift taken out and followed: the state and the drift after
/// the step.
#[inline]
pub fn step_tracked(
    state: &FilterState,
    drift: [i32; 3],
    gyro: [i16; 3],
    accel: [i16; 3],
    constants: &FilterConstants,
) -> (FilterState, [i32; 3]) {
    let turn = without_drift(calibrate(gyro, &constants.gyro), drift, &constants.drift);
    let up = gravity(accel, turn[2], state.slow_rate, constants);
    let correction = if is_gravity_usable(accel, up, constants) {
        correction_imu(state.quaternion, unit_q28(up), constants.beta)
    } else {
        NO_CORRECTION
    };
    let error = rate_error(state.quaternion, &correction);
    let followed = [
        tracked(drift[0], error[0], &constants.drift),
        tracked(drift[1], error[1], &constants.drift),
        tracked(drift[2], error[2], &constants.drift),
    ];
    (next(state, turn, &correction), followed)
}

/// The state turned about the vertical towards magnetic north, by at most 2 β T; unchanged where the
/// magnetometer cannot be used.
#[inline(never)]
pub fn headed(state: &FilterState, mag: [i16; 3], constants: &FilterConstants) -> FilterState {
    let field = calibrate(mag, &constants.mag);
    if is_saturated(mag, constants.mag_clip) || length_squared(field) < constants.field_squared_min
    {
        return *state;
    }
    // β T from Q35 to Q32.
    let half_angle = heading_turn(state.quaternion, unit_q28(field), constants.beta >> 3);
    FilterState {
        quaternion: turned_about_up(state.quaternion, half_angle),
        rate: state.rate,
        slow_rate: state.slow_rate,
    }
}

/// The attitude by the accelerometer alone, and whether the reading could be used; otherwise the
/// state is unchanged.
#[inline]
pub fn align(
    state: &FilterState,
    accel: [i16; 3],
    constants: &FilterConstants,
) -> (FilterState, bool) {
    let up = calibrate(accel, &constants.accel);
    if is_gravity_usable(accel, up, constants) {
        let next = FilterState {
            quaternion: aligned(unit_q28(up)),
            rate: state.rate,
            slow_rate: state.slow_rate,
        };
        (next, true)
    } else {
        (*state, false)
    }
}

/// The attitude by a mean reading of the accelerometer in calibrated units, within ±2³⁰; the state is
/// unchanged if the reading is shorter than gravity may be.
#[inline]
pub fn align_to(state: &FilterState, up: [i32; 3], constants: &FilterConstants) -> FilterState {
    if length_squared(up) >= constants.gravity_squared_min {
        FilterState {
            quaternion: aligned(unit_q28(up)),
            rate: state.rate,
            slow_rate: state.slow_rate,
        }
    } else {
        *state
    }
}

/// The reading without the part of the body's motion; components within ±2³⁰.
#[inline]
fn gravity(accel: [i16; 3], rate: i32, slow: i32, constants: &FilterConstants) -> [i32; 3] {
    let reading = calibrate(accel, &constants.accel);
    without_motion(reading, rate, slow, &constants.lever_arm)
}

/// Whether `up`, from the counts `raw`, shows the vertical.
#[inline]
pub fn is_gravity_usable(raw: [i16; 3], up: [i32; 3], constants: &FilterConstants) -> bool {
    !is_saturated(raw, constants.accel_clip) && length_squared(up) >= constants.gravity_squared_min
}

/// The state after turning by `turn` and correcting.
#[inline]
fn next(state: &FilterState, turn: [i32; 3], correction: &Correction) -> FilterState {
    FilterState {
        quaternion: turned(state.quaternion, turn, correction),
        rate: turn[2],
        slow_rate: slow_rate(state.slow_rate, turn[2]),
    }
}
