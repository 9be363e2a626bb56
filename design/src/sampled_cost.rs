//! The cost of a sampled loop: ∫ (xᵀQx + uᵀRu) dt between two samples while u is
//! held. With it, the discrete design minimises the continuous cost, not a sum with the same weights.
//!
//! ```text
//! ∫₀ᵀ (xᵀQx + uᵀRu) dt = x₀ᵀ Qd x₀ + 2 x₀ᵀ Nd u + uᵀ Rd u
//! ```
//!
//! With F = [[A, B], [0, 0]] and W = diag(Q, R), Van Loan (IEEE TAC 23(3), 1978, theorem 1) obtains
//! the integral from one matrix exponential:
//!
//! ```text
//! exp([[−Fᵀ, W], [0, F]] T) = [[·, Φ₁₂], [0, Φ₂₂]],   [[Qd, Nd], [Ndᵀ, Rd]] = Φ₂₂ᵀ Φ₁₂
//! ```

use crate::error::DesignError;
use crate::matrix::{check_positive, check_shape, symmetric};
use crate::zero_order_hold::exponential;
use nalgebra::DMatrix;

/// Weights of a discrete quadratic cost Σ xᵀQx + 2 xᵀNu + uᵀRu.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticCost {
    /// Q (n×n), symmetric.
    pub state: DMatrix<f64>,
    /// N (n×m), the cross term.
    pub cross: DMatrix<f64>,
    /// R (m×m), symmetric.
    pub input: DMatrix<f64>,
}

impl QuadraticCost {
    /// The weights Q (n×n) and R (m×m) without a cross term.
    pub fn without_cross_term(q: DMatrix<f64>, r: DMatrix<f64>) -> Self {
        QuadraticCost {
            cross: DMatrix::zeros(q.nrows(), r.nrows()),
            state: q,
            input: r,
        }
    }

    /// The whole weight [[Q, N], [Nᵀ, R]], (n+m)×(n+m).
    pub fn joint(&self) -> DMatrix<f64> {
        let (n, m) = (self.state.nrows(), self.input.nrows());
        let mut joint = DMatrix::zeros(n + m, n + m);
        joint.view_mut((0, 0), (n, n)).copy_from(&self.state);
        joint.view_mut((0, n), (n, m)).copy_from(&self.cross);
        joint
            .view_mut((n, 0), (m, n))
            .copy_from(&self.cross.transpose());
        joint.view_mut((n, n), (m, m)).copy_from(&self.input);
        joint
    }
}

/// The sampled cost of ẋ = A x + B u (A n×n, B n×m) with weights Q (n×n) and R (m×m) per second
/// and u held over `sample_time_s`.
///
/// # Errors
/// Wrong shapes, entries that are not finite, a sample time that is not positive.
pub fn sampled_cost(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
    sample_time_s: f64,
) -> Result<QuadraticCost, DesignError> {
    check_positive("the sample time in s", sample_time_s)?;
    let (n, m) = (a.nrows(), b.ncols());
    check_shape("the state matrix A", a, n, n)?;
    check_shape("the input matrix B", b, n, m)?;
    check_shape("the state weight Q", q, n, n)?;
    check_shape("the current weight R", r, m, m)?;

    let size = n + m;
    let mut held = DMatrix::zeros(size, size);
    held.view_mut((0, 0), (n, n)).copy_from(a);
    held.view_mut((0, n), (n, m)).copy_from(b);
    let mut exponent = DMatrix::zeros(2 * size, 2 * size);
    exponent
        .view_mut((0, 0), (size, size))
        .copy_from(&(-held.transpose()));
    exponent.view_mut((0, size), (n, n)).copy_from(q);
    exponent.view_mut((n, size + n), (m, m)).copy_from(r);
    exponent
        .view_mut((size, size), (size, size))
        .copy_from(&held);

    let whole = exponential(&(exponent * sample_time_s))?;
    let upper = whole.view((0, size), (size, size));
    let lower = whole.view((size, size), (size, size));
    let joint = symmetric(&(lower.transpose() * upper));
    Ok(QuadraticCost {
        state: joint.view((0, 0), (n, n)).into_owned(),
        cross: joint.view((0, n), (n, m)).into_owned(),
        input: joint.view((n, n), (m, m)).into_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::zero_order_hold::zero_order_hold;
    use proptest::prelude::*;

    proptest! {
        /// The oracle: Gauss-Legendre quadrature (three nodes in each of 100 intervals, error of
        /// order six) over the states that the hold passes through.
        #[test]
        fn equals_the_integral_of_the_continuous_cost(
            entries in prop::collection::vec(-3.0..3.0_f64, 12),
            start in prop::collection::vec(-1.0..1.0_f64, 4),
            weights in prop::collection::vec(0.0..2.0_f64, 4),
            time in 1e-3..0.5_f64,
        ) {
            let a = DMatrix::from_row_slice(3, 3, &entries[..9]);
            let b = DMatrix::from_row_slice(3, 1, &entries[9..]);
            let q = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(&weights[..3]));
            let r = DMatrix::from_element(1, 1, weights[3]);
            let x = DMatrix::from_column_slice(3, 1, &start[..3]);
            let u = DMatrix::from_element(1, 1, start[3]);
            let half = time / 200.0;
            let mut integral = 0.0;
            for interval in 0..100 {
                for (node, weight) in [(-0.6_f64.sqrt(), 5.0), (0.0, 8.0), (0.6_f64.sqrt(), 5.0)] {
                    let at = half * (f64::from(2 * interval + 1) + node);
                    let state = zero_order_hold(&a, &b, at)
                        .map(|hold| hold.state * &x + hold.input * &u)
                        .unwrap();
                    let rate = (state.transpose() * &q * &state + u.transpose() * &r * &u)[0];
                    integral += half * weight / 9.0 * rate;
                }
            }
            let cost = sampled_cost(&a, &b, &q, &r, time).unwrap();
            let mut both = x.clone().insert_row(3, 0.0);
            both[3] = u[0];
            let sampled = (both.transpose() * cost.joint() * &both)[0];
            prop_assert!((sampled - integral).abs() < 1e-9 * (1.0 + integral));
        }
    }
}
