//! The acceleration that the body's motion adds to gravity at an accelerometer off the pivot axis.
//!
//! At r = (x, y) the reading contains α̈ (−y, x) − α̇² (x, y). The correction adds
//! α̇² (x, y) − α̈ (−y, x), with α̈ from the rate by a differentiator with a lag of two steps.

use super::product::{clamp_wide, mul_high, round_high};

/// Constants of the correction. If all are zero, there is no correction and it costs no time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeverArm {
    /// Accelerometer units in Q16 for one unit of squared half-angle in Q32, along x and y.
    pub centripetal: [i32; 2],
    /// Accelerometer units in Q16 for one unit of the difference between the rate and the slow rate,
    /// for the lever arm along x and y.
    pub tangential: [i32; 2],
}

/// Largest correction of one component: the accelerometer's own range, beyond which the reading
/// itself would have saturated.
pub const CORRECTION_MAX: i32 = 0x2000_0000;

/// The slow rate after a step, which lags by two steps: the mean of the slow rate and the rate, to one
/// unit.
#[inline]
pub fn slow_rate(slow: i32, rate: i32) -> i32 {
    // Halved first, so that the range is plainly that of the arguments.
    (slow >> 1) + (rate >> 1)
}

/// The calibrated reading without the acceleration of the motion. `rate` and `slow` are half-angles a step in
/// Q32 within ±2²⁹, `accel` is within ±2²⁹, the result within ±2³⁰.
#[inline]
pub fn without_motion(accel: [i32; 3], rate: i32, slow: i32, arm: &LeverArm) -> [i32; 3] {
    let squared = round_high(rate as i64 * rate as i64) as i64;
    let excess = (rate - slow) as i64;
    let x = squared * arm.centripetal[0] as i64 + excess * arm.tangential[1] as i64;
    let y = squared * arm.centripetal[1] as i64 - excess * arm.tangential[0] as i64;
    [
        accel[0] + clamp_wide(x >> 16, CORRECTION_MAX),
        accel[1] + clamp_wide(y >> 16, CORRECTION_MAX),
        accel[2],
    ]
}

/// Squared length of a vector within ±2³⁰, in units of 2³² (each square rounded down).
#[inline]
pub fn length_squared(v: [i32; 3]) -> i32 {
    mul_high(v[0], v[0]) + mul_high(v[1], v[1]) + mul_high(v[2], v[2])
}
