//! Whether a measured motion is one that the linear model allows.
//!
//! A step of the model predicts by how much the wheel's own speed (body rate plus wheel speed) and the body's rate
//! change. What the measurements show beyond that is added up, and forgotten slowly: so noise
//! stays small, and a wheel that does not answer adds up. Beside each sum runs its width: how far the sum may be off
//! because the model's numbers are known only so well. The motion is allowed while each sum lies within its
//! limit and its width. A push on the body changes the rate of the body, not the wheel's own speed.
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

/// Numbers of the monitor. All products have `shift` bits more than a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLimits {
    /// A sum forgets 2^−`leak` of itself in a step; 1 to 16.
    pub leak: u32,
    /// Bits that rounding a row of products to a sum removes, 1 to 62.
    pub shift: u32,
    /// A unit of the rate in products.
    pub rate: i32,
    /// A unit of the wheel speed in products.
    pub wheel_speed: i32,
    /// Change of the wheel's own speed in a step.
    pub wheel: MotionRow,
    /// Change of the body's rate in a step.
    pub body: MotionRow,
    /// Growth of the wheel's width, for magnitudes.
    pub wheel_width: MotionRow,
    /// Growth of the body's width, for magnitudes.
    pub body_width: MotionRow,
    /// How far the wheel's sum may be off beside its width.
    pub wheel_limit: i32,
    /// How far the body's sum may be off beside its width.
    pub body_limit: i32,
}

/// What was measured and sent in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motion {
    /// Word of the angle.
    pub angle: i32,
    /// Word of the rate.
    pub rate: i32,
    /// Word of the wheel speed.
    pub wheel_speed: i32,
    /// Duty less that of zero current, counts.
    pub duty: i32,
}

/// The sums and their widths, each within ±2²⁸.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionSums {
    /// Of the wheel's own speed.
    pub wheel: i32,
    /// Its width.
    pub wheel_width: i32,
    /// Of the body's rate.
    pub body: i32,
    /// Its width.
    pub body_width: i32,
}

/// No difference so far.
pub const NO_DIFFERENCE: MotionSums = MotionSums {
    wheel: 0,
    wheel_width: 0,
    body: 0,
    body_width: 0,
};

/// Largest magnitude of a sum and of a width: 4096 rad/s.
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

/// A sum that forgets its share and takes up one row of products, within `low` and [`DIFFERENCE_MAX`].
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
