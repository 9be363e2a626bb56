//! The ratios of the base parameters that enter the equations of motion linearly.

use nalgebra::DVector;

/// Ratios of the parameters that follow directly from the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratios {
    /// G/Θ in 1/s²: from free swings; otherwise from the momentum of body and wheel in logs with everything free.
    pub gravity_over_total: Option<f64>,
    /// The angle in rad that the sensor shows while the body hangs, from free swings.
    pub angle_zero_rad: Option<f64>,
    /// r_b/Θ in 1/s, from the same logs as G/Θ.
    pub friction_over_total: Option<f64>,
    /// G/(Θ − j_w) in 1/s², from logs with everything free.
    pub gravity_over_free: Option<f64>,
    /// τ/(Θ − j_w) in rad/(s² A), from logs with everything free.
    pub torque_over_free: Option<f64>,
    /// G/j_w in 1/s², from the momentum of body and wheel in balance logs.
    pub gravity_over_wheel: Option<f64>,
    /// τ/j_w in rad/(s² A).
    pub torque_over_wheel: Option<f64>,
    /// r_w/j_w in 1/s.
    pub friction_over_wheel: Option<f64>,
}

pub(super) fn positive(value: f64) -> Option<f64> {
    (value.is_finite() && value > 0.0).then_some(value)
}

impl Ratios {
    /// Collects the ratios from three solutions: wheel locked, everything free, wheel driven.
    pub(super) fn of_solutions(
        locked: Option<DVector<f64>>,
        free: Option<DVector<f64>>,
        wheel: Option<DVector<f64>>,
    ) -> Ratios {
        let mut ratios = Ratios::default();
        if let Some(solution) = locked {
            // A shifted zero of the angle splits G/Θ into a sine and a cosine part.
            ratios.gravity_over_total = positive(solution[0].hypot(solution[1]));
            ratios.angle_zero_rad = Some((-solution[1]).atan2(solution[0]));
            ratios.friction_over_total = positive(solution[2]);
        }
        if let Some(solution) = free {
            ratios.gravity_over_free = positive(solution[0].hypot(solution[1]));
            ratios.torque_over_free = positive(solution[3]);
        }
        if let Some(solution) = wheel {
            ratios.torque_over_wheel = positive(solution[0]);
            ratios.friction_over_wheel = positive(solution[1]);
        }
        ratios
    }

    /// These ratios; those that are missing are taken from `others`.
    pub(super) fn or(self, others: Ratios) -> Ratios {
        let zero = self.angle_zero_rad;
        Ratios {
            gravity_over_total: self.gravity_over_total.or(others.gravity_over_total),
            angle_zero_rad: zero.or(others.angle_zero_rad),
            friction_over_total: self.friction_over_total.or(others.friction_over_total),
            gravity_over_free: self.gravity_over_free.or(others.gravity_over_free),
            torque_over_free: self.torque_over_free.or(others.torque_over_free),
            gravity_over_wheel: self.gravity_over_wheel.or(others.gravity_over_wheel),
            torque_over_wheel: self.torque_over_wheel.or(others.torque_over_wheel),
            friction_over_wheel: self.friction_over_wheel.or(others.friction_over_wheel),
        }
    }
}
