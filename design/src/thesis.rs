//! Numbers of the thesis bench for the tests: matrix 4.4 of "Linear Quadratic Regulation of
//! Reaction Wheel Stabilised Pendulum" (Kassel 2020).

use nalgebra::{DMatrix, Matrix3, Vector3};
use plant::LinearModel;

/// The linear model of matrix 4.4.
pub(crate) fn model() -> LinearModel {
    LinearModel {
        state: Matrix3::new(
            0.0, 1.0, 0.0, 113.116, -2.45364, 0.00808392, -113.116, 2.45364, -0.136792,
        ),
        input: Vector3::new(0.0, -15.4569, 261.555),
    }
}

/// A of matrix 4.4.
pub(crate) fn a() -> DMatrix<f64> {
    crate::matrix::from_matrix3(&model().state)
}

/// B of matrix 4.4.
pub(crate) fn b() -> DMatrix<f64> {
    crate::matrix::from_vector3(&model().input)
}

/// The weights behind the thesis' gains.
pub(crate) fn weights() -> crate::Weights {
    crate::Weights {
        state: Vector3::new(25.0, 0.5, 5e-4),
        current: 1.0,
    }
}

/// Every entry within `relative` of its golden value, given by rows.
pub(crate) fn assert_close(matrix: &DMatrix<f64>, golden: &[f64], relative: f64) {
    assert_eq!(matrix.len(), golden.len());
    for (index, (value, golden)) in matrix.transpose().iter().zip(golden).enumerate() {
        assert!(
            (value - golden).abs() <= relative * golden.abs(),
            "entry {index} is {value:e}, golden {golden:e}"
        );
    }
}
