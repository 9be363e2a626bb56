//! The body angle about the pivot axis (the sensor's z axis).

use super::arc_tangent::{PI_Q28, TWO_PI_Q28, arc_tangent2};
use super::product::round_high;

/// Angle relative to upright in Q28 radians within ±π: θ = atan2(−v_y, v_x) − m.
///
/// v is the upward direction in the sensor's frame and m the mounting angle in Q28, within ±π.
/// Error: at most 5e-7 rad, divided by the length of the part of v perpendicular to the pivot axis.
#[inline]
pub fn pivot_angle(q: [i32; 4], mounting_angle: i32) -> i32 {
    let (w, x, y, z) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    // Halves of the components in Q28.
    let up_x = round_high(x * z - w * y);
    let down_y = round_high(-(w * x) - y * z);
    wrapped(arc_tangent2(down_y, up_x) - mounting_angle)
}

/// The equivalent angle within ±π of an angle within ±2π (Q28 radians).
#[cfg_attr(kani, kani::requires((-2 * PI_Q28..=2 * PI_Q28).contains(&angle)))]
#[cfg_attr(kani, kani::ensures(|r| (-PI_Q28 - 1..=PI_Q28 + 1).contains(r)))]
#[inline]
pub fn wrapped(angle: i32) -> i32 {
    if angle > PI_Q28 {
        angle - TWO_PI_Q28
    } else if angle < -PI_Q28 {
        angle + TWO_PI_Q28
    } else {
        angle
    }
}
