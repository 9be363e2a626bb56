//! The duty of a voltage drive: a plane over two words, current and wheel speed.

/// result = (current · word of the current + speed · word of the speed + offset) / 2^shift, rounded as `offset` says,
/// within [low, high].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Slope of the current times 2^shift, at most 2³⁰.
    pub current: i32,
    /// Slope of the wheel speed times 2^shift, at most 2³⁰.
    pub speed: i32,
    /// Value at zero plus one half, times 2^shift; at most 2⁶¹.
    pub offset: i64,
    /// Number of fraction bits of slopes and value at zero, at most 62.
    pub shift: u32,
    /// Smallest result.
    pub low: i32,
    /// Largest result, at least `low`.
    pub high: i32,
}

/// The value of the plane at these words, for any words. It is within half a unit of the plane with the rounded
/// slopes and offset.
#[inline]
pub fn on_plane(current: i32, speed: i32, plane: &Plane) -> i32 {
    let of_current = current as i64 * plane.current as i64;
    let of_speed = speed as i64 * plane.speed as i64;
    let value = (of_current + of_speed + plane.offset) >> plane.shift;
    if value < plane.low as i64 {
        plane.low
    } else if value > plane.high as i64 {
        plane.high
    } else {
        value as i32
    }
}
