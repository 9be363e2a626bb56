//! Inverse square root by Newton's method from a polynomial seed.

use super::product::{clamp, mul_high};

/// 2³⁰/√x for x = n/2²⁸ in [1, 4), n in [2²⁸, 2³⁰).
///
/// Two Newton steps from the seed reduce its relative error of 0.32 % to 1.5e-5 and to 3.5e-10; the
/// rest of the error is rounding. Error: at most 8 units of 2⁻³⁰ (7.5e-9), and the result lies in
/// [2²⁹, 2³⁰]; both were found by trying every n. The contract states the wider range that follows
/// from the ranges of the parts; the steps above rely on that range alone.
#[cfg_attr(kani, kani::requires((0x1000_0000..0x4000_0000).contains(&n)))]
#[cfg_attr(kani, kani::ensures(|r| (0..=0x4c00_0000).contains(r)))]
#[inline]
pub fn inverse_root_q30(n: i32) -> i32 {
    refined(n * 2, refined(n * 2, seed(n)))
}

/// As [`inverse_root_q30`] with one Newton step: relative error at most 2e-5.
#[cfg_attr(kani, kani::requires((0x1000_0000..0x4000_0000).contains(&n)))]
#[cfg_attr(kani, kani::ensures(|r| (0..=0x4c00_0000).contains(r)))]
#[inline]
pub fn coarse_inverse_root_q30(n: i32) -> i32 {
    refined(n * 2, seed(n))
}

/// The quadratic of least relative error on each octave, coefficients in Q30, Q30 and Q33.
#[cfg_attr(kani, kani::requires((0x1000_0000..0x4000_0000).contains(&n)))]
#[cfg_attr(kani, kani::ensures(|r| (0x1200_0000..=0x4980_0000).contains(r)))]
#[inline]
pub fn seed(n: i32) -> i32 {
    let x = n * 2;
    if n < 0x2000_0000 {
        1_696_124_550 - mul_high(x, 784_383_764 - mul_high(x, 1_268_626_640)) * 8
    } else {
        1_199_341_171 - mul_high(x, 277_321_538 - mul_high(x, 224_263_625)) * 8
    }
}

/// One Newton step: y ← y + y (1 − x y²)/2 takes a relative error ε to 3ε²/2; x in Q29.
///
/// 1 − x y² is at most 0.7 %. It is clamped to 1/32, so that the range of the result follows from the
/// range of y alone.
#[cfg_attr(kani, kani::requires(x >= 0x2000_0000 && (0..=0x4c00_0000).contains(&y)))]
#[cfg_attr(kani, kani::ensures(|r| 0 <= *r && *r - y <= y >> 6))]
#[inline]
pub fn refined(x: i32, y: i32) -> i32 {
    // y in Q30, y² in Q30, x in Q29: their product in Q27.
    let share = mul_high(x, mul_high(y, y) * 4);
    let rest = clamp(0x0800_0000 - share, -0x40_0000, 0x40_0000);
    y + mul_high(y, rest * 16)
}

/// 2³⁰/√x for x = n/2²⁶ in [1, 16): the inverse length of a scaled vector.
///
/// `n` is clamped to [2²⁶, 2³⁰), so that the function is defined for every n. Error: at most 8 units.
#[cfg_attr(kani, kani::ensures(|r| (0..=0x4c00_0000).contains(r)))]
#[inline]
pub fn inverse_length(n: i32) -> i32 {
    let n = clamp(n, 0x0400_0000, 0x3fff_ffff);
    if n < 0x1000_0000 {
        inverse_root_q30(n * 4)
    } else {
        inverse_root_q30(n) >> 1
    }
}

/// As [`inverse_length`] to a relative error of 2e-5.
#[cfg_attr(kani, kani::ensures(|r| (0..=0x4c00_0000).contains(r)))]
#[inline]
pub fn coarse_inverse_length(n: i32) -> i32 {
    let n = clamp(n, 0x0400_0000, 0x3fff_ffff);
    if n < 0x1000_0000 {
        coarse_inverse_root_q30(n * 4)
    } else {
        coarse_inverse_root_q30(n) >> 1
    }
}
