//! Kani proofs of the lines and planes between words of different units; and the ranges that stand in for them and for
//! the law in the proofs of the step.

#[cfg(not(voltage_drive))]
use generated::constants::DUTY_LINE;
#[cfg(voltage_drive)]
use generated::constants::DUTY_PLANE;
#[cfg(not(body_encoder))]
use generated::constants::RATE_LINE;
use generated::constants::WHEEL_SPEED_LINE;
#[cfg(body_encoder)]
use generated::constants::{BODY_ANGLE_LINE, BODY_RATE_LINE, HOLDING_LINE};
use generated::line::{Line, on_line};
#[cfg(voltage_drive)]
use generated::plane::on_plane;
use generated::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed};

use crate::words::any_within;

/// [`lines_in_range`] shows it for the lines of this bench.
pub(crate) fn any_on_line(_word: i32, line: &Line) -> i32 {
    let value = kani::any();
    kani::assume((line.low..=line.high).contains(&value));
    value
}

/// The harness `control_total` shows it.
pub(crate) fn any_command(_angle: Angle, _rate: Rate, _speed: WheelSpeed) -> Current {
    let [word] = any_within(CURRENT_LIMIT.to_bits());
    Current::from_bits(word)
}

/// Any word on this line.
fn line_in_range(line: &Line) {
    let value = on_line(kani::any(), line);
    kani::cover!(value == line.high, "the upper end");
    assert!((line.low..=line.high).contains(&value));
}

/// Any words on the lines of this bench.
#[kani::proof]
fn lines_in_range() {
    #[cfg(body_encoder)]
    line_in_range(&BODY_ANGLE_LINE);
    #[cfg(body_encoder)]
    line_in_range(&BODY_RATE_LINE);
    #[cfg(body_encoder)]
    line_in_range(&HOLDING_LINE);
    #[cfg(not(body_encoder))]
    line_in_range(&RATE_LINE);
    line_in_range(&WHEEL_SPEED_LINE);
    #[cfg(not(voltage_drive))]
    line_in_range(&DUTY_LINE);
}

/// Any words of current and wheel speed.
#[cfg(voltage_drive)]
#[kani::proof]
fn plane_in_range() {
    let value = on_plane(kani::any(), kani::any(), &DUTY_PLANE);
    kani::cover!(value == DUTY_PLANE.high, "the upper end");
    assert!((DUTY_PLANE.low..=DUTY_PLANE.high).contains(&value));
}
