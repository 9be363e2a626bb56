//! The rule for measurements that cannot be used.
//!
//! The rule is the same in f64 and in fixed point:
//! - An accelerometer or magnetometer reading with any axis at or beyond a limit of its range
//!   (counts that the sensor's part states) is not used, because the true value is unknown.
//! - An accelerometer vector shorter than g/8 (after the lever-arm correction) is not used:
//!   near free fall, bias and noise determine its direction. This excludes the zero vector, too.
//! - A magnetometer vector shorter than the stated field is not used, nor one whose horizontal
//!   part in the estimated frame is below [`crate::madgwick::HORIZONTAL_FIELD_MIN`] of it.
//! - Without a usable accelerometer reading, the step integrates the gyroscope only. Without a usable
//!   magnetometer reading, the heading is left to the gyroscope.
//! - A gyroscope reading at its limit is integrated unchanged, since nothing better is known.

/// Share of g below which the direction of the accelerometer's reading is not used.
pub const GRAVITY_SHARE_MIN: f64 = 0.125;

/// Whether any axis is at or beyond the limits ±`clip` of its range.
pub fn is_saturated(raw: [i16; 3], clip: [i32; 3]) -> bool {
    raw.iter()
        .zip(clip)
        .any(|(&axis, limit)| i32::from(axis).abs() >= limit)
}

/// The limits of a 16-bit word.
pub const WORD_CLIP: [i32; 3] = [32_767; 3];
