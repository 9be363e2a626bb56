//! Kani proof of the encoders, for any counts.

use crate::properties::encoder::{COUNTS, ENCODERS, counts_are_in_range};

/// Any counts from the first one on. What a step reads of an encoder is its last count and its last turn, which two counts
/// set to any pair that occurs; so the third of them is a step from every state.
#[kani::proof]
fn encoder_in_range() {
    let counts: [u16; COUNTS] = kani::any();
    kani::cover!(counts[0] == 0 && counts[1] == u16::MAX, "past the wrap");
    for numbers in &ENCODERS {
        counts_are_in_range(numbers, counts);
    }
}
