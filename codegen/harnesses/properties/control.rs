//! The control law: u = −K x, rounded once, within the current limit.
//!
//! Arguments are the words of the inputs as `generated` types them; any word is allowed.

use generated::control::{ANGLE_GAIN, RATE_GAIN, SHIFT, WHEEL_SPEED_GAIN};
use generated::{Angle, CURRENT_LIMIT, Rate, WheelSpeed};

/// The word of the command for the words of the states.
pub fn command_bits(angle_bits: i32, rate_bits: i32, wheel_speed_bits: i32) -> i32 {
    generated::control(
        Angle::from_bits(angle_bits),
        Rate::from_bits(rate_bits),
        WheelSpeed::from_bits(wheel_speed_bits),
    )
    .to_bits()
}

/// Claim `control-total`: the law is defined and its command, which is returned as a word, within
/// the limit.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn total(angle_bits: i32, rate_bits: i32, wheel_speed_bits: i32) -> i32 {
    let command = command_bits(angle_bits, rate_bits, wheel_speed_bits);
    let limit = CURRENT_LIMIT.to_bits();
    assert!(command <= limit, "the command is above the limit");
    assert!(command >= -limit, "the command is below the limit");
    command
}

/// Claim `control-accurate`: the command is within half a unit of the saturated exact law with the
/// quantised gains.
///
/// The exact law is the plain sum of products in 128 bits, where nothing can overflow. It counts
/// in units of the command divided by 2^[`SHIFT`].
///
/// # Panics
/// If the claim does not hold for these words.
pub fn accurate(angle_bits: i32, rate_bits: i32, wheel_speed_bits: i32) {
    let command = i128::from(command_bits(angle_bits, rate_bits, wheel_speed_bits)) << SHIFT;
    let exact = i128::from(ANGLE_GAIN) * i128::from(angle_bits)
        + i128::from(RATE_GAIN) * i128::from(rate_bits)
        + i128::from(WHEEL_SPEED_GAIN) * i128::from(wheel_speed_bits);
    let limit = i128::from(CURRENT_LIMIT.to_bits()) << SHIFT;
    let half_unit = 1_i128 << (SHIFT - 1);

    let saturated = if exact > limit {
        limit
    } else if exact < -limit {
        -limit
    } else {
        exact
    };
    let error = command - saturated;
    assert!(error <= half_unit, "the command is too large");
    assert!(error >= -half_unit, "the command is too small");
}

/// As [`accurate`], with the exact law in 64 bits. Kani also shows that no operation overflows, so the result is the
/// exact integer; comparing 64 bits takes it a fraction of the time.
///
/// # Panics
/// If the claim does not hold for these words, or the exact law needs more than 64 bits.
pub fn accurate_in_64_bits(angle_bits: i32, rate_bits: i32, wheel_speed_bits: i32) {
    let command = i64::from(command_bits(angle_bits, rate_bits, wheel_speed_bits));
    let exact = i64::from(ANGLE_GAIN) * i64::from(angle_bits)
        + i64::from(RATE_GAIN) * i64::from(rate_bits)
        + i64::from(WHEEL_SPEED_GAIN) * i64::from(wheel_speed_bits);
    let limit = i64::from(CURRENT_LIMIT.to_bits());
    let half_unit = 1_i64 << (SHIFT - 1);

    // What is beyond the limit on this scale is at the limit; the rest fits 64 bits with room to spare.
    if exact > limit << SHIFT {
        assert!(command == limit, "the command is not at the upper limit");
    } else if exact < -limit << SHIFT {
        assert!(command == -limit, "the command is not at the lower limit");
    } else {
        let error = (command << SHIFT) - exact;
        assert!(error <= half_unit, "the command is too large");
        assert!(error >= -half_unit, "the command is too small");
    }
}
