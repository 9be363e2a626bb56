//! Small currents give no torque.

use crate::effect::{Effect, EffectInfo, Instant, Linearised, MAX_PARAMETERS, ParameterInfo, Role};
use crate::{Kind, Scalar};

/// torque = τ sign(i) max(|i| − d, 0)
#[derive(Clone, Copy, Debug)]
pub struct MotorDeadZone;

impl Effect for MotorDeadZone {
    const INFO: EffectInfo = EffectInfo {
        name: "motor-dead-zone",
        equation: "torque = τ sign(i) max(|i| − d, 0)",
        meaning: "dead band of the drive",
        source: "contract",
        fingerprint: "the acceleration is short by the same amount at every current, and a coasting wheel knows nothing of it",
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "dead_zone",
            unit: "A",
            meaning: "half-width",
            plausible: (1e-3, 0.5),
            bounds: (0.0, 100.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        replaces: &[],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S; MAX_PARAMETERS],
        current_a: S,
        _at: &Instant<S>,
        _torque_constant: S,
    ) -> S {
        let excess = current_a.abs() - p[0];
        if excess.value() < 0.0 {
            S::zero()
        } else if current_a.value() < 0.0 {
            -excess
        } else if current_a.value() > 0.0 {
            excess
        } else {
            S::zero()
        }
    }
}
