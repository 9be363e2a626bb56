//! The current comes later than its command.

use crate::effect::{Effect, EffectInfo, Linearised, MAX_PARAMETERS, ParameterInfo, Role};
use crate::{Kind, Scalar};

/// i(t) = u(t − δ)
#[derive(Clone, Copy, Debug)]
pub struct InputDelay;

impl Effect for InputDelay {
    const INFO: EffectInfo = EffectInfo {
        name: "input-delay",
        equation: "i(t) = u(t − δ)",
        meaning: "computing time, bus and PWM period",
        source: "contract",
        fingerprint: "while balancing, the response to the command is shifted in time; the loop rings",
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "input_delay",
            unit: "s",
            meaning: "delay δ",
            plausible: (2e-4, 0.05),
            bounds: (0.0, 1.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-3], &[1e-2]],
        absent: Some(&[0.0]),
        replaces: &[],
        shows_in: &[Kind::Balance, Kind::Driven, Kind::SpinUp],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S; MAX_PARAMETERS]) -> Option<S> {
        Some(p[0])
    }
}
