//! The body angle about the pivot axis (the sensor's z axis).

use super::arc_tangent::arc_tangent2;
use super::product::round_high;

/// Angle relative to upright, θ = atan2(−v_y, v_x) − m, as a word whose 2³¹ stand for π.
///
/// v is the upward direction in the sensor's frame and m the mounting angle, a word of the same
/// kind. Error: at most 5e-7 rad over the share of v that lies across the pivot axis.
#[inline]
pub(crate) fn pivot_angle(q: [i32; 4], mounting_angle: i32) -> i32 {
    let (w, x, y, z) = (q[0] as i64, q[1] as i64, q[2] as i64, q[3] as i64);
    // Halves of the components in Q28.
    let up_x = round_high(x * z - w * y);
    let down_y = round_high(-(w * x) - y * z);
    arc_tangent2(down_y, up_x).wrapping_sub(mounting_angle)
}
