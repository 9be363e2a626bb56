//! Numbers in units of 2⁻¹⁴⁴, for sums of many terms. An operation is off by at most a unit or two; who uses
//! them says what that adds up to.

use num_bigint::BigInt;
use num_rational::BigRational;

use crate::exact::rational::power_of_two;

/// Bits after the point.
pub const BITS: usize = 144;

/// A number in units of 2⁻¹⁴⁴.
pub type Grid = BigInt;

/// The number of the grid at or below `value`.
pub fn on_grid(value: &BigRational) -> Grid {
    (value * power_of_two(144)).floor().to_integer()
}

/// The number of the grid at or above `value`.
pub fn above(value: &BigRational) -> Grid {
    (value * power_of_two(144)).ceil().to_integer()
}

/// Exactly what the number of the grid is.
pub fn exactly(value: &Grid) -> BigRational {
    BigRational::from(value.clone()) * power_of_two(-144)
}

/// a · b, rounded down.
pub fn times(a: &Grid, b: &Grid) -> Grid {
    (a * b) >> BITS
}
