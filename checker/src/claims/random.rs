//! Random numbers for reproducible runs.

/// A small generator of random numbers (xorshift64*), so that a run can be repeated.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed other than zero.
    pub fn new(seed: u64) -> Random {
        Random(seed.max(1))
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A word of random length, so that small ones are as frequent as large ones.
    pub(crate) fn word(&mut self) -> i128 {
        let shift = self.next() % 32;
        let word = (self.next() >> 32) as u32 as i32;
        i128::from(word >> shift.min(31))
    }

    /// Uniform within [-1, 1).
    pub(crate) fn real(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform within [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of `0..count`.
    pub fn choice(&mut self, count: u64) -> u64 {
        self.next() % count
    }

    /// An integer within ±`limit`.
    pub(crate) fn count(&mut self, limit: f64) -> i128 {
        (self.real() * limit) as i128
    }
}
