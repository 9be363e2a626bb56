//! The loop with the emitted law beside the same loop in real numbers, mode by mode.
//!
//! The two loops differ by e, and e becomes F e + Bd w in a step: w is what the emitted command, of the rounded states,
//! differs from the sum N x of the real ones. In the coordinates of [`crate::modes`] each mode is an interval that every
//! step maps into itself. The step is linear in the coordinate and in the states' rounding, so that the ends of
//! their intervals decide for all reals between.

use generated::CURRENT_LIMIT;
use generated::control::{ANGLE_GAIN, RATE_GAIN, SHIFT, WHEEL_SPEED_GAIN};

use crate::modes::{FIRST, Mode, SECOND, THIRD};
use crate::properties::control::command_bits;

/// Largest coordinate of a mode.
pub const COORDINATE_MAX: i64 = 1 << 28;

/// Half a word of a state, in sixteenths of a word.
pub const HALF_WORD: i32 = 8;

/// The three modes.
pub const MODES: [Mode; 3] = [FIRST, SECOND, THIRD];

/// Claim `closed-loop-agreement`, one step of the induction: from any coordinate within its bound, and for any state at
/// which the law in real numbers does not saturate, the coordinate stays within its bound. `states` are
/// words, `parts` sixteenths of a word by which the real states are beside them. Returns whether the law does
/// not saturate.
///
/// # Panics
/// If the claim does not hold for these numbers.
pub fn difference_stays(mode: &Mode, coordinate: i64, states: [i32; 3], parts: [i32; 3]) -> bool {
    let gains = [ANGLE_GAIN, RATE_GAIN, WHEEL_SPEED_GAIN];
    let sum = |words: [i32; 3]| {
        i64::from(gains[0]) * i64::from(words[0])
            + i64::from(gains[1]) * i64::from(words[1])
            + i64::from(gains[2]) * i64::from(words[2])
    };
    let (of_words, of_parts) = (sum(states), sum(parts));
    // Beyond twice the limit the parts, less than a word, change nothing; and sixteenths of the rest fit 64 bits.
    let limit = i64::from(CURRENT_LIMIT.to_bits()) << SHIFT;
    if of_words.abs() > 2 * limit || ((of_words << 4) + of_parts).abs() > limit << 4 {
        return false;
    }
    let command = i64::from(command_bits(states[0], states[1], states[2]));
    let difference = (((command << SHIFT) - of_words) << 4) - of_parts;
    let next = mode.decay * coordinate.abs() + mode.rest + mode.input * difference.abs();
    assert!(
        next <= COORDINATE_MAX << 30,
        "the two loops move apart in a mode"
    );
    true
}
