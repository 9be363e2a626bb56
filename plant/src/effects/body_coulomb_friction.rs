//! Coulomb (dry) friction of the pivot.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// μ, also of the larger effects that contain this one.
pub(super) const SLIDING_TORQUE: ParameterInfo = ParameterInfo {
    name: "body_coulomb_torque",
    unit: "N m",
    meaning: "sliding friction torque of the pivot",
    plausible: (1e-5, 1e-2),
    bounds: (0.0, f64::INFINITY),
    is_torque: true,
    logarithmic: false,
    is_whole: false,
};

/// μ tanh(α̇/v₀)
#[derive(Clone, Copy, Debug)]
pub struct BodyCoulombFriction;

impl Effect for BodyCoulombFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "body-coulomb-friction",
        equation: "μ tanh(α̇/v₀)",
        meaning: "dry rubbing in the pivot bearing",
        source: "thesis 3.10",
        fingerprint: "the amplitude falls by the same amount in every cycle, so that the swing ends at a finite time",
        prior: Prior { commonness: Commonness::Usual, reason: "every bearing with preload or a seal has it" },
        role: Role::Body,
        parameters: &[SLIDING_TORQUE],
        starts: &[&[1e-4]],
        absent: Some(&[0.0]),
        confused_with: &["body-stribeck-friction"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        has_kink: true,
        linearised: Linearised::AsDryFriction,
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.gravity_torque * s], first_guess: 1e-3, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        p[0] * (at.rate_rad_s * (1.0 / v0.body_rad_s)).tanh()
    }
}
