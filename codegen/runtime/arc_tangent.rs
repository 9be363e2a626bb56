//! The angle of a two-component vector, without a division.
//!
//! Angles are radians in Q28: ±2π fits 32 bits, and so does the difference of two angles within ±π.

use super::product::{clamp, mul_high};
use super::scaling::scaled_up2;

/// π in Q28 radians.
pub const PI_Q28: i32 = 843_314_857;

/// π/2 in Q28 radians.
pub const HALF_PI_Q28: i32 = 421_657_428;

/// π/4 in Q28 radians.
pub const QUARTER_PI_Q28: i32 = 210_828_714;

/// 2π in Q28 radians.
pub const TWO_PI_Q28: i32 = 1_686_629_713;

// Coefficients of t, t³, … of the arc tangent.
const C0: i32 = 1_073_737_649;
const C1: i32 = -715_485_031;
const C2: i32 = 850_739_211;
const C3: i32 = -1_136_735_515;
const C4: i32 = 1_367_924_588;
const C5: i32 = -1_154_632_763;
const C6: i32 = 468_103_215;

/// 2²⁹/d for d = n/2³⁰ in [½, 1].
///
/// Seed: the quadratic of least relative error (1.0 %); Newton squares it twice: 1e-4, 1e-8.
/// Error: at most 24 units of 2⁻²⁹ (4.5e-8). The contract states the range that follows from the
/// ranges of the parts.
#[cfg_attr(any(), kani::requires((0x2000_0000..=0x4000_0000).contains(&n)))]
#[cfg_attr(any(), kani::ensures(|r| (-0x0c00_0000..=0x6000_0000).contains(r)))]
#[inline]
pub fn reciprocal_q29(n: i32) -> i32 {
    let slope = 780_903_358 - mul_high(n, 1_388_272_791);
    let seed = (1_138_817_242 - mul_high(n, slope) * 8) * 2;
    refined(n, refined(n, seed))
}

/// One Newton step r ← r + r (1 − d r). 1 − d r is at most 1.1 %. It is clamped to 1/16, so that the
/// range of the result follows from the range of r alone.
#[cfg_attr(kani, kani::requires(
    (0x2000_0000..=0x4000_0000).contains(&n) && (-0x0c00_0000..=0x5a00_0000).contains(&r)
))]
#[inline]
pub fn refined(n: i32, r: i32) -> i32 {
    let rest = clamp(0x0800_0000 - mul_high(n, r), -0x80_0000, 0x80_0000);
    r + mul_high(r, rest * 32)
}

/// atan(t) in Q28 radians for t in [0, 1), t in Q31.
///
/// The odd polynomial of degree 13 with the least largest error on [0, 1] (2.5e-7 rad).
/// Range: [0, π/4 + 1e-6]. Error: at most 3e-7 rad.
#[cfg_attr(any(), kani::requires(t >= 0))]
#[cfg_attr(any(), kani::ensures(|r| (0..=QUARTER_PI_Q28 + 256).contains(r)))]
#[inline]
pub fn arc_tangent_q31(t: i32) -> i32 {
    let t2 = mul_high(t, t) * 2;
    // The k-th coefficient in Q(30 + k), since each product halves.
    let c5 = C5 + mul_high(t2, C6);
    let c4 = C4 + mul_high(t2, c5);
    let c3 = C3 + mul_high(t2, c4);
    let c2 = C2 + mul_high(t2, c3);
    let c1 = C1 + mul_high(t2, c2);
    let c0 = C0 + mul_high(t2, c1);
    (mul_high(t, c0) + 1) >> 1
}

/// atan2(y, x) in Q28 radians within ±π; components within ±2³⁰.
///
/// The zero vector gives 0. Error: at most 4e-7 rad.
#[cfg_attr(kani, kani::requires(
    (-0x4000_0000..=0x4000_0000).contains(&x) && (-0x4000_0000..=0x4000_0000).contains(&y)
))]
#[cfg_attr(kani, kani::ensures(|r| (-PI_Q28..=PI_Q28).contains(r)))]
#[inline]
pub fn arc_tangent2(y: i32, x: i32) -> i32 {
    let scaled = scaled_up2([x, y]);
    let width = magnitude(scaled[0]);
    let height = magnitude(scaled[1]);
    let is_steep = height > width;
    let larger = if is_steep { height } else { width };
    let smaller = if is_steep { width } else { height };
    // Zero is clamped up like any other; its ratio is then zero.
    let inverse = reciprocal_q29(clamp(larger, 0x2000_0000, 0x4000_0000));
    // Q30 times Q29 is a Q27 after the upper word; the ratio stays below 1.
    let ratio = clamp(mul_high(smaller, inverse), 0, 0x07ff_ffff);
    let octant = arc_tangent_q31(ratio * 16);
    let quadrant = if is_steep {
        HALF_PI_Q28 - octant
    } else {
        octant
    };
    let half = if scaled[0] < 0 {
        PI_Q28 - quadrant
    } else {
        quadrant
    };
    if scaled[1] < 0 { -half } else { half }
}

/// |value| for value within ±2³⁰.
#[inline]
fn magnitude(value: i32) -> i32 {
    if value < 0 { -value } else { value }
}
