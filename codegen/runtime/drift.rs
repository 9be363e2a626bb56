//! The gyroscope's drift, by Madgwick's estimate (report of 2010, equations 47 to 49).
//!
//! The correction ∇/‖∇‖ of a step, as a rate in the sensor's frame, is ω_ε = 2 vec(q* ⊗ ∇/‖∇‖). It has
//! the direction of the excess of the measured rate. Its integral over time, times ζ, is the drift b,
//! which is subtracted from the measured rate. Gyroscope and accelerometer alone do not show a drift
//! about the vertical: a turn about the vertical leaves the error as it is, so that vec(q* ⊗ ∇) is
//! perpendicular to the vertical.
//!
//! b is stored as a half-angle per step, with `shift` fraction bits more than a turn (Q32).

use super::calibration::CALIBRATED_MAX;
use super::madgwick::Correction;
use super::product::{clamp, clamp_wide, mul_high, round_high};

/// How fast the drift estimate moves, and its largest magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriftGain {
    /// T divided by the time constant, times 2^(28 + `shift`).
    pub gain: i32,
    /// Number of fraction bits that the drift has beyond a half-angle in Q32, at most 14.
    pub shift: u32,
    /// Largest drift, at most 2³⁰.
    pub limit: i32,
}

/// Largest drift that any module estimates.
pub const DRIFT_MAX: i32 = 0x4000_0000;

/// The turn without the drift, each component within ±2²⁹.
#[inline]
pub fn without_drift(turn: [i32; 3], drift: [i32; 3], gain: &DriftGain) -> [i32; 3] {
    [
        clamp(
            turn[0] - (drift[0] >> gain.shift),
            -CALIBRATED_MAX,
            CALIBRATED_MAX,
        ),
        clamp(
            turn[1] - (drift[1] >> gain.shift),
            -CALIBRATED_MAX,
            CALIBRATED_MAX,
        ),
        clamp(
            turn[2] - (drift[2] >> gain.shift),
            -CALIBRATED_MAX,
            CALIBRATED_MAX,
        ),
    ]
}

/// β T vec(q* ⊗ ∇/‖∇‖) in Q27: the error of the rate that the correction shows. Zero without a
/// correction.
#[inline]
pub fn rate_error(q: [i32; 4], correction: &Correction) -> [i32; 3] {
    let (w, x, y, z) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    let d = correction.direction;
    // Halved, so that the sums fit whatever the direction.
    let (d1, d2) = ((d[0] >> 1) as i64, (d[1] >> 1) as i64);
    let (d3, d4) = ((d[2] >> 1) as i64, (d[3] >> 1) as i64);
    [
        mul_high(
            round_high(w * d2 - x * d1 - y * d4 + z * d3),
            correction.gain,
        ),
        mul_high(
            round_high(w * d3 - y * d1 - z * d2 + x * d4),
            correction.gain,
        ),
        mul_high(
            round_high(w * d4 - z * d1 - x * d3 + y * d2),
            correction.gain,
        ),
    ]
}

/// The drift estimate after a step with this error of the rate, clamped to the limit.
#[inline]
pub fn tracked(drift: i32, error: i32, gain: &DriftGain) -> i32 {
    clamp_wide(
        drift as i64 + ((error as i64 * gain.gain as i64) >> 23),
        gain.limit,
    )
}
