//! Whether a measured motion is one that the linear model allows.
//!
//! A step of the model predicts by how much the wheel's own speed (body rate plus wheel speed) and the body's rate
//! change. The differences between measurement and prediction are summed, and each sum decays slowly. The sum of
//! noise therefore stays small, while the sum of a wheel that does not respond grows. Each sum has a width: how far the
//! sum can be off because the model's parameters are uncertain. The motion is allowed while the magnitude of each sum is
//! at most its limit plus its width. A push on the body changes the body's rate, not the wheel's own speed.
//!
//! Sums, widths and limits are in units of 2⁻¹⁶ rad/s.

use super::product::clamp;

/// A row of weights, each for a word of [`Motion`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionRow {
    /// For the angle.
    pub angle: i32,
    /// For the rate.
    pub rate: i32,
    /// For the wheel speed.
    pub wheel_speed: i32,
    /// For the duty.
    pub duty: i32,
}

/// Constants of the monitor. Every product has `shift` fraction bits more than a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLimits {
    /// A sum decays by 2^−`leak` of itself in each step; 1 to 16.
    pub leak: u32,
    /// Number of bits that rounding a row of products to a sum removes, 1 to 62.
    pub shift: u32,
    /// One word of the rate, in units of a product.
    pub rate: i32,
    /// One word of the wheel speed, in units of a product.
    pub wheel_speed: i32,
    /// Predicted change of the wheel's own speed in one step.
    pub wheel: MotionRow,
    /// Predicted change of the body's rate in one step.
    pub body: MotionRow,
    /// Growth of the width of the wheel's sum in one step, for the magnitudes of the motion.
    pub wheel_width: MotionRow,
    /// Growth of the width of the body's sum in one step, for the magnitudes of the motion.
    pub body_width: MotionRow,
    /// Limit of the wheel's sum, without its width.
    pub wheel_limit: i32,
    /// Limit of the body's sum, without its width.
    pub body_limit: i32,
}

/// The measurement of one step, and the duty that was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motion {
    /// Word of the angle.
    pub angle: i32,
    /// Word of the rate.
    pub rate: i32,
    /// Word of the wheel speed.
    pub wheel_speed: i32,
    /// Duty minus the duty of zero current, counts.
    pub duty: i32,
}

/// The sums and their widths, each within ±2²⁸.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionSums {
    /// Sum for the wheel's own speed.
    pub wheel: i32,
    /// Its width.
    pub wheel_width: i32,
    /// Sum for the body's rate.
    pub body: i32,
    /// Its width.
    pub body_width: i32,
}

/// Sums without any difference so far.
pub const NO_DIFFERENCE: MotionSums = MotionSums {
    wheel: 0,
    wheel_width: 0,
    body: 0,
    body_width: 0,
};

/// Largest magnitude of a sum or a width: 4096 rad/s.
pub const DIFFERENCE_MAX: i32 = 0x1000_0000;

/// The sums after a step from one motion to the next.
#[inline]
pub fn compared(
    sums: &MotionSums,
    before: &Motion,
    after: &Motion,
    limits: &MotionLimits,
) -> MotionSums {
    let rate = (after.rate as i64 - before.rate as i64) * limits.rate as i64;
    let speed = (after.wheel_speed as i64 - before.wheel_speed as i64) * limits.wheel_speed as i64;
    MotionSums {
        wheel: summed(
            sums.wheel,
            rate + speed - predicted(before, &limits.wheel),
            -DIFFERENCE_MAX,
            limits,
        ),
        wheel_width: summed(
            sums.wheel_width,
            width(before, &limits.wheel_width),
            0,
            limits,
        ),
        body: summed(
            sums.body,
            rate - predicted(before, &limits.body),
            -DIFFERENCE_MAX,
            limits,
        ),
        body_width: summed(
            sums.body_width,
            width(before, &limits.body_width),
            0,
            limits,
        ),
    }
}

/// Whether both sums lie within their limits and widths.
#[inline]
pub fn agrees(sums: &MotionSums, limits: &MotionLimits) -> bool {
    let wheel = limits.wheel_limit as i64 + sums.wheel_width as i64;
    let body = limits.body_limit as i64 + sums.body_width as i64;
    -wheel <= sums.wheel as i64
        && sums.wheel as i64 <= wheel
        && -body <= sums.body as i64
        && sums.body as i64 <= body
}

/// A row times a motion.
#[inline]
fn predicted(motion: &Motion, row: &MotionRow) -> i64 {
    motion.angle as i64 * row.angle as i64
        + motion.rate as i64 * row.rate as i64
        + motion.wheel_speed as i64 * row.wheel_speed as i64
        + motion.duty as i64 * row.duty as i64
}

/// A row times the magnitudes of a motion.
#[inline]
fn width(motion: &Motion, row: &MotionRow) -> i64 {
    magnitude(motion.angle) * row.angle as i64
        + magnitude(motion.rate) * row.rate as i64
        + magnitude(motion.wheel_speed) * row.wheel_speed as i64
        + magnitude(motion.duty) * row.duty as i64
}

/// |word|
#[inline]
fn magnitude(word: i32) -> i64 {
    if word < 0 {
        -(word as i64)
    } else {
        word as i64
    }
}

/// The sum after it has decayed and one row of products has been added, clamped to `low` and [`DIFFERENCE_MAX`].
#[inline]
fn summed(sum: i32, products: i64, low: i32, limits: &MotionLimits) -> i32 {
    let half = 1i64 << (limits.shift - 1);
    let rounded = (products + half) >> limits.shift;
    let more = if rounded < -(DIFFERENCE_MAX as i64) {
        -DIFFERENCE_MAX
    } else if rounded > DIFFERENCE_MAX as i64 {
        DIFFERENCE_MAX
    } else {
        rounded as i32
    };
    let kept = clamp(sum, -DIFFERENCE_MAX, DIFFERENCE_MAX);
    clamp(kept - (kept >> limits.leak) + more, low, DIFFERENCE_MAX)
}
