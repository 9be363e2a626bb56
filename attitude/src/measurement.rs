//! When a measurement cannot be used.
//!
//! The rule, the same in f64 and in fixed point:
//! - an accelerometer or magnetometer reading with any axis at a limit of its range (−32768 or
//!   32767 counts) is not used: the true value is unknown;
//! - an accelerometer vector shorter than g/8 (after the lever-arm correction) is not used:
//!   near free fall its direction is that of bias and noise. The zero vector is a case of it;
//! - a magnetometer vector shorter than the stated field is not used, nor one whose horizontal
//!   part in the estimated frame is below [`crate::madgwick::HORIZONTAL_FIELD_MIN`] of it;
//! - without a usable accelerometer the step is gyroscope integration alone; with it and
//!   without a usable magnetometer it is the six-axis step;
//! - a gyroscope at its limit is integrated as it stands: nothing better is known.

/// Share of g below which the accelerometer's direction is not believed.
pub const GRAVITY_SHARE_MIN: f64 = 0.125;

/// Whether any axis is at a limit of the 16-bit range.
pub fn is_saturated(raw: [i16; 3]) -> bool {
    raw.iter().any(|&axis| axis == i16::MIN || axis == i16::MAX)
}
