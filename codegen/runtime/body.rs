//! The body's angle and rate, from the counts of the encoder on its pivot.

use super::constants::{BODY_ANGLE_LINE, BODY_ENCODER, BODY_RATE_LINE, BODY_ZERO};
use super::control::{Angle, Rate};
use super::encoder::within_half;
use super::line::on_line;
use super::product::clamp;

/// The body's angle from upright, from the count of its encoder, the shorter way round.
pub fn body_angle(count: i32) -> Angle {
    let count = clamp(count, 0, BODY_ENCODER.wrap - 1);
    let turned = within_half(count - BODY_ZERO, BODY_ENCODER.wrap);
    Angle::from_bits(on_line(turned, &BODY_ANGLE_LINE))
}

/// The body's rate, from the counts that its encoder turned over the window, clamped to the stated range. It is the
/// rate of half a window ago.
pub fn body_rate(turned: i32) -> Rate {
    Rate::from_bits(on_line(turned, &BODY_RATE_LINE))
}
