//! Kani proof of the induction by which the emitted loop stays beside the loop in real numbers.

use generated::control::{ANGLE_GAIN, RATE_GAIN, SHIFT, WHEEL_SPEED_GAIN};
use generated::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed};

use crate::properties::modes::{COORDINATE_MAX, HALF_WORD, MODES, difference_stays};

/// Any command within half a unit of the saturated law; the harness `control_accurate` shows it.
fn any_accurate_command(angle: Angle, rate: Rate, wheel_speed: WheelSpeed) -> Current {
    let exact = i64::from(ANGLE_GAIN) * i64::from(angle.to_bits())
        + i64::from(RATE_GAIN) * i64::from(rate.to_bits())
        + i64::from(WHEEL_SPEED_GAIN) * i64::from(wheel_speed.to_bits());
    let command: i32 = kani::any();
    let limit = CURRENT_LIMIT.to_bits();
    kani::assume((-limit..=limit).contains(&command));
    let saturated = exact.clamp(-i64::from(limit) << SHIFT, i64::from(limit) << SHIFT);
    let error = (i64::from(command) << SHIFT) - saturated;
    let half_unit = 1_i64 << (SHIFT - 1);
    kani::assume((-half_unit..=half_unit).contains(&error));
    Current::from_bits(command)
}

/// Any coordinate of each mode, any state, and any real number that its words stand for.
#[kani::proof]
#[kani::stub(generated::control::control, any_accurate_command)]
fn closed_loop_agreement() {
    let coordinate = kani::any();
    kani::assume((-COORDINATE_MAX..=COORDINATE_MAX).contains(&coordinate));
    let (states, parts): ([i32; 3], [i32; 3]) = (kani::any(), kani::any());
    for part in parts {
        kani::assume((-HALF_WORD..=HALF_WORD).contains(&part));
    }
    for mode in &MODES {
        let is_within = difference_stays(mode, coordinate, states, parts);
        kani::cover!(is_within, "the law does not saturate");
        kani::cover!(!is_within, "the law saturates");
    }
}
