//! Encoders: what a window of counts gives.

#[cfg(body_encoder)]
use generated::constants::BODY_ENCODER;
#[cfg(wheel_encoder)]
use generated::constants::WHEEL_ENCODER;
use generated::encoder::{Encoder, EncoderNumbers};

/// Counts that fill the longest window: the first one is where the encoder starts.
pub const COUNTS: usize = 17;

/// The encoders of this bench.
#[cfg(all(body_encoder, wheel_encoder))]
pub const ENCODERS: [EncoderNumbers; 2] = [BODY_ENCODER, WHEEL_ENCODER];
/// The encoders of this bench.
#[cfg(all(body_encoder, not(wheel_encoder)))]
pub const ENCODERS: [EncoderNumbers; 1] = [BODY_ENCODER];
/// The encoders of this bench.
#[cfg(not(body_encoder))]
pub const ENCODERS: [EncoderNumbers; 1] = [WHEEL_ENCODER];

/// Claim `encoder-exact`: counts that follow from turns of less than half a wrap give the sum of the turns over the
/// window, wrap included. A turn is given as a part of the largest one, in units of 2⁻¹⁵.
///
/// # Panics
/// If the claim does not hold for these counts.
pub fn the_turn_is_exact(numbers: &EncoderNumbers, start: u16, turns: [i16; COUNTS - 1]) {
    let half = numbers.wrap >> 1;
    let mut encoder = Encoder::new();
    let mut count = i32::from(start) & (numbers.wrap - 1);
    encoder.update(count as u16, numbers);
    let mut wanted = 0;
    for (index, turn) in turns.into_iter().enumerate() {
        let turn = (i32::from(turn) * half) >> 15;
        count = (count + turn) & (numbers.wrap - 1);
        encoder.update(count as u16, numbers);
        assert!(encoder.count() == count, "another count");
        if (COUNTS - 1 - index) as i32 <= numbers.window {
            wanted += turn;
        }
    }
    assert!(encoder.turned(numbers) == wanted, "another turn");
}

/// Any counts: an encoder is defined, its count below its wrap, and its turn within half a wrap a step.
///
/// # Panics
/// If one is not.
pub fn counts_are_in_range(numbers: &EncoderNumbers, counts: [u16; COUNTS]) {
    let mut encoder = Encoder::new();
    for count in counts {
        encoder.update(count, numbers);
        assert!(
            (0..numbers.wrap).contains(&encoder.count()),
            "a count beyond the wrap"
        );
    }
    let most = numbers.window * (numbers.wrap >> 1);
    assert!(
        (-most..=most).contains(&encoder.turned(numbers)),
        "a turn beyond half a wrap a step"
    );
}
