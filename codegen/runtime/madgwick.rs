//! Madgwick's filter in 32-bit words: six axes as in his report of 2010, whose equation numbers stand
//! below; the heading as in his thesis of 2014, where the magnetic field turns the estimate about the
//! vertical and does nothing else.
//!
//! Quaternion q = (q₁, q₂, q₃, q₄) = (w, x, y, z) in Q30; turns as half-angles ω T/2 in Q32;
//! directions in Q28; gradients ½Jᵀf in Q26.
//!
//! Every bound below follows from the ranges of the components alone and does not depend on the
//! length of a vector, so that no step can overflow even if a length were wrong.

use super::lever_arm::length_squared;
use super::product::{clamp, mul_high, round_high};
use super::root::{coarse_inverse_length, inverse_length};
use super::scaling::{is_within, scaled_up3, scaled_up4};

/// 1 in Q30.
pub const ONE: i32 = 0x4000_0000;

/// Largest component of the quaternion that a step leaves behind: 1 + 2⁻¹² in Q30.
pub const COMPONENT_MAX: i32 = 0x4004_0000;

/// There is no correction if all components of the half gradient are below this: 2⁻¹⁸ in Q26.
const GRADIENT_MIN_IMU: i32 = 0x100;

/// A horizontal field below 1/16 of the whole field shows no heading: its square in Q29.
const HORIZONTAL_SQUARED_MIN: i32 = 0x20_0000;

/// The direction and the size of a correction of the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Correction {
    /// The gradient, scaled up; within ±7·2²⁸.
    pub direction: [i32; 4],
    /// β T divided by the length of `direction`: the product of both is a change of q in Q62.
    pub gain: i32,
}

/// No correction: the step is gyroscope integration.
pub const NO_CORRECTION: Correction = Correction {
    direction: [0, 0, 0, 0],
    gain: 0,
};

/// Unit vector in Q28 along `v`, which is within ±2³⁰ and has a component of at least 2¹⁴.
/// Error: at most 1e-8 a component. Each component within ±5·2²⁷ for any `v` in range.
#[cfg_attr(any(), kani::requires(
    (-0x4000_0000..=0x4000_0000).contains(&v[0])
        && (-0x4000_0000..=0x4000_0000).contains(&v[1])
        && (-0x4000_0000..=0x4000_0000).contains(&v[2])
))]
#[cfg_attr(any(), kani::ensures(|r|
    (-0x2800_0000..=0x2800_0000).contains(&r[0])
        && (-0x2800_0000..=0x2800_0000).contains(&r[1])
        && (-0x2800_0000..=0x2800_0000).contains(&r[2])
))]
#[inline]
pub fn unit_q28(v: [i32; 3]) -> [i32; 3] {
    let scaled = scaled_up3(v);
    let inverse = inverse_length(length_squared(scaled)) as i64;
    // 2²⁹ √x times 2³⁰/√x is a unit vector in Q59, its upper word in Q27.
    [
        round_high(scaled[0] as i64 * inverse) * 2,
        round_high(scaled[1] as i64 * inverse) * 2,
        round_high(scaled[2] as i64 * inverse) * 2,
    ]
}

/// The upward direction in the sensor's frame, in Q28 (eq. 25). Each component within 2³⁰ + 2²⁰ whatever
/// the length of q.
#[cfg_attr(kani, kani::requires(
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[3])
))]
#[cfg_attr(kani, kani::ensures(|r|
    (-0x4010_0000..=0x4010_0000).contains(&r[0])
        && (-0x4010_0000..=0x4010_0000).contains(&r[1])
        && (-0x4010_0000..=0x4010_0000).contains(&r[2])
))]
#[inline]
pub fn up_q28(q: [i32; 4]) -> [i32; 3] {
    let (w, x, y, z) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    [
        round_high(x * z - w * y) * 2,
        round_high(w * x + y * z) * 2,
        0x1000_0000 - round_high(x * x + y * y) * 2,
    ]
}

/// Gradient of the six-axis error: ½Jᵀ(v − a) in Q26 (eq. 25, 26).
#[cfg_attr(any(), kani::requires(
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[3])
        && (-0x2800_0000..=0x2800_0000).contains(&measured_up[0])
        && (-0x2800_0000..=0x2800_0000).contains(&measured_up[1])
        && (-0x2800_0000..=0x2800_0000).contains(&measured_up[2])
        && (0..=0x1fff_ffff).contains(&beta)
))]
#[cfg_attr(any(), kani::ensures(|r|
    (-0x7000_0000..=0x7000_0000).contains(&r.direction[0])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[1])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[2])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[3])
        && (0..=0x0980_0001).contains(&r.gain)
))]
#[inline]
pub fn correction_imu(q: [i32; 4], measured_up: [i32; 3], beta: i32) -> Correction {
    let up = up_q28(q);
    let w1 = (up[0] - measured_up[0]) as i64;
    let w2 = (up[1] - measured_up[1]) as i64;
    let w3 = (up[2] - measured_up[2]) as i64;
    let (q1, q2, q3, q4) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    let gradient = [
        round_high(q2 * w2 - q3 * w1),
        round_high(q4 * w1 + q1 * w2 - 2 * (q2 * w3)),
        round_high(q4 * w2 - q1 * w1 - 2 * (q3 * w3)),
        round_high(q2 * w1 + q3 * w2),
    ];
    scaled_correction(gradient, GRADIENT_MIN_IMU, beta)
}

/// Half of the turn about the vertical, in Q32, that brings the estimate towards magnetic north: within
/// ±`limit`; zero where the field is nearly vertical in the estimated frame.
///
/// The measured field, of length 1, has the components n towards the estimated north and w towards the west.
/// w is the sine of the heading error times the horizontal share of the field. A turn by −w therefore reduces
/// the error and does not overshoot. If the error exceeds a quarter turn, the turn is the whole limit.
#[cfg_attr(any(), kani::requires(
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[3])
        && (-0x2800_0000..=0x2800_0000).contains(&field[0])
        && (-0x2800_0000..=0x2800_0000).contains(&field[1])
        && (-0x2800_0000..=0x2800_0000).contains(&field[2])
        && (0..=0x03ff_ffff).contains(&limit)
))]
#[cfg_attr(any(), kani::ensures(|r| (-0x03ff_ffff..=0x03ff_ffff).contains(r)))]
#[inline]
pub fn heading_turn(q: [i32; 4], field: [i32; 3], limit: i32) -> i32 {
    let zz = mul_high(q[3], q[3]);
    let north = [
        0x1000_0000 - (mul_high(q[2], q[2]) + zz) * 2,
        (mul_high(q[1], q[2]) - mul_high(q[0], q[3])) * 2,
        (mul_high(q[0], q[2]) + mul_high(q[1], q[3])) * 2,
    ];
    let west = [
        (mul_high(q[1], q[2]) + mul_high(q[0], q[3])) * 2,
        0x1000_0000 - (mul_high(q[1], q[1]) + zz) * 2,
        (mul_high(q[2], q[3]) - mul_high(q[0], q[1])) * 2,
    ];
    let field_north = component_q30(north, field);
    let field_west = component_q30(west, field);
    let squared = (mul_high(field_north, field_north) + mul_high(field_west, field_west)) * 2;
    if squared < HORIZONTAL_SQUARED_MIN {
        0
    } else if field_north > 0 {
        // Half of w from Q30 to Q32 is twice its word.
        clamp(
            clamp(-field_west, -0x0200_0000, 0x0200_0000) * 2,
            -limit,
            limit,
        )
    } else if field_west > 0 {
        -limit
    } else {
        limit
    }
}

/// q turned about the vertical by twice `half_angle` (Q32, within ±2²⁶): the pivot's angle stays as it is.
#[cfg_attr(any(), kani::requires(
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[3])
        && (-0x03ff_ffff..=0x03ff_ffff).contains(&half_angle)
))]
#[cfg_attr(any(), kani::ensures(|r|
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[3])
))]
#[inline]
pub fn turned_about_up(q: [i32; 4], half_angle: i32) -> [i32; 4] {
    let up = up_q28(q);
    // From Q60 to Q64, whose upper word is the half-angle about each of the sensor's axes.
    let about = (half_angle as i64) * 16;
    let turn = [
        round_high(about * up[0] as i64),
        round_high(about * up[1] as i64),
        round_high(about * up[2] as i64),
    ];
    turned(q, turn, &NO_CORRECTION)
}

/// Scalar product of two directions in Q28, as Q30 within ±1.
#[cfg_attr(kani, kani::requires(
    (-0x4020_0000..=0x4020_0000).contains(&axis[0])
        && (-0x4020_0000..=0x4020_0000).contains(&axis[1])
        && (-0x4020_0000..=0x4020_0000).contains(&axis[2])
        && (-0x2800_0000..=0x2800_0000).contains(&v[0])
        && (-0x2800_0000..=0x2800_0000).contains(&v[1])
        && (-0x2800_0000..=0x2800_0000).contains(&v[2])
))]
#[cfg_attr(kani, kani::ensures(|r| (-0x4000_0000..=0x4000_0000).contains(r)))]
#[inline]
pub fn component_q30(axis: [i32; 3], v: [i32; 3]) -> i32 {
    let sum = mul_high(axis[0], v[0]) + mul_high(axis[1], v[1]) + mul_high(axis[2], v[2]);
    clamp(sum, -0x100_0000, 0x100_0000) * 64
}

/// The normalised gradient times β T (eq. 43); no correction if all components are below `min`.
#[cfg_attr(kani, kani::requires(
    (-0x7000_0000..=0x7000_0000).contains(&gradient[0])
        && (-0x7000_0000..=0x7000_0000).contains(&gradient[1])
        && (-0x7000_0000..=0x7000_0000).contains(&gradient[2])
        && (-0x7000_0000..=0x7000_0000).contains(&gradient[3])
        && min >= 1
        && (0..=0x1fff_ffff).contains(&beta)
))]
#[cfg_attr(kani, kani::ensures(|r|
    (-0x7000_0000..=0x7000_0000).contains(&r.direction[0])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[1])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[2])
        && (-0x7000_0000..=0x7000_0000).contains(&r.direction[3])
        && (0..=0x0980_0001).contains(&r.gain)
))]
#[inline]
pub fn scaled_correction(gradient: [i32; 4], min: i32, beta: i32) -> Correction {
    if is_within(gradient[0], min)
        && is_within(gradient[1], min)
        && is_within(gradient[2], min)
        && is_within(gradient[3], min)
    {
        return NO_CORRECTION;
    }
    let direction = scaled_up4(gradient);
    // Quarters, so that the sum fits whatever the components.
    let squared = (mul_high(direction[0], direction[0]) >> 2)
        + (mul_high(direction[1], direction[1]) >> 2)
        + (mul_high(direction[2], direction[2]) >> 2)
        + (mul_high(direction[3], direction[3]) >> 2);
    let inverse = coarse_inverse_length(clamp(squared, 0, 0x0fff_ffff) * 4);
    Correction {
        direction,
        gain: mul_high(inverse, beta),
    }
}

/// q + ½ q ⊗ ω T − β T ∇/‖∇‖, normalised (eq. 12, 42 to 44).
///
/// `half_angle` is within ±2²⁹. The change is summed in Q62 and rounded once, so that its error
/// is half a unit of q and has no preferred sign.
#[cfg_attr(any(), kani::requires(
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&q[3])
        && (-0x2000_0000..=0x2000_0000).contains(&half_angle[0])
        && (-0x2000_0000..=0x2000_0000).contains(&half_angle[1])
        && (-0x2000_0000..=0x2000_0000).contains(&half_angle[2])
        && (-0x7000_0000..=0x7000_0000).contains(&correction.direction[0])
        && (-0x7000_0000..=0x7000_0000).contains(&correction.direction[1])
        && (-0x7000_0000..=0x7000_0000).contains(&correction.direction[2])
        && (-0x7000_0000..=0x7000_0000).contains(&correction.direction[3])
        && (0..=0x0980_0001).contains(&correction.gain)
))]
#[cfg_attr(any(), kani::ensures(|r|
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[3])
))]
#[inline]
pub fn turned(q: [i32; 4], half_angle: [i32; 3], correction: &Correction) -> [i32; 4] {
    let (w, x, y, z) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    let (a, b, c) = (
        half_angle[0] as i64,
        half_angle[1] as i64,
        half_angle[2] as i64,
    );
    let gain = correction.gain as i64;
    normalised([
        q[0] + round_high(-(x * a) - y * b - z * c - correction.direction[0] as i64 * gain),
        q[1] + round_high(w * a + y * c - z * b - correction.direction[1] as i64 * gain),
        q[2] + round_high(w * b + z * a - x * c - correction.direction[2] as i64 * gain),
        q[3] + round_high(w * c + x * b - y * a - correction.direction[3] as i64 * gain),
    ])
}

/// q/‖q‖ for a nearly unit q: with ‖q‖² = 1 + ε, q (1 − ε/2 + 3ε²/8).
///
/// A step leaves |ε| ≤ 0.06; the length is then 1 to within 5|ε|³/16 + 2⁻²⁵ < 1e-4. Components are
/// clamped to [`COMPONENT_MAX`], which changes only quaternions far from unit length.
#[cfg_attr(any(), kani::requires(
    (-0x6000_0000..=0x6000_0000).contains(&q[0])
        && (-0x6000_0000..=0x6000_0000).contains(&q[1])
        && (-0x6000_0000..=0x6000_0000).contains(&q[2])
        && (-0x6000_0000..=0x6000_0000).contains(&q[3])
))]
#[cfg_attr(any(), kani::ensures(|r|
    (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[0])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[1])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[2])
        && (-COMPONENT_MAX..=COMPONENT_MAX).contains(&r[3])
))]
#[inline]
pub fn normalised(q: [i32; 4]) -> [i32; 4] {
    let squared = (mul_high(q[0], q[0]) >> 1)
        + (mul_high(q[1], q[1]) >> 1)
        + (mul_high(q[2], q[2]) >> 1)
        + (mul_high(q[3], q[3]) >> 1);
    // ε in Q27, at most 1/8; then ε/2 in Q32 and ε² in Q30.
    let excess = clamp(squared - 0x0800_0000, -0x0100_0000, 0x0100_0000);
    let half = excess * 16;
    let square = mul_high(half, half);
    let change = (square + (square >> 1) - half) as i64;
    [
        clamp(
            q[0] + round_high(q[0] as i64 * change),
            -COMPONENT_MAX,
            COMPONENT_MAX,
        ),
        clamp(
            q[1] + round_high(q[1] as i64 * change),
            -COMPONENT_MAX,
            COMPONENT_MAX,
        ),
        clamp(
            q[2] + round_high(q[2] as i64 * change),
            -COMPONENT_MAX,
            COMPONENT_MAX,
        ),
        clamp(
            q[3] + round_high(q[3] as i64 * change),
            -COMPONENT_MAX,
            COMPONENT_MAX,
        ),
    ]
}

/// The shortest turn from the earth frame that agrees with `measured_up` (a unit vector in Q28):
/// (1 + v_z, v_y, −v_x, 0) normalised, or half a turn about x where it points straight down.
#[inline]
pub fn aligned(measured_up: [i32; 3]) -> [i32; 4] {
    let turn = [
        0x1000_0000 + measured_up[2],
        measured_up[1],
        -measured_up[0],
    ];
    if is_within(turn[0], 0x4_0000) && is_within(turn[1], 0x4_0000) && is_within(turn[2], 0x4_0000)
    {
        return [0, ONE, 0, 0];
    }
    let unit = unit_q28(turn);
    [
        clamp(unit[0] * 2, -0x2000_0000, 0x2000_0000) * 2,
        clamp(unit[1] * 2, -0x2000_0000, 0x2000_0000) * 2,
        clamp(unit[2] * 2, -0x2000_0000, 0x2000_0000) * 2,
        0,
    ]
}
