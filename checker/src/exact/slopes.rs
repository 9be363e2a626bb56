//! Functions of a few numbers in intervals, with their slopes: a bound that is of second order in the intervals' widths.
//!
//! For p in a box X with the middle c, f(p) lies in f(c) + Σ ∂ᵢf(X) (Xᵢ − cᵢ) (the mean value). Where an expression names a
//! parameter many times, this is far narrower than the intervals of the expression itself.

use num_rational::BigRational;

use crate::exact::enclosure::Enclosure;
use crate::exact::rational::integer;

/// Numbers that can be added, multiplied and inverted.
pub trait Number: Clone {
    /// A number that depends on nothing.
    fn constant(value: &BigRational) -> Self;
    /// self + other.
    fn plus(&self, other: &Self) -> Self;
    /// self − other.
    fn minus(&self, other: &Self) -> Self;
    /// self · other.
    fn times(&self, other: &Self) -> Self;
    /// 1/self; `None` where self may be zero or negative.
    fn over(&self) -> Option<Self>;
    /// Every value that it may have.
    fn range(&self) -> &Enclosure;
    /// The same, off by any number of `rest`.
    fn widened(&self, rest: &Enclosure) -> Self;

    /// Zero.
    fn nothing() -> Self {
        Self::constant(&integer(0))
    }
    /// One.
    fn one() -> Self {
        Self::constant(&integer(1))
    }
    /// −self.
    fn negated(&self) -> Self {
        Self::nothing().minus(self)
    }
}

impl Number for Enclosure {
    fn constant(value: &BigRational) -> Self {
        Enclosure::point(value)
    }
    fn plus(&self, other: &Self) -> Self {
        self + other
    }
    fn minus(&self, other: &Self) -> Self {
        self - other
    }
    fn times(&self, other: &Self) -> Self {
        self * other
    }
    fn over(&self) -> Option<Self> {
        self.reciprocal()
    }
    fn range(&self) -> &Enclosure {
        self
    }
    fn widened(&self, rest: &Enclosure) -> Self {
        self + rest
    }
}

/// A number, and how it changes with each of N others, over all of their intervals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slopes<const N: usize> {
    /// Its values.
    pub value: Enclosure,
    /// ∂/∂pᵢ.
    pub slopes: [Enclosure; N],
}

impl<const N: usize> Slopes<N> {
    /// The i-th of the others itself.
    pub fn parameter(index: usize, value: Enclosure) -> Self {
        let slopes = std::array::from_fn(|i| Enclosure::point(&integer(i128::from(i == index))));
        Slopes { value, slopes }
    }
}

impl<const N: usize> Number for Slopes<N> {
    fn constant(value: &BigRational) -> Self {
        Slopes {
            value: Enclosure::point(value),
            slopes: std::array::from_fn(|_| Enclosure::zero()),
        }
    }
    fn plus(&self, other: &Self) -> Self {
        Slopes {
            value: &self.value + &other.value,
            slopes: std::array::from_fn(|i| &self.slopes[i] + &other.slopes[i]),
        }
    }
    fn minus(&self, other: &Self) -> Self {
        Slopes {
            value: &self.value - &other.value,
            slopes: std::array::from_fn(|i| &self.slopes[i] - &other.slopes[i]),
        }
    }
    fn times(&self, other: &Self) -> Self {
        Slopes {
            value: &self.value * &other.value,
            slopes: std::array::from_fn(|i| {
                &(&self.slopes[i] * &other.value) + &(&self.value * &other.slopes[i])
            }),
        }
    }
    fn over(&self) -> Option<Self> {
        let value = self.value.reciprocal()?;
        let minus_square = -&(&value * &value);
        Some(Slopes {
            slopes: std::array::from_fn(|i| &self.slopes[i] * &minus_square),
            value,
        })
    }
    fn range(&self) -> &Enclosure {
        &self.value
    }
    fn widened(&self, rest: &Enclosure) -> Self {
        Slopes {
            value: &self.value + rest,
            slopes: self.slopes.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::rational::decimal;

    fn d(text: &str) -> BigRational {
        decimal(text).unwrap()
    }

    /// x y/(x + y) at [1, 2] × [3, 5]: ∂x = y²/(x + y)², ∂y = x²/(x + y)².
    #[test]
    fn slopes_hold_the_derivatives() {
        let x = Slopes::<2>::parameter(0, Enclosure::new(&d("1"), &d("2")));
        let y = Slopes::<2>::parameter(1, Enclosure::new(&d("3"), &d("5")));
        let f = x.times(&y).times(&x.plus(&y).over().unwrap());
        for (a, b) in [("1", "3"), ("2", "5"), ("1.5", "4"), ("1", "5")] {
            let (a, b) = (d(a), d(b));
            let sum = &a + &b;
            assert!(f.value.holds(&(&a * &b / &sum)));
            assert!(f.slopes[0].holds(&(&b * &b / (&sum * &sum))));
            assert!(f.slopes[1].holds(&(&a * &a / (&sum * &sum))));
        }
        assert!(x.minus(&x).over().is_none());
    }
}
