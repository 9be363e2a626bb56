//! Linear quadratic regulators from a model, weights and a sample time.

use crate::care::CareSolution;
use crate::care::solve_care;
use crate::dare::DareSolution;
use crate::dare::solve_dare;
use crate::error::DesignError;
use crate::extended;
use crate::matrix::{check_finite, check_positive, of_model};
use crate::sampled_cost::sampled_cost;
use crate::zero_order_hold::{Discrete, zero_order_hold};
use nalgebra::{DMatrix, DVector, RowVector3, Vector3};
use plant::LinearModel;

/// The weights of the cost that the regulator minimises: ∫ (xᵀ diag(state) x + current·u²) dt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Weights of (angle, rate, wheel speed), in 1/s per rad², (rad/s)², (rad/s)².
    pub state: Vector3<f64>,
    /// Weight of the current, in 1/s per A².
    pub current: f64,
}

impl Weights {
    /// The weights of the thesis. It prints their gains, (−24.4786, −2.14922, −0.0228898), but not
    /// the weights; these were found from the gains.
    pub const OF_THE_THESIS: Weights = Weights {
        state: Vector3::new(25.0, 0.5, 5e-4),
        current: 1.0,
    };

    /// Q (3×3) and R (1×1).
    pub(crate) fn matrices(&self) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
        check_positive("the current weight", self.current)?;
        let q = DMatrix::from_diagonal(&DVector::from_column_slice(self.state.as_slice()));
        check_finite("a state weight", &q)?;
        let smallest = self.state.min();
        if smallest < 0.0 {
            return Err(DesignError::IndefiniteWeights {
                what: "no state weight may be negative",
                smallest_eigenvalue: smallest,
            });
        }
        Ok((q, DMatrix::from_element(1, 1, self.current)))
    }
}

/// A discrete regulator u = −K x held between samples.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteRegulator {
    /// Ad and Bd of the zero-order hold.
    pub discrete: Discrete,
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: RowVector3<f64>,
    /// Cost to go and residual of the Riccati equation.
    pub riccati: DareSolution,
}

/// A continuous regulator u = −K x.
#[derive(Clone, Debug, PartialEq)]
pub struct ContinuousRegulator {
    /// K in A/rad, A s/rad, A s/rad.
    pub gains: RowVector3<f64>,
    /// Cost to go and residual of the Riccati equation.
    pub riccati: CareSolution,
}

fn row(gain: &DMatrix<f64>) -> RowVector3<f64> {
    RowVector3::new(gain[0], gain[1], gain[2])
}

/// The regulator that minimises the *continuous* cost, with a current that is held for
/// `sample_time_s` (see [`crate::sampled_cost`]). The gains are computed in extended precision.
///
/// # Errors
/// [`DesignError::GainsUncertain`]; those of [`solve_dare`], [`zero_order_hold`] and [`sampled_cost`].
pub fn discrete_regulator(
    model: &LinearModel,
    weights: &Weights,
    sample_time_s: f64,
) -> Result<DiscreteRegulator, DesignError> {
    let (a, b) = of_model(model)?;
    let (q, r) = weights.matrices()?;
    let discrete = zero_order_hold(&a, &b, sample_time_s)?;
    let cost = sampled_cost(&a, &b, &q, &r, sample_time_s)?;
    let mut riccati = solve_dare(&discrete.state, &discrete.input, &cost)?;
    riccati.gain = extended::gains(&a, &b, (&q, &r), sample_time_s, &riccati.gain)?;
    Ok(DiscreteRegulator {
        gains: row(&riccati.gain),
        discrete,
        riccati,
    })
}

/// The regulator for a current that can change at any time (no sampling).
///
/// # Errors
/// Those of [`solve_care`].
pub fn continuous_regulator(
    model: &LinearModel,
    weights: &Weights,
) -> Result<ContinuousRegulator, DesignError> {
    let (a, b) = of_model(model)?;
    let (q, r) = weights.matrices()?;
    let riccati = solve_care(&a, &b, &q, &r)?;
    Ok(ContinuousRegulator {
        gains: row(&riccati.gain),
        riccati,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poles::eigenvalues;
    use crate::thesis;
    use proptest::prelude::*;

    #[test]
    fn thesis_bench_at_one_millisecond() {
        let regulator = discrete_regulator(&thesis::model(), &thesis::weights(), 1e-3).unwrap();
        for (gain, golden) in regulator
            .gains
            .iter()
            .zip([-24.2672423, -2.12973867, -0.0225875821])
        {
            assert!((gain - golden).abs() < 3e-9 * golden.abs(), "{gain}");
        }
        let discrete = &regulator.discrete;
        let closed = &discrete.state - &discrete.input * &regulator.riccati.gain;
        let mut moduli: Vec<f64> = eigenvalues(&closed)
            .unwrap()
            .iter()
            .map(|pole| pole.norm())
            .collect();
        moduli.sort_by(f64::total_cmp);
        for (modulus, golden) in moduli.iter().zip([0.98272043, 0.99219767, 0.99544999]) {
            assert!((modulus - golden).abs() < 1e-8, "{modulus}");
        }
        assert!(regulator.riccati.residual < 1e-12);
    }

    #[test]
    fn thesis_bench_in_continuous_time() {
        let regulator = continuous_regulator(&thesis::model(), &thesis::weights()).unwrap();
        for (gain, golden) in regulator
            .gains
            .iter()
            .zip([-24.4787016, -2.14922301, -0.0228897984])
        {
            assert!((gain - golden).abs() < 3e-9 * golden.abs(), "{gain}");
        }
    }

    #[test]
    fn the_discrete_gains_tend_to_the_continuous_ones() {
        let continuous = continuous_regulator(&thesis::model(), &thesis::weights()).unwrap();
        let distance = |sample_time_s| {
            let discrete =
                discrete_regulator(&thesis::model(), &thesis::weights(), sample_time_s).unwrap();
            (discrete.gains - continuous.gains).norm()
        };
        // The held input costs to first order in the sample time.
        let ratio = distance(1e-4) / distance(1e-5);
        assert!((ratio - 10.0).abs() < 0.1, "{ratio}");
    }

    proptest! {
        /// Optimality itself: no other gains cost less from any start.
        #[test]
        fn no_other_gains_are_cheaper(
            start in prop::collection::vec(-1.0..1.0_f64, 3),
            change in prop::collection::vec(-0.2..0.2_f64, 3),
            sample_time_s in 2e-3..0.02_f64,
        ) {
            let (model, weights) = (thesis::model(), thesis::weights());
            let regulator = discrete_regulator(&model, &weights, sample_time_s).unwrap();
            let (a, b) = of_model(&model).unwrap();
            let (q, r) = weights.matrices().unwrap();
            let cost = sampled_cost(&a, &b, &q, &r, sample_time_s).unwrap().joint();
            let spend = |gain: &DMatrix<f64>| {
                let mut x = DMatrix::from_column_slice(3, 1, &start);
                let mut spent = 0.0;
                for _ in 0..20_000 {
                    let u = -(gain * &x);
                    let both = DMatrix::from_column_slice(4, 1, &[x[0], x[1], x[2], u[0]]);
                    spent += (both.transpose() * &cost * both)[0];
                    x = &regulator.discrete.state * x + &regulator.discrete.input * u;
                }
                spent
            };
            let best = &regulator.riccati.gain;
            let other = DMatrix::from_fn(1, 3, |_, i| best[i] * (1.0 + change[i]));
            let least = spend(best);
            let x = DMatrix::from_column_slice(3, 1, &start);
            let promised = (x.transpose() * &regulator.riccati.cost_to_go * &x)[0];
            prop_assert!((least - promised).abs() < 1e-6 * promised);
            // Unstable alternatives overflow, which also means "not cheaper".
            let spent = spend(&other);
            prop_assert!(!spent.is_finite() || spent >= least * (1.0 - 1e-9));
        }
    }

    #[test]
    fn bad_weights_are_named() {
        let mut weights = thesis::weights();
        weights.current = 0.0;
        assert!(matches!(
            discrete_regulator(&thesis::model(), &weights, 1e-3),
            Err(DesignError::NotPositive { .. })
        ));
        let mut weights = thesis::weights();
        weights.state[2] = -1.0;
        assert!(matches!(
            discrete_regulator(&thesis::model(), &weights, 1e-3),
            Err(DesignError::IndefiniteWeights { .. })
        ));
    }
}
