//! An absolute encoder: its turn in one step and over a window of steps, in exact counts.

use super::product::clamp;

/// Constants of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EncoderNumbers {
    /// Number of counts after which the count starts again at zero: a power of two, at most 2¹⁶.
    pub wrap: i32,
    /// Number of steps in the window, 1 to 16.
    pub window: i32,
    /// Largest possible difference between the turns of two consecutive steps, counts. A larger one is a fault.
    pub jump: i32,
}

/// Largest magnitude of the turn in one step: half of the largest `wrap`.
pub const TURN_MAX: i32 = 0x8000;

/// Largest count.
pub const COUNT_MAX: i32 = 0xffff;

/// The state of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoder {
    /// Number of samples so far, at most two.
    seen: i32,
    /// The last count.
    count: i32,
    /// Whether the last count jumped further than any motion.
    has_jumped: bool,
    /// Turns of the last four steps, the youngest first.
    newest: [i32; 4],
    /// Turns of the four steps before these.
    newer: [i32; 4],
    /// Turns of the four steps before these.
    older: [i32; 4],
    /// Turns of the four steps before these.
    oldest: [i32; 4],
}

impl Encoder {
    /// Before the first count.
    pub const fn new() -> Self {
        Encoder {
            seen: 0,
            count: 0,
            has_jumped: false,
            newest: [0, 0, 0, 0],
            newer: [0, 0, 0, 0],
            older: [0, 0, 0, 0],
            oldest: [0, 0, 0, 0],
        }
    }

    /// Takes a count. The first count is the start. From the third on, a turn that differs from the one
    /// before by more than `jump` is a fault.
    pub fn update(&mut self, count: u16, numbers: &EncoderNumbers) {
        let count = clamp(count as i32, 0, numbers.wrap - 1);
        let turn = if self.seen > 0 {
            within_half(count - self.count, numbers.wrap)
        } else {
            0_i32
        };
        let difference = turn - self.newest[0];
        self.has_jumped =
            self.seen > 1 && (difference < -numbers.jump || difference > numbers.jump);
        self.seen = if self.seen > 0 { 2_i32 } else { 1_i32 };
        self.count = count;
        self.oldest = [
            self.older[3],
            self.oldest[0],
            self.oldest[1],
            self.oldest[2],
        ];
        self.older = [self.newer[3], self.older[0], self.older[1], self.older[2]];
        self.newer = [self.newest[3], self.newer[0], self.newer[1], self.newer[2]];
        self.newest = [turn, self.newest[0], self.newest[1], self.newest[2]];
    }

    /// The last count.
    pub fn count(&self) -> i32 {
        self.count
    }

    /// Whether the last count jumped further than any motion.
    pub fn has_jumped(&self) -> bool {
        self.has_jumped
    }

    /// The turn over the window in counts: the exact sum of the turns of its steps.
    pub fn turned(&self, numbers: &EncoderNumbers) -> i32 {
        let left = numbers.window;
        first(self.newest, left)
            + first(self.newer, left - 4)
            + first(self.older, left - 8)
            + first(self.oldest, left - 12)
    }
}

impl Default for Encoder {
    fn default() -> Self {
        Encoder::new()
    }
}

/// The sum of the first `count` of four turns; of all four if `count` is larger.
#[inline]
fn first(turns: [i32; 4], count: i32) -> i32 {
    let one = if count > 0 { turns[0] } else { 0_i32 };
    let two = if count > 1 { turns[1] } else { 0_i32 };
    let three = if count > 2 { turns[2] } else { 0_i32 };
    let four = if count > 3 { turns[3] } else { 0_i32 };
    one + two + three + four
}

/// The difference of two counts the shorter way round, within ±`wrap`/2; anything else is clamped to
/// that.
#[inline]
pub fn within_half(difference: i32, wrap: i32) -> i32 {
    let half = wrap >> 1;
    if difference < -half {
        clamp(difference + wrap, -half, half)
    } else if difference >= half {
        clamp(difference - wrap, -half, half)
    } else {
        difference
    }
}
