//! The largest angle from which the motor can bring the body back.
//!
//! Two limits come from physics, not from control. The **current limit**: at the angle θ from upright,
//! gravity acts with G sin θ and the motor with at most τ u_max. A body at rest beyond
//! asin(τ u_max / G) therefore falls with any law. The **speed limit**: while gravity acts, the wheel
//! must take up momentum, and it can take up only j_w (φ̇_max − φ̇); [`crate::wheel_sizing`] computes
//! the angle that this allows.

use crate::error::DesignError;
use crate::matrix::{check_positive, of_model};
use plant::LinearModel;

/// The static torque balance at the current limit: θ = asin(τ u_max / G), in rad; π/2 if the
/// motor is stronger than gravity at every angle.
///
/// τ/G follows from the linear model: B₂ = −τ/D and A₂₁ = G/D.
///
/// # Errors
/// If the current limit is not positive; [`DesignError::NotAPendulum`] without gravity or motor.
pub fn recovery_angle_rad(model: &LinearModel, current_limit_a: f64) -> Result<f64, DesignError> {
    of_model(model)?;
    check_positive("the current limit in A", current_limit_a)?;
    let gravity = model.state[(1, 0)];
    let motor = model.input[1].abs();
    if gravity <= 0.0 {
        return Err(DesignError::NotAPendulum {
            what: "the recovery angle",
            why: "gravity does not pull the body over (row 2, column 1 of A must be positive)",
        });
    }
    if motor == 0.0 {
        return Err(DesignError::NotAPendulum {
            what: "the recovery angle",
            why: "the motor does not act on the body (row 2 of B is zero)",
        });
    }
    Ok((motor * current_limit_a / gravity).min(1.0).asin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thesis;

    #[test]
    fn thesis_bench_at_two_amperes() {
        let angle = recovery_angle_rad(&thesis::model(), 2.0).unwrap();
        // asin(2 τ/G) with τ = 0.0335 N m/A and G = 0.245158 N m.
        assert!((angle.to_degrees() - 15.86).abs() < 0.005);
        assert!((angle - (2.0_f64 * 0.0335 / 0.245158).asin()).abs() < 1e-5);
    }

    #[test]
    fn a_strong_motor_recovers_from_anywhere() {
        let angle = recovery_angle_rad(&thesis::model(), 50.0).unwrap();
        assert_eq!(angle, std::f64::consts::FRAC_PI_2);
    }

    #[test]
    fn a_hanging_body_has_no_recovery_angle() {
        let mut hanging = thesis::model();
        hanging.state[(1, 0)] *= -1.0;
        assert!(matches!(
            recovery_angle_rad(&hanging, 2.0),
            Err(DesignError::NotAPendulum { .. })
        ));
        assert!(recovery_angle_rad(&thesis::model(), -2.0).is_err());
    }
}
