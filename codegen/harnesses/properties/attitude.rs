//! The attitude filter: ranges, for any sensor readings.
//!
//! The state's invariant has two parts. The ranges of the components are proved by induction for every
//! bit pattern of every reading: [`step_keeps_ranges`]. The quaternion's length is a polynomial of
//! degree six, which bit-level solvers do not decide. The source checker proves it in exact
//! arithmetic, and [`step_keeps_length`] is tested on random states.

use generated::Attitude;
use generated::constants::{FILTER, MOUNTING_ANGLE};
use generated::filter::{FilterState, headed, step_imu, step_tracked};
use generated::madgwick::COMPONENT_MAX;
use generated::pivot_angle::pivot_angle;

/// Largest half-angle of a step: 2²⁹ in Q32.
pub const RATE_MAX: i32 = 0x2000_0000;

/// The quaternion's squared length stays within this of 1, in Q60: 2⁻¹¹.
pub const LENGTH_TOLERANCE: i64 = 1 << 49;

/// π in Q28, and one unit more for the rounding of the turn.
const ANGLE_MAX: i32 = 843_314_858;

/// Whether the ranges of the invariant hold.
pub fn in_ranges(state: &FilterState) -> bool {
    let component = |c: i32| (-COMPONENT_MAX..=COMPONENT_MAX).contains(&c);
    let rate = |r: i32| (-RATE_MAX..=RATE_MAX).contains(&r);
    let [w, x, y, z] = state.quaternion;
    component(w)
        && component(x)
        && component(y)
        && component(z)
        && rate(state.rate)
        && rate(state.slow_rate)
}

/// Whether the quaternion's length satisfies the invariant.
pub fn has_unit_length(state: &FilterState) -> bool {
    let squared: i64 = state
        .quaternion
        .iter()
        .map(|&c| i64::from(c) * i64::from(c))
        .sum();
    (squared - (1 << 60)).abs() <= LENGTH_TOLERANCE
}

/// Claim `filter-total`: from a state in its ranges and any reading, each step is defined and
/// leads to a state in its ranges, whose angle is within ±π.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn step_keeps_ranges(state: &FilterState, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
    six_axes_keep_ranges(state, gyro, accel);
    let next = step_imu(state, gyro, accel, &FILTER);
    heading_keeps_ranges(&next, mag);
    angle_is_within_half_a_turn(headed(&next, mag, &FILTER).quaternion);
}

/// The part of [`step_keeps_ranges`] that speaks of six axes.
///
/// # Panics
/// If it does not hold for these words.
pub fn six_axes_keep_ranges(state: &FilterState, gyro: [i16; 3], accel: [i16; 3]) {
    let next = step_imu(state, gyro, accel, &FILTER);
    assert!(in_ranges(&next), "a word is out of its range");
}

/// The part of [`step_keeps_ranges`] that speaks of the magnetometer.
///
/// # Panics
/// If it does not hold for these words.
pub fn heading_keeps_ranges(state: &FilterState, mag: [i16; 3]) {
    let next = headed(state, mag, &FILTER);
    assert!(in_ranges(&next), "a word is out of its range");
}

/// The step of the controller, which follows the gyroscope's drift: as [`six_axes_keep_ranges`], and the drift stays
/// within its limit.
///
/// # Panics
/// If it does not hold for these words.
pub fn tracked_step_keeps_ranges(
    state: &FilterState,
    drift: [i32; 3],
    gyro: [i16; 3],
    accel: [i16; 3],
) {
    let (next, drift) = step_tracked(state, drift, gyro, accel, &FILTER);
    assert!(in_ranges(&next), "a word is out of its range");
    let limit = FILTER.drift.limit;
    for value in drift {
        assert!(
            (-limit..=limit).contains(&value),
            "the drift is out of its range"
        );
    }
}

/// The part of [`step_keeps_ranges`] that speaks of the angle, for components in their ranges.
///
/// # Panics
/// If it does not hold for these words.
pub fn angle_is_within_half_a_turn(quaternion: [i32; 4]) {
    let angle = pivot_angle(quaternion, MOUNTING_ANGLE);
    assert!(
        (-ANGLE_MAX..=ANGLE_MAX).contains(&angle),
        "the angle is beyond half a turn"
    );
}

/// Claim `filter-length`: a quaternion whose squared length is 1 ± 2⁻¹¹ has such a length after
/// any step.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn step_keeps_length(state: &FilterState, gyro: [i16; 3], accel: [i16; 3], mag: [i16; 3]) {
    for next in [
        step_imu(state, gyro, accel, &FILTER),
        headed(state, mag, &FILTER),
    ] {
        assert!(has_unit_length(&next), "the length is wrong");
    }
}

/// The filter starts within its invariant.
///
/// # Panics
/// If it does not.
pub fn starts_in_the_invariant() {
    let start = generated::filter::START;
    assert!(in_ranges(&start) && has_unit_length(&start));
    assert!(Attitude::new().quaternion().map(|c| c.to_bits()) == start.quaternion);
}
