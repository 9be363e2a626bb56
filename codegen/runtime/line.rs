//! Straight lines between words of different units: counts to speeds, currents to duty.

/// result = (scale · word + offset) / 2^shift, rounded as `offset` says, within [low, high].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Slope times 2^shift, at most 2³⁰.
    pub scale: i32,
    /// Value at zero plus one half, times 2^shift; at most 2⁶¹.
    pub offset: i64,
    /// Number of fraction bits of slope and value at zero, at most 62.
    pub shift: u32,
    /// Smallest result.
    pub low: i32,
    /// Largest result, at least `low`.
    pub high: i32,
}

/// The value of the line at `word`, for any word. It is within half a unit of the line with the
/// rounded scale and offset.
#[inline]
pub fn on_line(word: i32, line: &Line) -> i32 {
    let value = (word as i64 * line.scale as i64 + line.offset) >> line.shift;
    if value < line.low as i64 {
        line.low
    } else if value > line.high as i64 {
        line.high
    } else {
        value as i32
    }
}
