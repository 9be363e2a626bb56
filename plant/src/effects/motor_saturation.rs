//! The torque of the motor flattens at large current.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// torque = τ i / √(1 + (i/i_s)²)
#[derive(Clone, Copy, Debug)]
pub struct MotorSaturation;

impl Effect for MotorSaturation {
    const INFO: EffectInfo = EffectInfo {
        name: "motor-saturation",
        equation: "torque = τ i / √(1 + (i/i_s)²)",
        meaning: "the iron of the motor saturates",
        source: "saturation of the iron: Hanselman, Brushless Permanent Magnet Motor Design (2003), ch. 2; the shape of the knee is a choice",
        fingerprint: "twice the current gives less than twice the acceleration of the wheel",
        prior: Prior { commonness: Commonness::Rare, reason: "it takes currents near the motor's peak" },
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
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        hiding: Some(Hiding {
            // To lowest order the torque is reduced by the share (i/i_s)²/2; i_s scales with the currents of the bench.
            parameters: |s, bench| vec![bench.top_current_a / s.sqrt()],
            first_guess: 0.05,
            beyond_plausible: true,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S],
        current_a: S,
        _at: &Instant<S>,
        _torque_constant: S,
    ) -> S {
        let ratio = current_a / p[0];
        current_a / (ratio * ratio + 1.0).sqrt()
    }
}
