//! The model linearised about an equilibrium.

use nalgebra::{Matrix3, Vector3};

/// Continuous-time linear model ẋ = A x + B u about the upright equilibrium,
/// x = (α − π in rad, α̇ in rad/s, φ̇ in rad/s), u the motor current in A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearModel {
    /// State matrix A (3×3), units of row over column per second.
    pub state: Matrix3<f64>,
    /// Input matrix B (3×1), units of row per ampere and second.
    pub input: Vector3<f64>,
}
