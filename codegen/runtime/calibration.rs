//! Converts raw counts of a three-axis sensor to words: subtracts the bias and applies a matrix.

use super::product::mul_high;

/// Calibration of one sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorLine {
    /// Bias in 2⁻¹⁵ counts, at most 2²⁸ (8192 counts).
    pub bias: [i32; 3],
    /// Row of the x output in the matrix of scale, cross-axis sensitivity and alignment: output units
    /// per count in Q(17 + shift). The magnitudes of a row add up to at most 3·2²⁹.
    pub x: [i32; 3],
    /// Row of the y output.
    pub y: [i32; 3],
    /// Row of the z output.
    pub z: [i32; 3],
    /// Number of fraction bits that a sum of products has beyond the output, at most 16.
    pub shift: u32,
    /// Half a unit of the output, plus one for the mean error of products that are rounded down.
    pub half_unit: i32,
}

/// Largest magnitude of a calibrated component: (2¹⁵ + 2¹³)·2¹⁵ counts times 3·2²⁹/2³², rounded
/// up to a power of two.
pub const CALIBRATED_MAX: i32 = 0x2000_0000;

/// matrix · (raw − bias). Each component within ±2²⁹; its error at most ½ + 2/2^shift units.
#[inline]
pub fn calibrate(raw: [i16; 3], line: &SensorLine) -> [i32; 3] {
    let x = (raw[0] as i32) * 0x8000 - line.bias[0];
    let y = (raw[1] as i32) * 0x8000 - line.bias[1];
    let z = (raw[2] as i32) * 0x8000 - line.bias[2];
    [
        (dot(line.x, x, y, z) + line.half_unit) >> line.shift,
        (dot(line.y, x, y, z) + line.half_unit) >> line.shift,
        (dot(line.z, x, y, z) + line.half_unit) >> line.shift,
    ]
}

/// One row of the matrix times the counts (in 2⁻¹⁵), |x|, |y|, |z| ≤ 5·2²⁸.
#[cfg_attr(kani, kani::requires(
    (-0x5000_0000..=0x5000_0000).contains(&x)
        && (-0x5000_0000..=0x5000_0000).contains(&y)
        && (-0x5000_0000..=0x5000_0000).contains(&z)
        && row[0].unsigned_abs() as u64 + row[1].unsigned_abs() as u64
            + row[2].unsigned_abs() as u64 <= 0x6000_0000
))]
#[cfg_attr(kani, kani::ensures(|r| (-0x1f00_0000..=0x1f00_0000).contains(r)))]
#[inline]
pub fn dot(row: [i32; 3], x: i32, y: i32, z: i32) -> i32 {
    mul_high(row[0], x) + mul_high(row[1], y) + mul_high(row[2], z)
}

/// Whether any axis is at or beyond the limits ±`clip` of its range, where the true value is
/// unknown.
#[inline]
pub fn is_saturated(raw: [i16; 3], clip: [i32; 3]) -> bool {
    is_at_limit(raw[0], clip[0]) || is_at_limit(raw[1], clip[1]) || is_at_limit(raw[2], clip[2])
}

/// Whether one axis is at or beyond a limit of its range.
#[inline]
fn is_at_limit(axis: i16, limit: i32) -> bool {
    (axis as i32) <= -limit || (axis as i32) >= limit
}
