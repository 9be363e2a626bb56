//! The continuous algebraic Riccati equation, solved by the matrix sign function.
//!
//! ```text
//! AᵀX + XA − X B R⁻¹Bᵀ X + Q = 0,   K = R⁻¹BᵀX
//! ```
//!
//! The stable subspace of the Hamiltonian H = [[A, −BR⁻¹Bᵀ], [−Q, −Aᵀ]] is the kernel of
//! sign(H) + I and spanned by [I; X]. sign(H) is the limit of Newton's Zₖ₊₁ = (cZₖ + (cZₖ)⁻¹)/2
//! with c = |det Zₖ|^(−1/2n) (J. Roberts, Int. J. Control 32(4), 1980; R. Byers, Linear Algebra
//! Appl. 85, 1987). The loop of the bench is sampled; this solution is for comparison with continuous
//! designs.

use crate::error::DesignError;
use crate::matrix::{check_finite, check_shape, smallest_scaled_eigenvalue, symmetric};
use nalgebra::DMatrix;

/// Largest relative residual that is accepted, as for the discrete equation.
const ALLOWED_RESIDUAL: f64 = 1e-9;

const MOST_STEPS: usize = 100;

/// A solution of the equation, with its residual.
#[derive(Clone, Debug, PartialEq)]
pub struct CareSolution {
    /// X (n×n), symmetric; the matrix of the cost to go.
    pub cost_to_go: DMatrix<f64>,
    /// K (m×n), the law u = −K x.
    pub gain: DMatrix<f64>,
    /// Frobenius norm of the equation's residual, divided by that of its largest term.
    pub residual: f64,
}

/// The stabilising solution for ẋ = A x + B u (A n×n, B n×m), weights Q (n×n) and R (m×m).
///
/// # Errors
/// [`DesignError::IndefiniteWeights`]; [`DesignError::NoConvergence`] if the Hamiltonian has
/// eigenvalues on the imaginary axis (not stabilisable, or a mode that does not enter the cost);
/// [`DesignError::InaccurateSolution`]; wrong shapes, and entries that are not finite.
pub fn solve_care(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    q: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<CareSolution, DesignError> {
    let (n, m) = (a.nrows(), b.ncols());
    check_shape("the state matrix A", a, n, n)?;
    check_shape("the input matrix B", b, n, m)?;
    check_shape("the state weight Q", q, n, n)?;
    check_shape("the current weight R", r, m, m)?;
    for (what, matrix) in [
        ("the state matrix A", a),
        ("the input matrix B", b),
        ("the state weight Q", q),
        ("the current weight R", r),
    ] {
        check_finite(what, matrix)?;
    }
    for (what, weight, least) in [
        ("the current weight must be greater than zero", r, 1e-13),
        ("the state weight must not be negative", q, -1e-13),
    ] {
        let smallest_eigenvalue = smallest_scaled_eigenvalue(weight);
        if smallest_eigenvalue < least * weight.nrows() as f64 {
            return Err(DesignError::IndefiniteWeights {
                what,
                smallest_eigenvalue,
            });
        }
    }
    let weighted = r
        .clone()
        .lu()
        .solve(&b.transpose())
        .ok_or(DesignError::Singular {
            what: "the current weight R",
            cure: "give the current a weight greater than zero",
        })?;
    let reach = symmetric(&(b * &weighted));

    let sign = sign_of_hamiltonian(a, &reach, q)?;
    // [W₁₂; W₂₂ + I] X = −[W₁₁ + I; W₂₁] is a consistent system of 2n rows.
    let identity = DMatrix::<f64>::identity(n, n);
    let mut left = DMatrix::zeros(2 * n, n);
    left.view_mut((0, 0), (n, n))
        .copy_from(&sign.view((0, n), (n, n)));
    left.view_mut((n, 0), (n, n))
        .copy_from(&(sign.view((n, n), (n, n)) + &identity));
    let mut right = DMatrix::zeros(2 * n, n);
    right
        .view_mut((0, 0), (n, n))
        .copy_from(&-(sign.view((0, 0), (n, n)) + &identity));
    right
        .view_mut((n, 0), (n, n))
        .copy_from(&-sign.view((n, 0), (n, n)));
    let (orthogonal, triangle) = left.qr().unpack();
    let cost_to_go = triangle
        .solve_upper_triangular(&(orthogonal.transpose() * right))
        .map(|x| symmetric(&x))
        .ok_or_else(|| no_convergence(f64::NAN))?;

    let linear = a.transpose() * &cost_to_go;
    let quadratic = &cost_to_go * &reach * &cost_to_go;
    let largest = [&linear, &quadratic, q]
        .iter()
        .map(|term| term.norm())
        .fold(0.0, f64::max);
    let residual = (&linear + linear.transpose() - quadratic + q).norm();
    let residual = if largest > 0.0 {
        residual / largest
    } else {
        0.0
    };
    if residual.is_nan() || residual > ALLOWED_RESIDUAL {
        return Err(DesignError::InaccurateSolution {
            equation: "continuous Riccati equation",
            residual,
            allowed: ALLOWED_RESIDUAL,
        });
    }
    Ok(CareSolution {
        gain: weighted * &cost_to_go,
        cost_to_go,
        residual,
    })
}

fn no_convergence(change: f64) -> DesignError {
    DesignError::NoConvergence {
        method: "the sign iteration",
        iterations: MOST_STEPS,
        change,
        cure: "the motor does not reach an unstable mode, or a state weight of zero excludes one from the cost",
    }
}

/// sign([[A, −G], [−Q, −Aᵀ]]).
fn sign_of_hamiltonian(
    a: &DMatrix<f64>,
    g: &DMatrix<f64>,
    q: &DMatrix<f64>,
) -> Result<DMatrix<f64>, DesignError> {
    let n = a.nrows();
    let mut z = DMatrix::zeros(2 * n, 2 * n);
    z.view_mut((0, 0), (n, n)).copy_from(a);
    z.view_mut((0, n), (n, n)).copy_from(&(-g));
    z.view_mut((n, 0), (n, n)).copy_from(&(-q));
    z.view_mut((n, n), (n, n)).copy_from(&(-a.transpose()));
    let mut change = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let factors = z.clone().lu();
        let determinant = factors.determinant().abs();
        let Some(inverse) = factors.try_inverse() else {
            break;
        };
        if !determinant.is_normal() {
            break;
        }
        // Scaling speeds up the first steps, and would disturb the last ones.
        let scale = if change > 1e-2 {
            determinant.powf(-0.5 / n as f64)
        } else {
            1.0
        };
        let next = (&z * scale + inverse / scale) * 0.5;
        change = (&next - &z).norm() / next.norm();
        z = next;
        if !change.is_finite() {
            break;
        }
        if change < 1e-14 * n as f64 {
            return Ok(z);
        }
    }
    Err(no_convergence(change))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;
    use nalgebra::DVector;

    #[test]
    fn thesis_bench() {
        let q = DMatrix::from_diagonal(&DVector::from_column_slice(&[25.0, 0.5, 5e-4]));
        let solution = solve_care(
            &thesis::a(),
            &thesis::b(),
            &q,
            &DMatrix::from_element(1, 1, 1.0),
        )
        .unwrap();
        thesis::assert_close(
            &solution.gain,
            &[-24.4787016, -2.14922301, -0.0228897984],
            3e-9,
        );
        assert!(solution.residual < 1e-12, "{:e}", solution.residual);
    }

    #[test]
    fn scalar_case_in_closed_form() {
        // ẋ = x + u, q = r = 1: X² − 2X − 1 = 0, so X = 1 + √2.
        let one = DMatrix::from_element(1, 1, 1.0);
        let solution = solve_care(&one, &one, &one, &one).unwrap();
        assert!((solution.cost_to_go[0] - 1.0 - 2.0_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn a_mode_that_nothing_moves_does_not_converge() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, 0.0, -1.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        let result = solve_care(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1));
        assert!(result.is_err(), "{result:?}");
    }
}
