//! Numbers of the thesis bench for the tests: matrix 4.4 of "Linear Quadratic Regulation of
//! Reaction Wheel Stabilised Pendulum" (Kassel 2020).

use nalgebra::{DMatrix, Matrix3, RowVector3, Vector3};
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
pub(crate) fn weights() -> crate::lqr::Weights {
    crate::lqr::Weights::OF_THE_THESIS
}

/// Asserts that every entry lies within `relative` of its golden value; the golden values are given by rows.
pub(crate) fn assert_close(matrix: &DMatrix<f64>, golden: &[f64], relative: f64) {
    assert_eq!(matrix.len(), golden.len());
    for (index, (value, golden)) in matrix.transpose().iter().zip(golden).enumerate() {
        assert!(
            (value - golden).abs() <= relative * golden.abs(),
            "entry {index} is {value:e}, golden {golden:e}"
        );
    }
}

/// The golden discrete gains at 1 ms.
pub(crate) fn golden_gains() -> RowVector3<f64> {
    RowVector3::new(-24.2672423, -2.12973867, -0.0225875821)
}

/// The golden gains as a 1×3 matrix.
pub(crate) fn gains() -> DMatrix<f64> {
    DMatrix::from_row_slice(1, 3, golden_gains().as_slice())
}

/// The linear model of the equations of motion, for tests that vary parameters:
/// (Θ, j_w, G, τ, r_b + μ/ι, r_w).
pub(crate) fn model_of(parameters: [f64; 6]) -> LinearModel {
    let [
        inertia,
        wheel,
        gravity,
        torque,
        body_friction,
        wheel_friction,
    ] = parameters;
    let d = inertia - wheel;
    LinearModel {
        state: Matrix3::new(
            0.0,
            1.0,
            0.0,
            gravity / d,
            -body_friction / d,
            wheel_friction / d,
            -gravity / d,
            body_friction / d,
            -inertia * wheel_friction / (wheel * d),
        ),
        input: Vector3::new(0.0, -torque / d, inertia * torque / (wheel * d)),
    }
}

/// The parameters behind matrix 4.4, in the order of [`model_of`].
pub(crate) const PARAMETERS: [f64; 6] = [
    2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 5.31781e-3, 1.75204e-5,
];
