//! Small matrix helpers that the algorithms here share.

use crate::error::DesignError;
use nalgebra::{DMatrix, Matrix3, SymmetricEigen, Vector3};
use plant::LinearModel;

/// The state matrix of `model` as a matrix of any size.
pub(crate) fn from_matrix3(matrix: &Matrix3<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(3, 3, |row, column| matrix[(row, column)])
}

/// A vector as a matrix of one column.
pub(crate) fn from_vector3(vector: &Vector3<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(3, 1, |row, _| vector[row])
}

/// A and B of `model`, checked to be finite.
pub(crate) fn of_model(model: &LinearModel) -> Result<(DMatrix<f64>, DMatrix<f64>), DesignError> {
    let (a, b) = (from_matrix3(&model.state), from_vector3(&model.input));
    check_finite("the state matrix A", &a)?;
    check_finite("the input matrix B", &b)?;
    Ok((a, b))
}

/// Errors where an entry is NaN or infinite.
pub(crate) fn check_finite(what: &'static str, matrix: &DMatrix<f64>) -> Result<(), DesignError> {
    if matrix.iter().all(|entry| entry.is_finite()) {
        Ok(())
    } else {
        Err(DesignError::NotFinite { what })
    }
}

/// Errors where the shape differs from `rows` × `columns`.
pub(crate) fn check_shape(
    what: &'static str,
    matrix: &DMatrix<f64>,
    rows: usize,
    columns: usize,
) -> Result<(), DesignError> {
    if matrix.shape() == (rows, columns) {
        Ok(())
    } else {
        Err(DesignError::WrongShape {
            what,
            rows: matrix.nrows(),
            columns: matrix.ncols(),
            expected_rows: rows,
            expected_columns: columns,
        })
    }
}

/// Errors unless `value` is finite and greater than zero.
pub(crate) fn check_positive(what: &'static str, value: f64) -> Result<(), DesignError> {
    if !value.is_finite() {
        Err(DesignError::NotFinite { what })
    } else if value <= 0.0 {
        Err(DesignError::NotPositive { what, value })
    } else {
        Ok(())
    }
}

/// The symmetric part (M + Mᵀ)/2.
pub(crate) fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}

/// Smallest eigenvalue of a symmetric matrix after scaling its rows and columns to a unit
/// diagonal. The scaling keeps the signs of the eigenvalues (Sylvester's law of inertia) and removes the
/// units, so that weights of 25 and 5e-4 are treated alike.
pub(crate) fn smallest_scaled_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    let scale = matrix.diagonal().map(|entry| {
        if entry == 0.0 {
            1.0
        } else {
            1.0 / entry.abs().sqrt()
        }
    });
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        scale[row] * 0.5 * (matrix[(row, column)] + matrix[(column, row)]) * scale[column]
    });
    SymmetricEigen::new(scaled).eigenvalues.min()
}
