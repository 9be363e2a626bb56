//! Singular values by one-sided Jacobi rotations.
//!
//! Pairs of columns are rotated until all are orthogonal; their norms are then the singular values
//! (M. Hestenes, J. SIAM 6(1), 1958). The method computes small singular values with full relative
//! accuracy (J. Demmel, K. Veselić, SIAM J. Matrix Anal. Appl. 13(4), 1992), which matters for ranks.
//! nalgebra's own decomposition is not used: it occasionally returns factors whose product is not
//! the matrix (dimforge/nalgebra issue 1172), most often for singular matrices, which
//! matter most here.

use nalgebra::{Complex, DMatrix};

/// The singular values of any matrix, the largest first; their number is its smaller dimension.
pub fn singular_values(matrix: &DMatrix<f64>) -> Vec<f64> {
    let mut work = if matrix.nrows() < matrix.ncols() {
        matrix.transpose()
    } else {
        matrix.clone()
    };
    let columns = work.ncols();
    // Convergence is quadratic; usually, about ten sweeps are enough.
    const MOST_SWEEPS: usize = 60;
    for _ in 0..MOST_SWEEPS {
        let mut rotated = false;
        for left in 0..columns {
            for right in left + 1..columns {
                let a = work.column(left).norm_squared();
                let b = work.column(right).norm_squared();
                let c = work.column(left).dot(&work.column(right));
                if c == 0.0 || c.abs() <= f64::EPSILON * (a * b).sqrt() {
                    continue;
                }
                rotated = true;
                let zeta = (b - a) / (2.0 * c);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                let sine = cosine * tangent;
                for row in 0..work.nrows() {
                    let (x, y) = (work[(row, left)], work[(row, right)]);
                    work[(row, left)] = cosine * x - sine * y;
                    work[(row, right)] = sine * x + cosine * y;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    let mut values: Vec<f64> = work.column_iter().map(|column| column.norm()).collect();
    values.sort_by(|left, right| right.total_cmp(left));
    values
}

/// Smallest singular value of a complex matrix X + iY, which is that of [[X, −Y], [Y, X]].
pub(crate) fn smallest_of_complex(matrix: &DMatrix<Complex<f64>>) -> f64 {
    let (rows, columns) = matrix.shape();
    let real = DMatrix::from_fn(2 * rows, 2 * columns, |row, column| {
        let entry = matrix[(row % rows, column % columns)];
        match (row < rows, column < columns) {
            (true, true) | (false, false) => entry.re,
            (true, false) => -entry.im,
            (false, true) => entry.im,
        }
    });
    singular_values(&real).last().copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The invariants that define them: traces of (MᵀM) and of its square, the determinant.
        #[test]
        fn traces_and_determinant_agree(entries in prop::collection::vec(-1.0..1.0_f64, 9)) {
            let matrix = DMatrix::from_row_slice(3, 3, &entries);
            let values = singular_values(&matrix);
            let gram = matrix.transpose() * &matrix;
            let sum = |power: i32| values.iter().map(|value| value.powi(power)).sum::<f64>();
            prop_assert!((sum(2) - gram.trace()).abs() < 1e-13);
            prop_assert!((sum(4) - (&gram * &gram).trace()).abs() < 1e-12);
            let product: f64 = values.iter().product();
            prop_assert!((product - matrix.determinant().abs()).abs() < 1e-14);
        }

        #[test]
        fn a_dependent_column_gives_a_zero(entries in prop::collection::vec(-1.0..1.0_f64, 6)) {
            let mut matrix = DMatrix::from_column_slice(3, 2, &entries).insert_column(2, 0.0);
            let sum = matrix.column(0) + matrix.column(1);
            matrix.set_column(2, &sum);
            let values = singular_values(&matrix);
            prop_assert!(values[2] < 1e-15 * 10.0);
            let wide = singular_values(&matrix.rows(0, 2).into_owned());
            prop_assert_eq!(wide.len(), 2);
        }
    }

    #[test]
    fn graded_values_are_found_to_full_relative_accuracy() {
        // A rotation of a diagonal with 20 orders of magnitude between its entries.
        let (sine, cosine) = 0.7_f64.sin_cos();
        let rotation = DMatrix::from_row_slice(2, 2, &[cosine, -sine, sine, cosine]);
        let graded = rotation * DMatrix::from_diagonal(&nalgebra::dvector![1e-20, 3.0]);
        let values = singular_values(&graded);
        assert!((values[0] - 3.0).abs() < 1e-15 * 3.0);
        assert!((values[1] - 1e-20).abs() < 1e-35);
    }

    #[test]
    fn complex_matrices() {
        let i = Complex::new(0.0, 1.0);
        let one = Complex::new(1.0, 0.0);
        let unitary_twice = DMatrix::from_row_slice(2, 2, &[one, i, i, one]) * (2.0 * one);
        // [[1, i], [i, 1]] is √2 times a unitary matrix.
        assert!((smallest_of_complex(&unitary_twice) - 8.0_f64.sqrt()).abs() < 1e-14);
        let singular = DMatrix::from_row_slice(2, 2, &[one, i, i, -one]);
        assert!(smallest_of_complex(&singular) < 1e-15);
    }
}
