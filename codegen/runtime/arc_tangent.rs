//! The angle of a two-component vector, without a division.
//!
//! Angles are words whose 2³¹ stand for π, so that 32 bits hold exactly one turn and adding with
//! wrap-around is adding on the circle.

use super::product::{clamp, mul_high};
use super::scaling::scaled_up2;

/// 2²⁹/d for d = n/2³⁰ in [½, 1].
///
/// Seed: the quadratic of least relative error (1.0 %); Newton r ← r + r (1 − d r) squares it
/// twice: 1e-4, 1e-8. Range: [2²⁹ − 32, 2³⁰ + 32]. Error: at most 24 units of 2⁻²⁹ (4.5e-8).
#[cfg_attr(kani, kani::requires((0x2000_0000..=0x4000_0000).contains(&n)))]
#[cfg_attr(kani, kani::ensures(|r| (0x1fff_ffe0..=0x4000_0020).contains(r)))]
#[inline]
fn reciprocal_q29(n: i32) -> i32 {
    let slope = 780_903_358 - mul_high(n, 1_388_272_791);
    let seed = (1_138_817_242 - mul_high(n, slope) * 8) * 2;
    refined(n, refined(n, seed))
}

/// One Newton step of [`reciprocal_q29`].
#[inline]
fn refined(n: i32, r: i32) -> i32 {
    r + mul_high(r, (0x0800_0000 - mul_high(n, r)) * 32)
}

/// atan(t) for t in [0, 1), as a word whose 2³¹ stand for π; t in Q31.
///
/// The odd polynomial of degree 13 with the least largest error on [0, 1] (2.5e-7 rad).
/// Range: [0, 2²⁹ + 256]. Error: at most 3e-7 rad.
#[cfg_attr(kani, kani::requires(t >= 0))]
#[cfg_attr(kani, kani::ensures(|r| (-256..=0x2000_0100).contains(r)))]
#[inline]
fn arc_tangent_q31(t: i32) -> i32 {
    let t2 = mul_high(t, t) * 2;
    // The k-th coefficient in units of 2⁻³³⁻ᵏ turns, since each product halves.
    let c5 = -1_470_124_093 + mul_high(t2, 596_007_524);
    let c4 = 1_741_695_679 + mul_high(t2, c5);
    let c3 = -1_447_336_609 + mul_high(t2, c4);
    let c2 = 1_083_194_806 + mul_high(t2, c3);
    let c1 = -910_983_836 + mul_high(t2, c2);
    let c0 = 1_367_125_235 + mul_high(t2, c1);
    mul_high(t, c0)
}

/// atan2(y, x) in [−π, π) as a word whose 2³¹ stand for π; components within ±2³⁰.
///
/// The zero vector gives 0. Error: at most 4e-7 rad for vectors whose larger component is exact.
#[cfg_attr(kani, kani::requires(
    (-0x4000_0000..=0x4000_0000).contains(&x) && (-0x4000_0000..=0x4000_0000).contains(&y)
))]
#[inline]
pub(crate) fn arc_tangent2(y: i32, x: i32) -> i32 {
    let [x, y] = scaled_up2([x, y]);
    let width = if x < 0 { -x } else { x };
    let height = if y < 0 { -y } else { y };
    let steep = height > width;
    let larger = if steep { height } else { width };
    let smaller = if steep { width } else { height };
    if larger == 0 {
        return 0;
    }
    // Q30 times Q29 is a Q27 after the upper word; the ratio stays below 1.
    let ratio = mul_high(
        smaller,
        reciprocal_q29(clamp(larger, 0x2000_0000, 0x4000_0000)),
    );
    let octant = arc_tangent_q31(clamp(ratio, 0, 0x07ff_ffff) * 16);
    let quadrant = if steep { 0x4000_0000 - octant } else { octant };
    let half = if x < 0 {
        i32::MIN.wrapping_sub(quadrant)
    } else {
        quadrant
    };
    if y < 0 { 0i32.wrapping_sub(half) } else { half }
}
