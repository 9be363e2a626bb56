//! The current comes later than its command.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, ParameterInfo, Role, Timing};
use crate::hiding::Hiding;
use crate::physical::PhysicalRange;
use crate::{Kind, Scalar};

/// i(t) = u(t − δ)
#[derive(Clone, Copy, Debug)]
pub struct InputDelay;

impl Effect for InputDelay {
    const INFO: EffectInfo = EffectInfo {
        name: "input-delay",
        equation: "i(t) = u(t − δ)",
        meaning: "computing time, bus and PWM period",
        source: "Åström & Wittenmark, Computer-Controlled Systems (3rd ed. 1997), ch. 2, systems with time delay",
        fingerprint: "while balancing, the response to the command is shifted in time; the loop rings",
        prior: Prior { commonness: Commonness::Occasional, reason: "a bus or a slow loop between command and drive" },
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
        physical: &[PhysicalRange {
            parameter: 0,
            over: None,
            range: (0.0, 0.2),
            reason: "it is a bus and one sample of the slowest loop, of 0.1 s",
        }],
        starts: &[&[1e-3], &[1e-2]],
        absent: Some(&[0.0]),
        confused_with: &["motor-lag", "wheel-speed-delay"],
        shows_in: &[Kind::Balance, Kind::Driven, Kind::SpinUp],
        timing: Some(Timing::Delay),
        is_electrical: true,
        hiding: Some(Hiding { parameters: |s, _| vec![s], first_guess: 5e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn delay_s<S: Scalar>(p: &[S]) -> Option<S> {
        Some(p[0])
    }
}
