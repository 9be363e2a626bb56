//! A constant current without a command.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// torque = τ (i + i₀)
#[derive(Clone, Copy, Debug)]
pub struct CurrentOffset;

impl Effect for CurrentOffset {
    const INFO: EffectInfo = EffectInfo {
        name: "current-offset",
        equation: "torque = τ (i + i₀)",
        meaning: "offset of the analogue set point of the drive",
        source: "Horowitz & Hill, The Art of Electronics (3rd ed. 2015), ch. 4, offset of an amplifier",
        fingerprint: "the wheel creeps at zero command; forward and reversed runs are not mirror images",
        prior: Prior { commonness: Commonness::Occasional, reason: "amplifiers are trimmed to a small part of their range" },
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "current_offset",
            unit: "A",
            meaning: "current at zero command",
            plausible: (-0.2, 0.2),
            bounds: (-10.0, 10.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[0.0]],
        absent: Some(&[0.0]),
        confused_with: &["wheel-coulomb-friction"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.side * bench.top_current_a * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S],
        current_a: S,
        _at: &Instant<S>,
        _torque_constant: S,
    ) -> S {
        current_a + p[0]
    }
}
