//! Controllability and observability, with a measure of how well they hold.
//!
//! ```text
//! C = [B, AB, …, Aⁿ⁻¹B],   O = [C; CA; …; CAⁿ⁻¹]
//! ```
//!
//! The ranks must not depend on the units, but the singular values do. The states are therefore first scaled to
//! comparable size (Parlett and Reinsch's balancing of A), time is measured in units of 1/‖A‖, and every input and
//! output is scaled to norm one. The rank is the number of singular values above n·ε·σ₁. In addition, every mode has a
//! relative distance to the nearest system in which it is lost, σ_min([A − λI, B])/‖A‖ (Popov, Belevitch, Hautus),
//! which shows *which* mode is hard to reach.

use crate::error::DesignError;
use crate::matrix::{check_finite, check_shape};
use crate::poles::eigenvalues;
use crate::singular_values::{singular_values, smallest_of_complex};
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix};

/// The rank of a controllability or observability matrix, and its distance to the next lower rank.
#[derive(Clone, Debug, PartialEq)]
pub struct StructuralRank {
    /// Number of singular values above rounding errors.
    pub rank: usize,
    /// Number of states; the full rank.
    pub states: usize,
    /// Singular values of the scaled matrix, the largest first, not normalised.
    pub singular_values: Vec<f64>,
    /// Ratio of the largest to the smallest singular value; infinite if the rank is not full.
    pub condition: f64,
    /// For every eigenvalue of A: its relative distance to being uncontrollable (or unobservable).
    pub modes: Vec<(Complex<f64>, f64)>,
}

impl StructuralRank {
    /// Whether every state is controllable (or observable).
    pub fn is_full(&self) -> bool {
        self.rank == self.states
    }
}

/// The controllability matrix [B, AB, …, Aⁿ⁻¹B] (n×nm) in the given units.
pub fn controllability_matrix(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let (n, m) = (a.nrows(), b.ncols());
    let mut matrix = DMatrix::zeros(n, n * m);
    let mut block = b.clone();
    for power in 0..n {
        matrix.view_mut((0, power * m), (n, m)).copy_from(&block);
        block = a * block;
    }
    matrix
}

/// The observability matrix [C; CA; …; CAⁿ⁻¹] (np×n) in the given units.
pub fn observability_matrix(a: &DMatrix<f64>, c: &DMatrix<f64>) -> DMatrix<f64> {
    controllability_matrix(&a.transpose(), &c.transpose()).transpose()
}

/// Rank and conditioning of the controllability matrix of A (n×n) and B (n×m).
///
/// # Errors
/// Wrong shapes, entries that are not finite.
pub fn controllability(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<StructuralRank, DesignError> {
    let scaled = Scaled::new(a, b)?;
    let n = a.nrows();
    let singular_values = singular_values(&controllability_matrix(&scaled.a, &scaled.b));
    let largest = singular_values.first().copied().unwrap_or(0.0);
    let smallest = singular_values.last().copied().unwrap_or(0.0);
    let rounding = largest * f64::EPSILON * n as f64;
    let rank = singular_values
        .iter()
        .filter(|value| **value > rounding)
        .count();
    let modes = eigenvalues(a)?
        .into_iter()
        .map(|mode| (mode, scaled.distance(mode)))
        .collect();
    Ok(StructuralRank {
        rank,
        states: n,
        singular_values,
        condition: if rank == n {
            largest / smallest
        } else {
            f64::INFINITY
        },
        modes,
    })
}

/// Rank and conditioning of the observability matrix of A (n×n) and C (p×n), the dual of
/// [`controllability`].
///
/// # Errors
/// Wrong shapes, entries that are not finite.
pub fn observability(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<StructuralRank, DesignError> {
    controllability(&a.transpose(), &c.transpose())
}

/// The relative distance of the mode λ from being uncontrollable, σ_min([A − λI, B])/‖A‖ in scaled coordinates; 0 if
/// the input does not reach the mode.
///
/// # Errors
/// Wrong shapes, entries that are not finite.
pub fn reach(a: &DMatrix<f64>, b: &DMatrix<f64>, mode: Complex<f64>) -> Result<f64, DesignError> {
    Ok(Scaled::new(a, b)?.distance(mode))
}

/// A and B in dimensionless coordinates.
struct Scaled {
    /// A after balancing, divided by its Frobenius norm.
    a: DMatrix<f64>,
    /// B in the coordinates of `a`, with each column scaled to norm one (a zero column stays zero).
    b: DMatrix<f64>,
    /// The factor by which A was divided, in 1/s for a continuous model.
    unit: f64,
}

impl Scaled {
    fn new(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<Self, DesignError> {
        let n = a.nrows();
        check_shape("the state matrix", a, n, n)?;
        check_shape("the input or output matrix", b, n, b.ncols())?;
        check_finite("the state matrix", a)?;
        check_finite("the input or output matrix", b)?;
        let mut balanced = a.clone();
        let scale = balance_parlett_reinsch(&mut balanced);
        let unit = match balanced.norm() {
            0.0 => 1.0,
            norm => norm,
        };
        let mut b = DMatrix::from_fn(n, b.ncols(), |row, column| b[(row, column)] / scale[row]);
        for mut column in b.column_iter_mut() {
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        Ok(Scaled {
            a: balanced / unit,
            b,
            unit,
        })
    }

    /// σ_min([A − λI, B]) for λ in the units of the caller's A.
    fn distance(&self, mode: Complex<f64>) -> f64 {
        let n = self.a.nrows();
        let mode = mode / self.unit;
        let pencil = DMatrix::from_fn(n, n + self.b.ncols(), |row, column| {
            if column >= n {
                Complex::from(self.b[(row, column - n)])
            } else if row == column {
                self.a[(row, column)] - mode
            } else {
                Complex::from(self.a[(row, column)])
            }
        });
        smallest_of_complex(&pencil)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use nalgebra::DVector;

    #[test]
    fn thesis_bench_is_controllable_and_observable() {
        let reach = controllability(&thesis::a(), &thesis::b()).unwrap();
        assert!(reach.is_full());
        assert_eq!(reach.modes.len(), 3);
        // The eigenvalues come back in 1/s.
        assert!((reach.modes[2].0.re - 9.47577372).abs() < 1e-8);
        assert!(
            observability(&thesis::a(), &DMatrix::identity(3, 3))
                .unwrap()
                .is_full()
        );
    }

    #[test]
    fn a_body_without_a_motor_is_not_controllable() {
        // The wheel turns, but its torque does not reach the body.
        let mut b = thesis::b();
        b[1] = 0.0;
        let mut a = thesis::a();
        a[(1, 2)] = 0.0;
        let reach = controllability(&a, &b).unwrap();
        assert_eq!(reach.rank, 1);
        assert_eq!(reach.condition, f64::INFINITY);
        let worst = reach
            .modes
            .iter()
            .map(|(_, reach)| *reach)
            .fold(1.0, f64::min);
        assert!(worst < 1e-14, "{worst:e}");
    }

    #[test]
    fn without_wheel_friction_the_angle_does_not_show_the_wheel() {
        let mut a = thesis::a();
        a[(1, 2)] = 0.0;
        a[(2, 2)] = 0.0;
        let angle = DMatrix::from_row_slice(1, 3, &[1.0, 0.0, 0.0]);
        let wheel = DMatrix::from_row_slice(1, 3, &[0.0, 0.0, 1.0]);
        assert_eq!(observability(&a, &angle).unwrap().rank, 2);
        assert_eq!(observability(&a, &wheel).unwrap().rank, 3);
    }

    #[test]
    fn units_change_nothing() {
        let (a, b) = (thesis::a(), thesis::b());
        // Degrees, revolutions per minute, milliamperes, and time in milliseconds.
        let units = DMatrix::from_diagonal(&DVector::from_column_slice(&[57.3, 0.0573, 9.55e-3]));
        let a_other = &units * &a * units.clone().try_inverse().unwrap() * 1e-3;
        let b_other = &units * &b * 1e-6;
        let (one, other) = (
            controllability(&a, &b).unwrap(),
            controllability(&a_other, &b_other).unwrap(),
        );
        assert_eq!(one.rank, other.rank);
        // Balancing works with powers of two, so it is not quite unique.
        let ratio = one.condition / other.condition;
        assert!((0.25..4.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn observability_is_the_dual() {
        let a = thesis::a();
        let c = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let direct = observability_matrix(&a, &c);
        assert_eq!(direct.shape(), (6, 3));
        assert_eq!(direct.rows(0, 2), c);
        assert_eq!(direct.rows(4, 2), &c * &a * &a);
    }
}
