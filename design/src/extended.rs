//! The regulator's gains in 106-bit arithmetic, so that the gains in the controller are either
//! correct to the last digit of a double, or refused.
//!
//! The steps are those of [`crate::zero_order_hold`], [`crate::sampled_cost`] and [`crate::dare`], beginning with
//! A, B and the weights. In double precision, rounding in any of them changes the gains if the model or the weights
//! span many orders of magnitude.

use crate::double_double::{DoubleDouble, Wide};
use crate::error::DesignError;
use nalgebra::DMatrix;

/// 2⁶⁰ steps: a loop that has not settled by then has a pole on the unit circle.
const MOST_DOUBLINGS: usize = 60;

/// Relative change at which the iteration has converged: some units in the last place of 106 bits.
const SETTLED: f64 = 1e-28;

/// Largest relative difference between the gains in double and in extended precision. A larger one means that
/// the problem loses most digits of a double. With the same loss, the result in 106 bits still has more than eight
/// correct digits; beyond this difference, that is no longer certain.
const LOST_MAX: f64 = 0.1;

/// K (1×n) for ẋ = A x + B u under the continuous cost with weights Q and R, with the current held for
/// `sample_time_s`; `rough` is K in double precision.
///
/// # Errors
/// [`DesignError::GainsUncertain`] if the two results differ so much that neither can be trusted;
/// [`DesignError::NotFinite`] or [`DesignError::NoConvergence`], as in double precision.
pub(crate) fn gains(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    (q, r): (&DMatrix<f64>, &DMatrix<f64>),
    sample_time_s: f64,
    rough: &DMatrix<f64>,
) -> Result<DMatrix<f64>, DesignError> {
    let found = solved(a, b, (q, r), sample_time_s)?.to_f64();
    let difference = (&found - rough).norm() / found.norm();
    if difference <= LOST_MAX {
        Ok(found)
    } else {
        Err(DesignError::GainsUncertain { difference })
    }
}

fn solved(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    (q, r): (&DMatrix<f64>, &DMatrix<f64>),
    sample_time_s: f64,
) -> Result<Wide, DesignError> {
    let overflow = DesignError::NotFinite {
        what: "a matrix exponential (the sample time is far too long for this model)",
    };
    let singular = DesignError::Singular {
        what: "the current weight R",
        cure: "give the current a weight greater than zero",
    };
    let (n, m) = (a.nrows(), b.ncols());
    let size = n + m;
    let mut held = Wide::zeros(size, size);
    held.put(0, 0, &Wide::of(a));
    held.put(0, n, &Wide::of(b));
    let mut exponent = Wide::zeros(2 * size, 2 * size);
    exponent.put(0, 0, &held.transposed().negated());
    exponent.put(0, size, &Wide::of(q));
    exponent.put(n, size + n, &Wide::of(r));
    exponent.put(size, size, &held);
    let whole = exponent
        .scaled(DoubleDouble::of(sample_time_s))
        .exponential()
        .ok_or(overflow)?;
    let lower = whole.block(size, size, size, size);
    let upper = whole.block(0, size, size, size);
    let joint = lower.transposed().times(&upper).symmetric();
    let (ad, bd) = (lower.block(0, 0, n, n), lower.block(0, n, n, m));
    let (qd, nd, rd) = (
        joint.block(0, 0, n, n),
        joint.block(0, n, n, m),
        joint.block(n, n, m, m),
    );

    let cross = rd.solve(&nd.transposed()).ok_or(singular.clone())?;
    let reach = rd.solve(&bd.transposed()).ok_or(singular.clone())?;
    let mut a_k = ad.minus(&bd.times(&cross));
    let mut g_k = bd.times(&reach).symmetric();
    let mut h_k = qd.minus(&nd.times(&cross)).symmetric();
    let mut change = f64::INFINITY;
    for _ in 0..MOST_DOUBLINGS {
        let middle = Wide::identity(n).plus(&g_k.times(&h_k));
        let (Some(through), Some(spread)) = (middle.solve(&a_k), middle.solve(&g_k)) else {
            break;
        };
        let h_next = h_k
            .plus(&a_k.transposed().times(&h_k).times(&through))
            .symmetric();
        g_k = g_k
            .plus(&a_k.times(&spread).times(&a_k.transposed()))
            .symmetric();
        a_k = a_k.times(&through);
        change = h_next.minus(&h_k).largest() / h_next.largest();
        h_k = h_next;
        if change.is_nan() || change <= SETTLED {
            break;
        }
    }
    if change.is_nan() || change > SETTLED {
        return Err(DesignError::NoConvergence {
            method: "the doubling algorithm in extended precision",
            iterations: MOST_DOUBLINGS,
            change,
            cure: "the optimal loop has a pole on the unit circle; give every state a weight \
                   greater than zero",
        });
    }
    let weighted = bd.transposed().times(&h_k);
    let coupling = weighted.times(&ad).plus(&nd.transposed());
    rd.plus(&weighted.times(&bd))
        .solve(&coupling)
        .ok_or(singular)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lqr::{Weights, discrete_regulator};
    use crate::thesis;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// On the bench of the thesis the gains in both precisions agree up to the rounding of a double.
    #[test]
    fn the_thesis_bench_loses_few_digits() {
        let regulator = discrete_regulator(&thesis::model(), &thesis::weights(), 1e-3).unwrap();
        let (q, r) = thesis::weights().matrices().unwrap();
        let (a, b) = (thesis::a(), thesis::b());
        let wide = solved(&a, &b, (&q, &r), 1e-3).unwrap().to_f64();
        let rough = &regulator.riccati.gain;
        assert!((&wide - rough).norm() < 1e-10 * wide.norm());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        /// A power of two as unit of a state or of the current changes no bit of a double and so
        /// none of the gains but their exponent; weights of any size are solved or refused.
        #[test]
        fn units_do_not_matter(
            exponents in prop::collection::vec(-20i32..20, 4),
            weights in prop::collection::vec(-6.0..6.0_f64, 4),
        ) {
            let scale: Vec<f64> = exponents.iter().map(|e| 2f64.powi(*e)).collect();
            let weights: Vec<f64> = weights.iter().map(|w| 10f64.powf(*w)).collect();
            let q = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(&weights[..3]));
            let r = DMatrix::from_element(1, 1, weights[3]);
            let (a, b) = (thesis::a(), thesis::b());
            let t = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(&scale[..3]));
            let back = t.clone().try_inverse().unwrap();
            let one = solved(&a, &b, (&q, &r), 1e-3);
            let a_other = &t * &a * &back;
            let b_other = &t * &b / scale[3];
            let q_other = &back * &q * &back;
            let r_other = &r / (scale[3] * scale[3]);
            let other = solved(&a_other, &b_other, (&q_other, &r_other), 1e-3);
            if let (Ok(one), Ok(other)) = (one, other) {
                let (one, other) = (one.to_f64(), other.to_f64() * &t / scale[3]);
                prop_assert!((&one - &other).norm() < 1e-6 * one.norm(), "{one} {other}");
            }
        }
    }

    /// For weights and benches with which double precision loses digits, the returned gains satisfy the Riccati
    /// equation in extended precision, or the design is refused.
    #[test]
    fn a_stiff_design_is_right_or_refused() {
        let weights = Weights {
            state: Vector3::new(1e-9, 1e6, 1e-12),
            current: 1e-9,
        };
        if let Ok(found) = discrete_regulator(&thesis::model(), &weights, 1e-3) {
            let (q, r) = weights.matrices().unwrap();
            let wide = solved(&thesis::a(), &thesis::b(), (&q, &r), 1e-3).unwrap();
            let wide = wide.to_f64();
            assert!((&wide - &found.riccati.gain).norm() <= 1e-6 * wide.norm());
        }
    }
}
