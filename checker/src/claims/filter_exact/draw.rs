//! Random words, with a preference for values where two branches of a function meet.

use crate::claims::filter_exact::second::{COMPONENT_MAX, ONE, Words};
use crate::claims::random::Random;

/// Random words, more of them where the pieces of a function meet.
pub(crate) struct Draw(pub(crate) Random);

impl Draw {
    /// From a seed other than zero.
    pub(crate) fn new(seed: u64) -> Draw {
        Draw(Random::new(seed))
    }

    /// As [`Draw::within`], but sometimes one of `corners` or a neighbour of a corner.
    pub(crate) fn at_corners(&mut self, low: i128, high: i128, corners: &[i128]) -> i128 {
        if corners.is_empty() || self.0.choice(3) > 0 {
            return self.within(low, high);
        }
        let corner = corners[self.0.choice(corners.len() as u64) as usize];
        (corner + self.0.choice(3) as i128 - 1).clamp(low, high)
    }

    /// A word within [low, high]: an arbitrary one, a small one, an end of the range, a power of two or a neighbour of
    /// one.
    pub(crate) fn within(&mut self, low: i128, high: i128) -> i128 {
        let any = low + (self.0.unit() * (high - low + 1) as f64) as i128;
        let word = match self.0.choice(8) {
            0 => 1_i128 << self.0.choice(31),
            1 => -(1_i128 << self.0.choice(31)),
            2 => (1_i128 << self.0.choice(31)) + self.0.choice(3) as i128 - 1,
            3 => (1 - self.0.choice(3) as i128) - (1_i128 << self.0.choice(31)),
            4 => any >> self.0.choice(31),
            5 => [low, high, low + 1, high - 1][self.0.choice(4) as usize],
            _ => any,
        };
        word.clamp(low, high)
    }

    pub(crate) fn vector(&mut self, length: usize, limit: i128) -> Words {
        // Short vectors as well as long ones.
        let limit = if self.0.choice(3) == 0 {
            (limit >> self.0.choice(30)).max(1)
        } else {
            limit
        };
        (0..length).map(|_| self.within(-limit, limit)).collect()
    }

    /// A vector whose largest component is a power of two or a neighbour of one.
    pub(crate) fn at_power(&mut self, length: usize, most: u64) -> Words {
        let power = 1_i128 << self.0.choice(most);
        let mut v: Words = (0..length).map(|_| self.within(-power, power)).collect();
        let sign = 1 - 2 * self.0.choice(2) as i128;
        v[self.0.choice(length as u64) as usize] = sign * (power + self.0.choice(3) as i128 - 1);
        v
    }

    /// Any calibration of a sensor: bias, matrix, shift, half a unit.
    pub(crate) fn sensor_line(&mut self) -> Words {
        let mut line = self.vector(3, 1 << 28);
        line.extend(self.vector(9, 1 << 29));
        line.push(self.0.choice(17) as i128);
        line.push(self.within(0, 1 << 16));
        line
    }

    /// A vector of about this length, as every step after the first has.
    pub(crate) fn of_length(&mut self, length: usize, norm: f64) -> Words {
        let v: Vec<f64> = (0..length).map(|_| 2.0 * self.0.unit() - 1.0).collect();
        let own = v.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
        v.iter().map(|x| (x / own * norm).round() as i128).collect()
    }

    /// A quaternion: mostly near unit length, sometimes of any length.
    pub(crate) fn quaternion(&mut self) -> Words {
        if self.0.choice(4) == 0 {
            self.vector(4, COMPONENT_MAX)
        } else {
            self.of_length(4, ONE as f64)
        }
    }

    /// The results that [`unit`] may have.
    pub(crate) fn direction(&mut self) -> Words {
        if self.0.choice(4) == 0 {
            self.vector(3, 5 << 27)
        } else {
            self.of_length(3, (1 << 28) as f64)
        }
    }
}
