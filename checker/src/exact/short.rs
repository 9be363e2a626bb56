//! Numbers in units of 2⁻⁹⁶ and below 2³¹ in magnitude, for long sums that must be fast. The error of a product is less
//! than a unit; the user of this module bounds the sum of these errors. A result that does not fit is an error, never a
//! wrong number.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::exact::rational::power_of_two;

/// Bits after the point.
pub const SHORT_BITS: usize = 96;

/// A number is 2³¹ or more in magnitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge;

/// A number in units of 2⁻⁹⁶.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Short(i128);

impl Short {
    /// Zero.
    pub const ZERO: Short = Short(0);
    /// One.
    pub const ONE: Short = Short(1 << SHORT_BITS);

    /// So many units.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn of_units(units: &BigInt) -> Result<Short, TooLarge> {
        units.to_i128().ok_or(TooLarge).and_then(Short::checked)
    }

    fn checked(units: i128) -> Result<Short, TooLarge> {
        // The least i128 has no magnitude of the same type.
        if units == i128::MIN {
            Err(TooLarge)
        } else {
            Ok(Short(units))
        }
    }

    /// The number of units.
    pub fn units(self) -> i128 {
        self.0
    }

    /// Exactly what the number is.
    pub fn exactly(self) -> BigRational {
        BigRational::from(BigInt::from(self.0)) * power_of_two(-(SHORT_BITS as i32))
    }

    /// The magnitude.
    pub fn abs(self) -> Short {
        Short(self.0.abs())
    }

    /// The sum, exactly.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn plus(self, other: Short) -> Result<Short, TooLarge> {
        self.0
            .checked_add(other.0)
            .ok_or(TooLarge)
            .and_then(Short::checked)
    }

    /// The product, rounded towards zero.
    ///
    /// # Errors
    /// [`TooLarge`].
    pub fn times(self, other: Short) -> Result<Short, TooLarge> {
        let magnitude = product(self.0.unsigned_abs(), other.0.unsigned_abs())?;
        let is_negative = (self.0 < 0) != (other.0 < 0);
        Ok(Short(if is_negative { -magnitude } else { magnitude }))
    }
}

/// ⌊a b 2⁻⁹⁶⌋ for numbers up to 2¹²⁷, from products of their halves.
fn product(a: u128, b: u128) -> Result<i128, TooLarge> {
    const LOW: u128 = u64::MAX as u128;
    let (a1, a0, b1, b0) = (a >> 64, a & LOW, b >> 64, b & LOW);
    // a b = a₁b₁ 2¹²⁸ + (a₁b₀ + a₀b₁) 2⁶⁴ + a₀b₀; the middle may carry twice.
    let low = a0 * b0;
    let (middle, carried) = (a1 * b0).overflowing_add(a0 * b1);
    let (middle, carried_again) = middle.overflowing_add(low >> 64);
    let carries = (u128::from(carried) + u128::from(carried_again)) << 64;
    let high = a1 * b1 + carries + (middle >> 64);
    let rest = ((middle & LOW) << 64 | (low & LOW)) >> SHORT_BITS;
    if high < 1 << 95 {
        Ok((high << 32 | rest) as i128)
    } else {
        Err(TooLarge)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Numbers of every size.
    fn number() -> impl Strategy<Value = i128> {
        (any::<i128>(), 1_u32..128).prop_map(|(bits, shift)| bits >> shift)
    }

    proptest! {
        #[test]
        fn sums_and_products_are_those_of_whole_numbers(a in number(), b in number()) {
            let (wide_a, wide_b) = (BigInt::from(a), BigInt::from(b));
            let [Ok(x), Ok(y)] = [&wide_a, &wide_b].map(Short::of_units) else {
                return Ok(());
            };
            let magnitude = (wide_a.magnitude() * wide_b.magnitude()) >> SHORT_BITS;
            match (x.times(y), magnitude.to_i128()) {
                (Ok(found), Some(wanted)) => {
                    prop_assert_eq!(found.units(), if (a < 0) == (b < 0) { wanted } else { -wanted });
                }
                (found, wanted) => prop_assert!(found.is_err() && wanted.is_none()),
            }
            match (x.plus(y), a.checked_add(b)) {
                (Ok(found), Some(wanted)) => prop_assert_eq!(found.units(), wanted),
                (found, wanted) => prop_assert!(found.is_err() && wanted.is_none_or(|sum| sum == i128::MIN)),
            }
        }
    }
}
