//! The model linearised about an equilibrium.

use nalgebra::{Matrix3, Vector3};

use crate::model::{GRAVITY_TORQUE, TOTAL_INERTIA, WHEEL_INERTIA};
use crate::{
    Dual, EffectId, Kind, LearnedCoordinate, Linearised, Model, Plant, Scalar, Smoothing, State,
};

/// Continuous-time linear model ẋ = A x + B u about the upright equilibrium,
/// x = (α − π in rad, α̇ in rad/s, φ̇ in rad/s), u the motor current in A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearModel {
    /// State matrix A (3×3), units of row over column per second.
    pub state: Matrix3<f64>,
    /// Input matrix B (3×1), units of row per ampere and second.
    pub input: Vector3<f64>,
}

/// The reason why a model has no linear model at the requested equilibrium.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinearisationError {
    /// Θ, j_w or Θ − j_w is not positive.
    #[error(
        "total_inertia = {total} kg m2 and wheel_inertia = {wheel} kg m2 are not possible together; \
         0 < wheel_inertia < total_inertia is needed"
    )]
    Inertia {
        /// Θ in kg m².
        total: f64,
        /// j_w in kg m².
        wheel: f64,
    },
    /// There is no equilibrium of the body near the requested angle.
    #[error(
        "the body has no equilibrium near {near_rad} rad; check the parameters of its torques, such as gravity and \
         springs"
    )]
    NoEquilibrium {
        /// Where the search started, rad.
        near_rad: f64,
    },
}

/// The linear model about the equilibrium nearest to `near_rad` (π for upright, 0 for hanging), with both
/// speeds zero and no current: the exact Jacobian of [`Plant::derivative`].
///
/// Dry friction of the body enters as μ tanh(α̇/ι), hence with slope μ/ι, where
/// `friction_speed_rad_s` gives ι; without it, dry friction is left out. Effects that the linear
/// model cannot carry are left out ([`Linearised::LeftOut`]), and so are learned torques that no log has shown there
/// ([`has_seen`]).
///
/// # Errors
/// If the inertias are not physical, or there is no equilibrium within half a radian.
pub fn linearise(
    model: &Model,
    values: &[f64],
    near_rad: f64,
    friction_speed_rad_s: Option<f64>,
) -> Result<LinearModel, LinearisationError> {
    let (total, wheel) = (values[TOTAL_INERTIA], values[WHEEL_INERTIA]);
    if !(wheel > 0.0 && total > wheel && total.is_finite()) {
        return Err(LinearisationError::Inertia { total, wheel });
    }
    let (model, values) = kept(model, values, near_rad, friction_speed_rad_s.is_some());
    let smoothing = Smoothing {
        body_rad_s: friction_speed_rad_s.unwrap_or(Smoothing::SIMULATION.body_rad_s),
        ..Smoothing::SIMULATION
    };
    let constants: Vec<Dual<4>> = values.iter().map(|&value| Dual::constant(value)).collect();
    let plant = Plant::smoothed(&model, &constants, Kind::Balance, smoothing);
    let jacobian_at = |angle: f64| {
        let state = State {
            angle_rad: Dual::<4>::variable(angle, 0),
            rate_rad_s: Dual::variable(0.0, 1),
            wheel_speed_rad_s: Dual::variable(0.0, 2),
            ..State::rest()
        };
        plant.derivative(&state, Dual::variable(0.0, 3), 0.0)
    };
    // Newton's method for α̈ = 0; the torques are smooth in the angle.
    let mut angle = near_rad;
    let scale = values[GRAVITY_TORQUE] / (total - wheel);
    for _ in 0..50 {
        let (rate_dot, _) = jacobian_at(angle);
        let step = rate_dot.value / rate_dot.derivatives[0];
        angle -= step;
        if !angle.is_finite() || (angle - near_rad).abs() > 0.5 {
            return Err(LinearisationError::NoEquilibrium { near_rad });
        }
        if step.abs() < 1e-14 {
            break;
        }
    }
    let (rate_dot, wheel_dot) = jacobian_at(angle);
    if rate_dot.value.abs() > 1e-9 * scale.abs() {
        return Err(LinearisationError::NoEquilibrium { near_rad });
    }
    let (r, w) = (rate_dot.derivatives, wheel_dot.derivatives);
    Ok(LinearModel {
        state: Matrix3::new(0.0, 1.0, 0.0, r[0], r[1], r[2], w[0], w[1], w[2]),
        input: Vector3::new(0.0, r[3], w[3]),
    })
}

/// The input matrices (3×1, units of row per N m and second) of a torque on the body, and of a torque on the wheel with
/// its reaction on the body. `values` as in [`linearise`].
pub fn torque_inputs(model: &Model, values: &[f64]) -> [Vector3<f64>; 2] {
    let plant = Plant::new(model, values, Kind::Balance);
    let rest = State::rest();
    let ([rate, wheel], [pushed_rate, pushed_wheel]) = (
        <[f64; 2]>::from(plant.derivative(&rest, 0.0, 0.0)),
        <[f64; 2]>::from(plant.derivative(&rest, 0.0, 1.0)),
    );
    let body = Vector3::new(0.0, pushed_rate - rate, pushed_wheel - wheel);
    [
        body,
        Vector3::new(0.0, 0.0, 1.0 / values[WHEEL_INERTIA]) - body,
    ]
}

/// Whether the logs have shown a learned torque where the model is linearised: at the angle `near_rad`, or at rate and
/// speed zero. True for every effect with an equation, which holds everywhere.
pub fn has_seen(effect: EffectId, near_rad: f64) -> bool {
    effect.info().learned.is_none_or(|curve| {
        curve.has_seen(match curve.coordinate {
            LearnedCoordinate::Angle => near_rad,
            _ => 0.0,
        })
    })
}

/// The part of a model that its linear model carries, with the parameters that belong to it.
fn kept(
    model: &Model,
    values: &[f64],
    near_rad: f64,
    keep_dry_friction: bool,
) -> (Model, Vec<f64>) {
    let mut effects = vec![];
    for &effect in model.effects() {
        let info = effect.info();
        match info.linearised {
            // A learned torque that no log has shown there counts as zero.
            Linearised::Exactly if !has_seen(effect, near_rad) => {}
            Linearised::Exactly => effects.push(effect),
            Linearised::AsDryFriction if keep_dry_friction => {
                // A refinement is represented by the friction that it refines, with which it shares a parameter.
                let simpler = info
                    .replaces
                    .iter()
                    .find_map(|name| EffectId::from_name(name));
                effects.push(simpler.unwrap_or(effect));
            }
            Linearised::AsDryFriction | Linearised::LeftOut => {}
        }
    }
    let kept = Model::with_effects(&effects);
    let infos = kept.parameters();
    let of_whole = |name: &str| model.position_of(name).map_or(0.0, |at| values[at]);
    let values = infos.iter().map(|info| of_whole(info.name)).collect();
    (kept, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parameter set behind matrix 4.4 of the thesis, with r_b such that
    /// r_b + μ/ι = 5.31781e-3 N m s/rad.
    const IOTA_RAD_S: f64 = 0.0846768;
    const MU: f64 = 4.485e-4;

    fn thesis() -> (Model, Vec<f64>) {
        let model = Model::base().with(EffectId::BodyCoulombFriction);
        let values = vec![
            2.30344e-3,
            1.36125e-4,
            0.245158,
            0.0335,
            5.31781e-3 - MU / IOTA_RAD_S,
            1.75204e-5,
            MU,
        ];
        (model, values)
    }

    #[test]
    fn matrix_4_4_of_the_thesis() {
        let (model, values) = thesis();
        let linear =
            linearise(&model, &values, std::f64::consts::PI, Some(IOTA_RAD_S)).expect("upright");
        let expected = Matrix3::new(
            0.0, 1.0, 0.0, 113.116, -2.45364, 0.00808392, -113.116, 2.45364, -0.136792,
        );
        for (ours, thesis) in linear.state.iter().zip(expected.iter()) {
            assert!(
                (ours - thesis).abs() <= 1e-5 * thesis.abs(),
                "{ours} {thesis}"
            );
        }
        for (ours, thesis) in linear.input.iter().zip([0.0, -15.4569, 261.555]) {
            assert!(
                (ours - thesis).abs() <= 1e-5 * f64::abs(thesis),
                "{ours} {thesis}"
            );
        }
    }

    #[test]
    fn without_a_friction_speed_dry_friction_is_not_in_the_matrix() {
        let (model, values) = thesis();
        let linear = linearise(&model, &values, std::f64::consts::PI, None).expect("upright");
        let d = values[0] - values[1];
        assert!((linear.state[(1, 1)] + values[4] / d).abs() < 1e-12);
    }

    #[test]
    fn a_cable_moves_the_equilibrium_about_which_the_model_is_linear() {
        let (base, mut values) = thesis();
        let model = base.with(EffectId::BodyCableSpring);
        values.extend([1e-3, 0.0]);
        let linear = linearise(&model, &values, std::f64::consts::PI, None).expect("upright");
        // G sin α + κ α = 0 near π: slope −(G cos α + κ) with sin α = −κ α/G.
        let mut angle = std::f64::consts::PI;
        for _ in 0..50 {
            angle = std::f64::consts::PI + (1e-3 * angle / values[2]).asin();
        }
        let expected = -(values[2] * angle.cos() + 1e-3) / (values[0] - values[1]);
        assert!((linear.state[(1, 0)] - expected).abs() < 1e-9 * expected.abs());
    }

    #[test]
    fn inertias_without_meaning_are_refused() {
        let (model, mut values) = thesis();
        values[1] = values[0];
        assert!(matches!(
            linearise(&model, &values, 0.0, None),
            Err(LinearisationError::Inertia { .. })
        ));
    }
}
