//! Products and clamps of raw words.
//!
//! A word "Qn" stands for its value times 2ⁿ. A Qa times a Qb is a Q(a + b) in 64 bits; its upper
//! word is a Q(a + b − 32), one instruction on a 32-bit core that has a long multiplication. Every
//! format of the filter is chosen so that the upper word is the result, without a shift.

/// Upper word of a product: ⌊a b/2³²⌋. Error within [−1, 0] units; any arguments.
#[cfg_attr(kani, kani::ensures(|r| (-0x4000_0000..=0x4000_0000).contains(r)))]
#[inline]
pub fn mul_high(a: i32, b: i32) -> i32 {
    ((a as i64 * b as i64) >> 32) as i32
}

/// Upper word of a sum of products, rounded: ⌊s/2³² + ½⌋. Error at most half a unit;
/// |s| ≤ 2⁶³ − 2³².
#[cfg_attr(kani, kani::requires(
    (-0x7fff_ffff_0000_0000..=0x7fff_ffff_0000_0000).contains(&sum)
))]
#[cfg_attr(kani, kani::ensures(|r| {
    let rest = ((*r as i64) << 32).wrapping_sub(sum);
    (-0x8000_0000..=0x8000_0000).contains(&rest)
}))]
#[inline]
pub fn round_high(sum: i64) -> i32 {
    (sum >> 32) as i32 + ((sum >> 31) & 1) as i32
}

/// The nearest value within [low, high], low ≤ high.
#[cfg_attr(kani, kani::requires(low <= high))]
#[cfg_attr(kani, kani::ensures(|r| low <= *r && *r <= high))]
#[inline]
pub fn clamp(value: i32, low: i32, high: i32) -> i32 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// The nearest value within ±limit, limit ≥ 0.
#[cfg_attr(kani, kani::requires(limit >= 0))]
#[cfg_attr(kani, kani::ensures(|r| -limit <= *r && *r <= limit))]
#[inline]
pub fn clamp_wide(value: i64, limit: i32) -> i32 {
    if value < -(limit as i64) {
        -limit
    } else if value > limit as i64 {
        limit
    } else {
        value as i32
    }
}
