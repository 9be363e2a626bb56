//! The torque of the motor flattens at large current.

use crate::effect::{Effect, EffectInfo, Instant, Linearised, MAX_PARAMETERS, ParameterInfo, Role};
use crate::{Kind, Scalar};

/// torque = τ i / √(1 + (i/i_s)²)
#[derive(Clone, Copy, Debug)]
pub struct MotorSaturation;

impl Effect for MotorSaturation {
    const INFO: EffectInfo = EffectInfo {
        name: "motor-saturation",
        equation: "torque = τ i / √(1 + (i/i_s)²)",
        meaning: "the iron of the motor saturates",
        source: "contract",
        fingerprint: "twice the current gives less than twice the acceleration of the wheel",
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "saturation_current",
            unit: "A",
            meaning: "current at which the torque has fallen to 1/√2 of τ i",
            plausible: (0.3, 20.0),
            bounds: (0.01, 1e4),
            is_torque: false,
            logarithmic: true,
            is_whole: false,
        }],
        starts: &[&[10.0], &[2.0]],
        absent: Some(&[1e9]),
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
        let ratio = current_a / p[0];
        current_a / (ratio * ratio + 1.0).sqrt()
    }
}
