//! Real numbers between two multiples of 2⁻¹⁹², rounded outward in every operation.

use std::ops::{Add, Mul, Neg, Sub};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::exact::rational::power_of_two;

/// Bits after the point.
const BITS: usize = 192;

/// Every real number from `low` to `high`, in units of 2⁻¹⁹².
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Enclosure {
    low: BigInt,
    high: BigInt,
}

impl Enclosure {
    /// From `low` to `high`.
    pub fn new(low: &BigRational, high: &BigRational) -> Self {
        let unit = power_of_two(192);
        Enclosure {
            low: (low * &unit).floor().to_integer(),
            high: (high * unit).ceil().to_integer(),
        }
    }

    /// One number.
    pub fn point(value: &BigRational) -> Self {
        Enclosure::new(value, value)
    }

    /// Whether all of it is above zero.
    pub fn is_positive(&self) -> bool {
        self.low.is_positive()
    }

    /// Whether all of it is below zero.
    pub fn is_negative(&self) -> bool {
        self.high.is_negative()
    }

    /// The reciprocal of a positive number; `None` for others.
    pub fn reciprocal(&self) -> Option<Self> {
        if !self.is_positive() {
            return None;
        }
        let square = BigInt::from(1) << (2 * BITS);
        Some(Enclosure {
            low: square.div_floor(&self.high),
            high: -((-square).div_floor(&self.low)),
        })
    }

    /// Of |x| for every x in it.
    pub fn magnitude(&self) -> Self {
        let high = self.high.abs().max(self.low.abs());
        let low = if self.is_positive() || self.is_negative() {
            self.high.abs().min(self.low.abs())
        } else {
            BigInt::zero()
        };
        Enclosure { low, high }
    }

    /// Its largest magnitude, in units of 2⁻¹⁹².
    pub fn largest(&self) -> BigInt {
        self.high.abs().max(self.low.abs())
    }

    /// The intersection of both; `None` if it is empty.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let low = self.low.clone().max(other.low.clone());
        let high = self.high.clone().min(other.high.clone());
        (low <= high).then_some(Enclosure { low, high })
    }

    /// Zero.
    pub fn zero() -> Self {
        Enclosure {
            low: BigInt::zero(),
            high: BigInt::zero(),
        }
    }

    /// Whether `value` lies in it.
    pub fn holds(&self, value: &BigRational) -> bool {
        let scaled = value * power_of_two(192);
        BigRational::from(self.low.clone()) <= scaled
            && scaled <= BigRational::from(self.high.clone())
    }
}

impl Add for &Enclosure {
    type Output = Enclosure;
    fn add(self, other: &Enclosure) -> Enclosure {
        Enclosure {
            low: &self.low + &other.low,
            high: &self.high + &other.high,
        }
    }
}

impl Sub for &Enclosure {
    type Output = Enclosure;
    fn sub(self, other: &Enclosure) -> Enclosure {
        Enclosure {
            low: &self.low - &other.high,
            high: &self.high - &other.low,
        }
    }
}

impl Neg for &Enclosure {
    type Output = Enclosure;
    fn neg(self) -> Enclosure {
        Enclosure {
            low: -&self.high,
            high: -&self.low,
        }
    }
}

impl Mul for &Enclosure {
    type Output = Enclosure;
    fn mul(self, other: &Enclosure) -> Enclosure {
        let corners = [
            &self.low * &other.low,
            &self.low * &other.high,
            &self.high * &other.low,
            &self.high * &other.high,
        ];
        let mut low = corners[0].clone();
        let mut high = corners[0].clone();
        for corner in corners {
            if corner < low {
                low = corner;
            } else if corner > high {
                high = corner;
            }
        }
        // A right shift of a big integer rounds down.
        Enclosure {
            low: low >> BITS,
            high: -((-high) >> BITS),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::rational::decimal;

    fn e(low: &str, high: &str) -> Enclosure {
        Enclosure::new(&decimal(low).unwrap(), &decimal(high).unwrap())
    }

    /// Results hold the results of numbers taken from the operands, ends included.
    #[test]
    fn operations_enclose() {
        let pairs = [
            ("-1.5", "0.3"),
            ("0.1", "0.7"),
            ("-3", "-2.9"),
            ("1e-9", "1e9"),
        ];
        for a in pairs {
            for b in pairs {
                let (x, y) = (e(a.0, a.1), e(b.0, b.1));
                for s in [a.0, a.1].map(|text| decimal(text).unwrap()) {
                    for t in [b.0, b.1].map(|text| decimal(text).unwrap()) {
                        assert!((&x + &y).holds(&(&s + &t)));
                        assert!((&x - &y).holds(&(&s - &t)));
                        assert!((&x * &y).holds(&(&s * &t)));
                        assert!((-&x).holds(&-&s));
                        if let Some(reciprocal) = x.reciprocal() {
                            assert!(reciprocal.holds(&s.recip()));
                        }
                    }
                }
            }
        }
        assert!(e("-1", "1").reciprocal().is_none());
        assert!(!e("0.1", "0.2").holds(&decimal("0.3").unwrap()));
    }
}
