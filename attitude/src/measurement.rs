//! When a measurement cannot be used.
//!
//! The rule, the same in f64 and in fixed point:
//! - an accelerometer or magnetometer reading with any axis at or beyond a limit of its range
//!   (counts that the sensor's part states) is not used: the true value is unknown;
//! - an accelerometer vector shorter than g/8 (after the lever-arm correction) is not used:
//!   near free fall its direction is that of bias and noise. The zero vector is a case of it;
//! - a magnetometer vector shorter than the stated field is not used, nor one whose horizontal
//!   part in the estimated frame is below [`crate::madgwick::HORIZONTAL_FIELD_MIN`] of it;
//! - without a usable accelerometer the step is gyroscope integration alone; with it and
//!   without a usable magnetometer it is the six-axis step;
//! - a gyroscope at its limit is integrated as it stands: nothing better is known.

/// Share of g below which the accelerometer's direction is not believed.
pub const GRAVITY_SHARE_MIN: f64 = 0.125;

/// Whether any axis is at or beyond the limits ±`clip` of its range.
pub fn is_saturated(raw: [i16; 3], clip: [i32; 3]) -> bool {
    raw.iter()
        .zip(clip)
        .any(|(&axis, limit)| i32::from(axis).abs() >= limit)
}

/// The limits of a 16-bit word.
pub const WORD_CLIP: [i32; 3] = [32_767; 3];
