//! Matrices and vectors of order three, in exact rational numbers.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

/// A square matrix of order three.
pub type Matrix = [[BigRational; 3]; 3];

/// A vector of length three.
pub type Vector = [BigRational; 3];

/// a · b.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| &a[i][k] * &b[k][j]).sum()))
}

/// m · v.
pub fn apply(m: &Matrix, v: &Vector) -> Vector {
    [0, 1, 2].map(|i| dot(&m[i], v))
}

/// a · b.
pub fn dot(a: &Vector, b: &Vector) -> BigRational {
    (0..3).map(|k| &a[k] * &b[k]).sum()
}

/// mᵀ.
pub fn transposed(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| m[j][i].clone()))
}

/// det m.
pub fn determinant(m: &Matrix) -> BigRational {
    let minor = |i: usize, j: usize| &m[1][i] * &m[2][j] - &m[1][j] * &m[2][i];
    &m[0][0] * minor(1, 2) - &m[0][1] * minor(0, 2) + &m[0][2] * minor(0, 1)
}

/// m⁻¹; `None` if m is singular.
pub fn inverse(m: &Matrix) -> Option<Matrix> {
    let determinant = determinant(m);
    if determinant.is_zero() {
        return None;
    }
    // Entry (i, j) of the inverse is the cofactor of (j, i) over the determinant.
    let cofactor = |i: usize, j: usize| {
        let rows = [(i + 1) % 3, (i + 2) % 3];
        let columns = [(j + 1) % 3, (j + 2) % 3];
        &m[rows[0]][columns[0]] * &m[rows[1]][columns[1]]
            - &m[rows[0]][columns[1]] * &m[rows[1]][columns[0]]
    };
    Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| cofactor(j, i) / &determinant)))
}

/// Whether a symmetric m is positive definite (Sylvester's criterion).
pub fn is_positive_definite(m: &Matrix) -> bool {
    let second = &m[0][0] * &m[1][1] - &m[0][1] * &m[1][0];
    m[0][0].is_positive() && second.is_positive() && determinant(m).is_positive()
}

/// vᵀ m v.
pub fn quadratic(m: &Matrix, v: &Vector) -> BigRational {
    dot(v, &apply(m, v))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact::rational::{decimal, integer};

    fn d(text: &str) -> BigRational {
        decimal(text).unwrap()
    }

    #[test]
    fn matrices() {
        let m = [["2", "1", "0"], ["1", "3", "-1"], ["0", "-1", "1.5"]].map(|row| row.map(d));
        let identity = product(&m, &inverse(&m).unwrap());
        for (i, row) in identity.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert_eq!(*entry, integer(i128::from(i == j)));
            }
        }
        assert_eq!(determinant(&m), d("5.5"));
        assert!(is_positive_definite(&m));
        let mut indefinite = m.clone();
        indefinite[2][2] = d("0.1");
        assert!(!is_positive_definite(&indefinite));
        assert_eq!(quadratic(&m, &[d("1"), d("1"), d("1")]), d("6.5"));
    }
}
