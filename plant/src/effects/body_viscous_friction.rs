//! Viscous friction of the pivot: part of the base model.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing, StartFrom};
use crate::{Kind, Scalar};

/// r_b α̇
#[derive(Clone, Copy, Debug)]
pub struct BodyViscousFriction;

impl Effect for BodyViscousFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "body-viscous-friction",
        equation: "r_b α̇",
        meaning: "lubricated bearing, slow air",
        source: "thesis 1.26",
        fingerprint: "the swing loses the same fraction of its amplitude in every cycle",
        prior: Prior { commonness: Commonness::Usual, reason: "every bearing and the air around it" },
        role: Role::Body,
        parameters: &[ParameterInfo {
            name: "body_viscous_friction",
            unit: "N m s/rad",
            meaning: "viscous friction of the pivot",
            plausible: (1e-6, 1e-2),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[2e-5]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        linearised: Linearised::Exactly,
        start_from: StartFrom::Damping,
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * at.rate_rad_s
    }
}
