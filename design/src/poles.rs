//! Eigenvalues, their conditioning, and their sensitivity to the matrix.
//!
//! For a simple eigenvalue λ with right and left eigenvectors v, w (A v = λ v, wᴴA = λ wᴴ)
//!
//! ```text
//! dλ = wᴴ dA v / (wᴴ v),   condition number 1/|wᴴv| with ‖v‖ = ‖w‖ = 1
//! ```
//!
//! (J. Wilkinson, "The Algebraic Eigenvalue Problem", 1965, chapter 2). The condition number
//! depends on the units of the states. It is therefore computed in balanced coordinates (diagonal scaling by
//! powers of two after Parlett and Reinsch, 1969): angles in degrees give the same number.

use crate::error::DesignError;
use crate::matrix::check_finite;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector, Schur};

/// One eigenvalue of a state matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct Pole {
    /// λ: in 1/s for a continuous matrix, dimensionless for a discrete one.
    pub value: Complex<f64>,
    /// 1/|wᴴv| in balanced coordinates, 1 at best: a relative disturbance ε of the matrix moves λ
    /// by at most this times ε‖A‖. Infinite for a defective eigenvalue.
    pub condition: f64,
    /// ∂λ/∂A (n×n): an entry is the change of λ per unit of that entry of A.
    pub sensitivity: DMatrix<Complex<f64>>,
}

impl Pole {
    /// The continuous pole ln(λ)/T of this discrete pole, in 1/s.
    pub fn continuous_equivalent(&self, sample_time_s: f64) -> Complex<f64> {
        self.value.ln() / sample_time_s
    }

    /// First-order change of λ if the matrix changes by `change` (n×n).
    pub fn movement(&self, change: &DMatrix<f64>) -> Complex<f64> {
        self.sensitivity
            .iter()
            .zip(change.iter())
            .map(|(sensitivity, change)| sensitivity * *change)
            .sum()
    }
}

/// The eigenvalues of a square matrix, by real part and then imaginary part.
///
/// # Errors
/// Entries that are not finite; [`DesignError::NoConvergence`] of the QR iteration.
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<Complex<f64>>, DesignError> {
    check_finite("a matrix whose eigenvalues are wanted", matrix)?;
    let mut balanced = matrix.clone();
    balance_parlett_reinsch(&mut balanced);
    const MOST_STEPS: usize = 10_000;
    let schur =
        Schur::try_new(balanced, f64::EPSILON, MOST_STEPS).ok_or(DesignError::NoConvergence {
            method: "the QR iteration for eigenvalues",
            iterations: MOST_STEPS,
            change: f64::NAN,
            cure: "check the model for numbers of unreasonable size",
        })?;
    let mut values: Vec<_> = schur.complex_eigenvalues().iter().copied().collect();
    values.sort_by(|left, right| {
        left.re
            .total_cmp(&right.re)
            .then(left.im.total_cmp(&right.im))
    });
    Ok(values)
}

/// Largest modulus of the eigenvalues: below one, a discrete loop is stable.
///
/// # Errors
/// Entries that are not finite; [`DesignError::NoConvergence`] of the QR iteration.
pub fn spectral_radius(matrix: &DMatrix<f64>) -> Result<f64, DesignError> {
    Ok(eigenvalues(matrix)?
        .iter()
        .map(|value| value.norm())
        .fold(0.0, f64::max))
}

/// The eigenvalues of a square matrix with their condition and sensitivity, ordered as
/// [`eigenvalues`].
///
/// # Errors
/// Entries that are not finite; [`DesignError::NoConvergence`] of the QR iteration.
pub fn poles(matrix: &DMatrix<f64>) -> Result<Vec<Pole>, DesignError> {
    let values = eigenvalues(matrix)?;
    let mut balanced = matrix.clone();
    let scale = balance_parlett_reinsch(&mut balanced);
    values
        .into_iter()
        .map(|value| pole(&balanced, &scale, value))
        .collect()
}

fn pole(
    balanced: &DMatrix<f64>,
    scale: &DVector<f64>,
    value: Complex<f64>,
) -> Result<Pole, DesignError> {
    let n = balanced.nrows();
    let v = eigenvector(balanced, value)?;
    // wᴴA = λwᴴ is Aᵀw = λ*w.
    let w = eigenvector(&balanced.transpose(), value.conj())?;
    let overlap = w.dotc(&v);
    // Undo the balancing: A = D Ab D⁻¹, so v = D vb and wᴴ = wbᴴ D⁻¹.
    let sensitivity = DMatrix::from_fn(n, n, |row, column| {
        w[row].conj() / scale[row] * v[column] * scale[column] / overlap
    });
    Ok(Pole {
        value,
        condition: 1.0 / overlap.norm(),
        sensitivity,
    })
}

/// A unit eigenvector by inverse iteration. With λ known up to rounding, one solve with A − λI
/// already gives its direction; three are enough from any start.
fn eigenvector(
    matrix: &DMatrix<f64>,
    value: Complex<f64>,
) -> Result<DVector<Complex<f64>>, DesignError> {
    let n = matrix.nrows();
    let norm = match matrix.norm() {
        0.0 => 1.0,
        norm => norm,
    };
    // A start without symmetry, so that it is not orthogonal to an eigenvector.
    let start = DVector::from_fn(n, |row, _| Complex::new(1.0, 0.3 + 0.1 * row as f64));
    // If λ is exact, the shift must be large enough to avoid a zero pivot.
    for shift in [1.0, 4.0, 16.0, 64.0, 256.0] {
        let shifted = DMatrix::from_fn(n, n, |row, column| {
            let entry = Complex::from(matrix[(row, column)]);
            if row == column {
                entry - value - shift * f64::EPSILON * norm
            } else {
                entry
            }
        });
        let factors = shifted.lu();
        let settled = (0..3).try_fold(start.clone(), |vector, _| {
            factors.solve(&vector).map(|solved| solved.normalize())
        });
        match settled {
            Some(vector) if vector.iter().all(|entry| entry.re.is_finite()) => return Ok(vector),
            _ => {}
        }
    }
    Err(DesignError::Singular {
        what: "a matrix shifted off its eigenvalue",
        cure: "check the model for numbers of unreasonable size",
    })
}

/// `values` in the order of `reference`, matched greedily by distance.
pub(crate) fn matched(
    reference: &[Complex<f64>],
    mut values: Vec<Complex<f64>>,
) -> Vec<Complex<f64>> {
    reference
        .iter()
        .filter_map(|wanted| {
            let nearest = values
                .iter()
                .enumerate()
                .min_by(|(_, a), (_, b)| (*a - wanted).norm().total_cmp(&(*b - wanted).norm()))
                .map(|(index, _)| index)?;
            Some(values.swap_remove(nearest))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use proptest::prelude::*;

    #[test]
    fn thesis_bench_in_open_loop() {
        let golden = [-11.93749883, -0.1287069, 9.47577372];
        let printed_to = [1e-8, 1e-7, 1e-8];
        for ((pole, golden), digits) in poles(&thesis::a())
            .unwrap()
            .iter()
            .zip(golden)
            .zip(printed_to)
        {
            assert!((pole.value.re - golden).abs() < digits, "{}", pole.value);
            assert_eq!(pole.value.im, 0.0);
            assert!(pole.condition >= 1.0 - 1e-12);
        }
    }

    #[test]
    fn condition_does_not_depend_on_units() {
        let a = thesis::a();
        let degrees = DMatrix::from_diagonal(&DVector::from_column_slice(&[57.3, 57.3, 9.55]));
        let scaled = &degrees * &a * degrees.clone().try_inverse().unwrap();
        for (left, right) in poles(&a).unwrap().iter().zip(poles(&scaled).unwrap()) {
            assert!((left.value - right.value).norm() < 1e-9);
            // Balancing works with powers of two, so it is not quite unique.
            let ratio = left.condition / right.condition;
            assert!((0.5..2.0).contains(&ratio), "{ratio}");
        }
    }

    #[test]
    fn a_defective_eigenvalue_is_ill_conditioned() {
        let jordan = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0]);
        assert!(poles(&jordan).unwrap()[0].condition > 1e7);
        let symmetric = DMatrix::from_row_slice(2, 2, &[1.0, 0.3, 0.3, 2.0]);
        assert!((poles(&symmetric).unwrap()[0].condition - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn sensitivity_predicts_small_changes(
            entries in prop::collection::vec(-3.0..3.0_f64, 9),
            change in prop::collection::vec(-1.0..1.0_f64, 9),
        ) {
            let a = DMatrix::from_row_slice(3, 3, &entries);
            let poles = poles(&a).unwrap();
            let values: Vec<_> = poles.iter().map(|pole| pole.value).collect();
            let apart = (0..3)
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| (values[i] - values[j]).norm())
                .fold(f64::INFINITY, f64::min);
            let steepest = poles
                .iter()
                .map(|pole| pole.sensitivity.norm())
                .fold(0.0, f64::max);
            prop_assume!(apart > 0.3 && steepest < 5.0);
            let change = DMatrix::from_row_slice(3, 3, &change) * 1e-5;
            // The second-order term is Σ (wᵢᴴ dA vⱼ)(wⱼᴴ dA vᵢ)/(λᵢ − λⱼ) over two other poles.
            let second_order = 2.0 * (steepest * change.norm()).powi(2) / apart;
            let moved = matched(&values, eigenvalues(&(&a + &change)).unwrap());
            for (pole, moved) in poles.iter().zip(moved) {
                let first_order = pole.value + pole.movement(&change);
                prop_assert!((moved - first_order).norm() < 1.01 * second_order + 1e-12);
            }
        }

        #[test]
        fn trace_and_determinant_are_sum_and_product(
            entries in prop::collection::vec(-10.0..10.0_f64, 16),
        ) {
            let a = DMatrix::from_row_slice(4, 4, &entries);
            let values = eigenvalues(&a).unwrap();
            let sum: Complex<f64> = values.iter().sum();
            let product: Complex<f64> = values.iter().product();
            prop_assert!((sum - a.trace()).norm() < 1e-10 * (1.0 + a.norm()));
            prop_assert!((product - a.determinant()).norm() < 1e-11 * a.norm().powi(4).max(1.0));
        }
    }
}
