//! Vectors scaled up by a power of two, so that a length or a ratio keeps its precision.
//!
//! Each level multiplies a vector by a constant power of two if all its components stay in range. That
//! takes comparisons and no count of leading zeros. Nothing is rounded: the direction stays the same.

/// A component below this can be doubled once more. After scaling, the largest component of a vector
/// that was large enough is at least this.
pub const SCALED_MIN: i32 = 0x2000_0000;

/// Whether |value| < limit, limit > 0.
#[inline]
pub fn is_within(value: i32, limit: i32) -> bool {
    -limit < value && value < limit
}

/// Two components times `factor` if both are below `limit`.
#[inline]
fn lift2(v: [i32; 2], limit: i32, factor: i32) -> [i32; 2] {
    if is_within(v[0], limit) && is_within(v[1], limit) {
        [v[0] * factor, v[1] * factor]
    } else {
        v
    }
}

/// Three components times `factor` if all are below `limit`.
#[inline]
fn lift3(v: [i32; 3], limit: i32, factor: i32) -> [i32; 3] {
    if is_within(v[0], limit) && is_within(v[1], limit) && is_within(v[2], limit) {
        [v[0] * factor, v[1] * factor, v[2] * factor]
    } else {
        v
    }
}

/// Four components times `factor` if all are below `limit`.
#[inline]
fn lift4(v: [i32; 4], limit: i32, factor: i32) -> [i32; 4] {
    if is_within(v[0], limit)
        && is_within(v[1], limit)
        && is_within(v[2], limit)
        && is_within(v[3], limit)
    {
        [v[0] * factor, v[1] * factor, v[2] * factor, v[3] * factor]
    } else {
        v
    }
}

/// Scales any vector other than zero until its largest component is at least 2²⁹; components
/// that are larger stay. Components within ±2³⁰ stay within ±2³⁰.
#[cfg_attr(kani, kani::requires(
    (-0x4000_0000..=0x4000_0000).contains(&v[0]) && (-0x4000_0000..=0x4000_0000).contains(&v[1])
))]
#[cfg_attr(kani, kani::ensures(|r|
    (-0x4000_0000..=0x4000_0000).contains(&r[0]) && (-0x4000_0000..=0x4000_0000).contains(&r[1])
))]
#[inline]
pub fn scaled_up2(v: [i32; 2]) -> [i32; 2] {
    // Most vectors are long, so the large factors are looked at only for those that are not.
    let long = if is_within(v[0], 0x0400_0000) && is_within(v[1], 0x0400_0000) {
        lift2(
            lift2(lift2(v, 0x4000, 0x1_0000), 0x40_0000, 0x100),
            0x0400_0000,
            0x10,
        )
    } else {
        v
    };
    lift2(lift2(long, 0x1000_0000, 4), SCALED_MIN, 2)
}

/// Scales any vector with a component of at least 2¹⁴ until its largest component is at least
/// 2²⁹; components that are larger stay. Components within ±2³⁰ stay within ±2³⁰.
#[cfg_attr(kani, kani::requires(
    (-0x4000_0000..=0x4000_0000).contains(&v[0])
        && (-0x4000_0000..=0x4000_0000).contains(&v[1])
        && (-0x4000_0000..=0x4000_0000).contains(&v[2])
))]
#[cfg_attr(kani, kani::ensures(|r|
    (-0x4000_0000..=0x4000_0000).contains(&r[0])
        && (-0x4000_0000..=0x4000_0000).contains(&r[1])
        && (-0x4000_0000..=0x4000_0000).contains(&r[2])
))]
#[inline]
pub fn scaled_up3(v: [i32; 3]) -> [i32; 3] {
    let long = lift3(lift3(v, 0x40_0000, 0x100), 0x0400_0000, 0x10);
    lift3(lift3(long, 0x1000_0000, 4), SCALED_MIN, 2)
}

/// Scales any vector other than zero until its largest component is at least 2²⁹; components
/// that are larger stay. Components within ±7·2²⁸ stay within ±7·2²⁸.
#[cfg_attr(kani, kani::requires(
    (-0x7000_0000..=0x7000_0000).contains(&v[0])
        && (-0x7000_0000..=0x7000_0000).contains(&v[1])
        && (-0x7000_0000..=0x7000_0000).contains(&v[2])
        && (-0x7000_0000..=0x7000_0000).contains(&v[3])
))]
#[cfg_attr(kani, kani::ensures(|r|
    (-0x7000_0000..=0x7000_0000).contains(&r[0])
        && (-0x7000_0000..=0x7000_0000).contains(&r[1])
        && (-0x7000_0000..=0x7000_0000).contains(&r[2])
        && (-0x7000_0000..=0x7000_0000).contains(&r[3])
))]
#[inline]
pub fn scaled_up4(v: [i32; 4]) -> [i32; 4] {
    let long = lift4(lift4(v, 0x4000, 0x1_0000), 0x40_0000, 0x100);
    let longer = lift4(lift4(long, 0x0400_0000, 0x10), 0x1000_0000, 4);
    lift4(longer, SCALED_MIN, 2)
}
