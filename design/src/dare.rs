//! The discrete algebraic Riccati equation, solved by the structure-preserving doubling
//! algorithm.
//!
//! ```text
//! X = AᵀXA − (AᵀXB + N)(R + BᵀXB)⁻¹(BᵀXA + Nᵀ) + Q,   K = (R + BᵀXB)⁻¹(BᵀXA + Nᵀ)
//! ```
//!
//! The cross term is removed first: with u = v − R⁻¹Nᵀx, the equation has the same X for
//! Â = A − B R⁻¹Nᵀ, Q̂ = Q − N R⁻¹Nᵀ and no cross term. Then, from A₀ = Â, G₀ = B R⁻¹Bᵀ, H₀ = Q̂,
//!
//! ```text
//! Aₖ₊₁ = Aₖ (I + GₖHₖ)⁻¹ Aₖ
//! Gₖ₊₁ = Gₖ + Aₖ (I + GₖHₖ)⁻¹ Gₖ Aₖᵀ
//! Hₖ₊₁ = Hₖ + Aₖᵀ Hₖ (I + GₖHₖ)⁻¹ Aₖ   →   X
//! ```
//!
//! (E. Chu, H. Fan, W. Lin, C. Wang, "Structure-preserving algorithms for periodic discrete-time
//! algebraic Riccati equations", Int. J. Control 77(8), 2004). Hₖ is the cost of 2ᵏ steps, so k
//! doublings do the work of 2ᵏ steps of the fixed-point iteration.

use crate::error::DesignError;
use crate::matrix::{check_finite, check_shape, smallest_scaled_eigenvalue, symmetric};
use crate::poles::{eigenvalues, spectral_radius};
use crate::sampled_cost::QuadraticCost;
use crate::structural::reach;
use nalgebra::DMatrix;

/// Largest relative residual that is accepted. Doubling reaches about 1e-13 on problems
/// that are far from the limit of stabilisability. At 1e-9, the gains still have many more correct
/// digits than any identified parameter.
const ALLOWED_RESIDUAL: f64 = 1e-9;

/// 2⁶⁰ steps: a loop that has not settled by then has a pole on the unit circle.
const MOST_DOUBLINGS: usize = 60;

/// A solution of the equation, with its residual.
#[derive(Clone, Debug, PartialEq)]
pub struct DareSolution {
    /// X (n×n), symmetric: xᵀXx is the cost to go from state x.
    pub cost_to_go: DMatrix<f64>,
    /// K (m×n), the law u = −K x.
    pub gain: DMatrix<f64>,
    /// Frobenius norm of the equation's residual, divided by that of its largest term.
    pub residual: f64,
    /// Number of doublings.
    pub doublings: usize,
}

/// The stabilising solution for x⁺ = A x + B u (A n×n, B n×m) under `cost`.
///
/// # Errors
/// [`DesignError::IndefiniteWeights`] unless R is positive definite and the joint weight positive
/// if the minimum of the cost does not stabilise the loop; [`DesignError::NoConvergence`];
/// [`DesignError::InaccurateSolution`]; wrong shapes, and entries that are not finite.
pub fn solve_dare(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    cost: &QuadraticCost,
) -> Result<DareSolution, DesignError> {
    let (n, m) = (a.nrows(), b.ncols());
    check_shape("the state matrix A", a, n, n)?;
    check_shape("the input matrix B", b, n, m)?;
    check_shape("the state weight Q", &cost.state, n, n)?;
    check_shape("the cross weight N", &cost.cross, n, m)?;
    check_shape("the current weight R", &cost.input, m, m)?;
    check_finite("the state matrix A", a)?;
    check_finite("the input matrix B", b)?;
    check_weights(cost)?;
    for mode in eigenvalues(a)? {
        // Modes inside the unit circle decay without control, and need no test.
        if mode.norm() >= 1.0 {
            let reach = reach(a, b, mode)?;
            if reach < f64::EPSILON * 10.0 * n as f64 {
                return Err(DesignError::NotStabilisable {
                    re: mode.re,
                    im: mode.im,
                    reach,
                });
            }
        }
    }

    let (cost_to_go, doublings) = double(a, b, cost)?;
    let (gain, residual) = gain_and_residual(a, b, cost, &cost_to_go)?;
    let spectral_radius = spectral_radius(&(a - b * &gain))?;
    if spectral_radius >= 1.0 {
        return Err(DesignError::WeightsHideUnstableMode { spectral_radius });
    }
    if residual.is_nan() || residual > ALLOWED_RESIDUAL {
        return Err(DesignError::InaccurateSolution {
            equation: "discrete Riccati equation",
            residual,
            allowed: ALLOWED_RESIDUAL,
        });
    }
    Ok(DareSolution {
        cost_to_go,
        gain,
        residual,
        doublings,
    })
}

/// R > 0 and [[Q, N], [Nᵀ, R]] ≥ 0, up to rounding.
fn check_weights(cost: &QuadraticCost) -> Result<(), DesignError> {
    let joint = cost.joint();
    check_finite("a weight", &joint)?;
    let smallest = smallest_scaled_eigenvalue(&cost.input);
    let rounding = 1e-13 * joint.nrows() as f64;
    if smallest <= rounding {
        return Err(DesignError::IndefiniteWeights {
            what: "the current weight must be greater than zero",
            smallest_eigenvalue: smallest,
        });
    }
    let smallest = smallest_scaled_eigenvalue(&joint);
    if smallest < -rounding {
        return Err(DesignError::IndefiniteWeights {
            what: "the joint weight of state and current must not be negative",
            smallest_eigenvalue: smallest,
        });
    }
    Ok(())
}

/// The doubling iteration: X and the number of doublings.
fn double(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    cost: &QuadraticCost,
) -> Result<(DMatrix<f64>, usize), DesignError> {
    let n = a.nrows();
    let singular = DesignError::Singular {
        what: "the current weight R",
        cure: "give the current a weight greater than zero",
    };
    let weight = cost.input.clone().lu();
    let cross = weight
        .solve(&cost.cross.transpose())
        .ok_or_else(|| singular.clone())?;
    let reach = weight.solve(&b.transpose()).ok_or(singular)?;
    let mut a_k = a - b * &cross;
    let mut g_k = symmetric(&(b * reach));
    let mut h_k = symmetric(&(&cost.state - &cost.cross * cross));
    let mut change = f64::INFINITY;
    for doublings in 1..=MOST_DOUBLINGS {
        let middle = (DMatrix::identity(n, n) + &g_k * &h_k).lu();
        let (Some(through), Some(spread)) = (middle.solve(&a_k), middle.solve(&g_k)) else {
            break;
        };
        let h_next = symmetric(&(&h_k + a_k.transpose() * &h_k * &through));
        let g_next = symmetric(&(&g_k + &a_k * spread * a_k.transpose()));
        a_k = &a_k * through;
        let step = (&h_next - &h_k).norm();
        let size = h_next.norm();
        if !size.is_finite() || !g_next.norm().is_finite() {
            break;
        }
        change = if size > 0.0 { step / size } else { 0.0 };
        h_k = h_next;
        g_k = g_next;
        if change <= f64::EPSILON * n as f64 {
            return Ok((h_k, doublings));
        }
    }
    Err(DesignError::NoConvergence {
        method: "the doubling algorithm",
        iterations: MOST_DOUBLINGS,
        change,
        cure: "the optimal loop has a pole on the unit circle; give every state a weight greater \
               than zero",
    })
}

/// K and the relative residual of the equation at X.
fn gain_and_residual(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    cost: &QuadraticCost,
    x: &DMatrix<f64>,
) -> Result<(DMatrix<f64>, f64), DesignError> {
    let weighted = b.transpose() * x;
    let coupling = &weighted * a + cost.cross.transpose();
    let gain =
        (&cost.input + &weighted * b)
            .lu()
            .solve(&coupling)
            .ok_or(DesignError::Singular {
                what: "R + BᵀXB",
                cure: "give the current a weight greater than zero",
            })?;
    let carried = a.transpose() * x * a;
    let saved = coupling.transpose() * &gain;
    let largest = [x, &carried, &saved, &cost.state]
        .iter()
        .map(|term| term.norm())
        .fold(0.0, f64::max);
    let residual = (carried - saved + &cost.state - x).norm();
    Ok((
        gain,
        if largest > 0.0 {
            residual / largest
        } else {
            0.0
        },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use crate::zero_order_hold::zero_order_hold;
    use nalgebra::DVector;
    use proptest::prelude::*;

    /// The oracle: the Riccati difference equation, iterated until it no longer changes.
    fn iterate(
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        cost: &QuadraticCost,
        steps: usize,
    ) -> DMatrix<f64> {
        let mut x = cost.state.clone();
        for _ in 0..steps {
            let coupling = b.transpose() * &x * a + cost.cross.transpose();
            let inner = &cost.input + b.transpose() * &x * b;
            let next = a.transpose() * &x * a
                - coupling.transpose() * inner.lu().solve(&coupling).unwrap()
                + &cost.state;
            let still = (&next - &x).norm() <= 1e-15 * next.norm();
            x = symmetric(&next);
            if still {
                break;
            }
        }
        x
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        /// Weights come as WᵀW, so they are positive definite and have a cross term.
        #[test]
        fn doubling_agrees_with_fixed_point_iteration(
            size in 1usize..5,
            inputs in 1usize..3,
            entries in prop::collection::vec(-1.5..1.5_f64, 24),
            factors in prop::collection::vec(-1.0..1.0_f64, 36),
        ) {
            let a = DMatrix::from_row_slice(size, size, &entries[..size * size]);
            let b = DMatrix::from_row_slice(size, inputs, &entries[16..16 + size * inputs]);
            let whole = size + inputs;
            let factor = DMatrix::from_row_slice(whole, whole, &factors[..whole * whole])
                + DMatrix::identity(whole, whole);
            let joint = factor.transpose() * factor + DMatrix::identity(whole, whole) * 0.01;
            let cost = QuadraticCost {
                state: joint.view((0, 0), (size, size)).into_owned(),
                cross: joint.view((0, size), (size, inputs)).into_owned(),
                input: joint.view((size, size), (inputs, inputs)).into_owned(),
            };
            // Where the input hardly reaches an unstable mode the oracle itself is inaccurate.
            for mode in eigenvalues(&a).unwrap() {
                prop_assume!(mode.norm() < 0.99 || reach(&a, &b, mode).unwrap() > 0.02);
            }
            let solution = solve_dare(&a, &b, &cost).unwrap();
            // Every doubling solves a system with I + G H, which tends to I + G X. The condition number of this matrix
            // multiplies the rounding errors; in 20,000 draws the worst residual was 2.6 times this product.
            let weight = cost.input.clone().lu();
            let reach_by_cost = &b * weight.solve(&b.transpose()).unwrap();
            let solved = DMatrix::identity(size, size) + reach_by_cost * &solution.cost_to_go;
            let stretches = solved.singular_values();
            let rounding = f64::EPSILON * stretches.max() / stretches.min();
            let allowed = 1e-13 + 20.0 * rounding;
            prop_assert!(
                solution.residual < allowed,
                "residual {:e}, allowed {allowed:e}",
                solution.residual
            );
            let radius = spectral_radius(&(&a - &b * &solution.gain)).unwrap();
            prop_assert!(radius < 1.0);
            prop_assert!(smallest_scaled_eigenvalue(&solution.cost_to_go) > 0.0);
            let slow = iterate(&a, &b, &cost, 200_000);
            let difference = (&slow - &solution.cost_to_go).norm() / slow.norm();
            prop_assert!(difference < 1e-8, "differs by {difference:e}");
        }
    }

    #[test]
    fn scalar_case_in_closed_form() {
        // x⁺ = 2x + u, q = r = 1: X² − 4X − 1 = 0, so X = 2 + √5.
        let one = DMatrix::from_element(1, 1, 1.0);
        let cost = QuadraticCost::without_cross_term(one.clone(), one.clone());
        let solution = solve_dare(&(&one * 2.0), &one, &cost).unwrap();
        let golden = 2.0 + 5.0_f64.sqrt();
        assert!((solution.cost_to_go[0] - golden).abs() < 1e-14 * golden);
    }

    #[test]
    fn thesis_bench_without_the_sampled_cost() {
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), 1e-3).unwrap();
        let q = DMatrix::from_diagonal(&DVector::from_column_slice(&[25.0, 0.5, 5e-4]));
        let cost = QuadraticCost::without_cross_term(q, DMatrix::from_element(1, 1, 1.0));
        let solution = solve_dare(&hold.state, &hold.input, &cost).unwrap();
        thesis::assert_close(
            &solution.gain,
            &[-24.2670652, -2.12972161, -0.0225873017],
            3e-9,
        );
        assert!(solution.residual < 1e-12, "{:e}", solution.residual);
    }

    #[test]
    fn a_mode_out_of_reach_is_named() {
        let a = DMatrix::from_row_slice(2, 2, &[1.1, 0.0, 0.0, 0.5]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let cost =
            QuadraticCost::without_cross_term(DMatrix::identity(2, 2), DMatrix::identity(1, 1));
        match solve_dare(&a, &b, &cost) {
            Err(DesignError::NotStabilisable { re, .. }) => assert!((re - 1.1).abs() < 1e-12),
            other => panic!("{other:?}"),
        }
        // Inside the unit circle, the input need not reach the same mode.
        let a = DMatrix::from_row_slice(2, 2, &[0.9, 0.0, 0.0, 0.5]);
        assert!(solve_dare(&a, &b, &cost).is_ok());
    }

    #[test]
    fn bad_weights_are_named() {
        let (a, b) = (thesis::a() * 1e-3, thesis::b());
        let good =
            QuadraticCost::without_cross_term(DMatrix::identity(3, 3), DMatrix::identity(1, 1));
        let mut negative = good.clone();
        negative.state[(1, 1)] = -1.0;
        let mut free = good.clone();
        free.input[0] = 0.0;
        let mut crossed = good.clone();
        crossed.cross[0] = 1.5;
        for cost in [negative, free, crossed] {
            assert!(matches!(
                solve_dare(&a, &b, &cost),
                Err(DesignError::IndefiniteWeights { .. })
            ));
        }
        let mut not_a_number = good;
        not_a_number.state[0] = f64::NAN;
        assert!(matches!(
            solve_dare(&a, &b, &not_a_number),
            Err(DesignError::NotFinite { .. })
        ));
    }

    #[test]
    fn weights_that_hide_the_fall_are_an_error() {
        let hold = zero_order_hold(&thesis::a(), &thesis::b(), 1e-3).unwrap();
        let cost = QuadraticCost::without_cross_term(DMatrix::zeros(3, 3), DMatrix::identity(1, 1));
        assert!(matches!(
            solve_dare(&hold.state, &hold.input, &cost),
            Err(DesignError::WeightsHideUnstableMode { .. })
        ));
    }
}
