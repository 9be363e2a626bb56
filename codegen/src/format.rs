//! Q-formats of 32-bit words, chosen from stated ranges.

use num_bigint::BigInt;
use num_rational::BigRational;

use crate::exact::power_of_two;

/// A signed 32-bit fixed-point format: the value is the word divided by 2^`fraction_bits`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// Bits after the binary point, 0 to 32.
    pub fraction_bits: u32,
}

impl Format {
    /// The finest format whose largest value is at least `range`; `None` if not even integers
    /// reach it.
    ///
    /// The crate `fixed` has 32 fraction bits at most.
    pub fn for_range(range: &BigRational) -> Option<Self> {
        let largest_word = BigRational::from(BigInt::from(i32::MAX));
        (0..=32)
            .rev()
            .map(|fraction_bits| Self { fraction_bits })
            .find(|format| range * format.units_per_one() <= largest_word)
    }

    /// Name of the type in `fixed::types`: `I3F29` for instance.
    pub fn type_name(self) -> String {
        format!("I{}F{}", 32 - self.fraction_bits, self.fraction_bits)
    }

    /// 2^`fraction_bits`.
    pub fn units_per_one(self) -> BigRational {
        BigRational::from(BigInt::from(1) << self.fraction_bits)
    }

    /// The value of one unit in the last place.
    pub fn unit(self) -> BigRational {
        power_of_two(-(self.fraction_bits as i32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::ShortestDecimal;

    #[test]
    fn finest_format_that_holds_the_range() {
        let cases = [
            (core::f64::consts::PI, Some(29)),
            (34.906585, Some(25)),
            (700.0, Some(21)),
            (2.2, Some(29)),
            // Two is one more than the largest I2F30, which ends one unit below.
            (2.0, Some(29)),
            (1.999999999, Some(30)),
            (1e-9, Some(32)),
            (2147483647.0, Some(0)),
            (2147483648.0, None),
        ];
        for (range, fraction_bits) in cases {
            let format = Format::for_range(&ShortestDecimal::new(range).value);
            assert_eq!(format.map(|f| f.fraction_bits), fraction_bits, "{range}");
        }
    }
}
