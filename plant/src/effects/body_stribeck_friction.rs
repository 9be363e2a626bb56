//! Stribeck friction of the pivot: more friction at low speed than at high speed.

use super::body_coulomb_friction::SLIDING_TORQUE;
use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::physical::HOLDS_AT_REST;
use crate::{Kind, Scalar};

/// μ + (μ_s − μ) exp(−(v/v_s)²) at a speed v, for the parameters μ, μ_s, v_s; also that of the wheel's friction.
#[inline(always)]
pub(super) fn stribeck_level<S: Scalar>(p: &[S], speed_rad_s: S) -> S {
    let ratio = speed_rad_s / p[2];
    p[0] + (p[1] - p[0]) * (-(ratio * ratio)).exp()
}

/// (μ + (μ_s − μ) exp(−(α̇/v_s)²)) tanh(α̇/v₀)
#[derive(Clone, Copy, Debug)]
pub struct BodyStribeckFriction;

impl Effect for BodyStribeckFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "body-stribeck-friction",
        equation: "(μ + (μ_s − μ) exp(−(α̇/v_s)²)) tanh(α̇/v₀)",
        meaning: "boundary lubrication that gives way to sliding",
        source: "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30 (1994), eq. 6",
        fingerprint: "dry friction that is larger at the turning points of small swings than at high speed",
        prior: Prior { commonness: Commonness::Rare, reason: "it takes a lubricated contact at very low speed" },
        role: Role::Body,
        parameters: &[SLIDING_TORQUE, ParameterInfo {
            name: "body_breakaway_torque",
            unit: "N m",
            meaning: "friction torque as the speed goes to zero",
            plausible: (1e-5, 2e-2),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "body_stribeck_speed",
            unit: "rad/s",
            meaning: "speed at which the extra friction has fallen to 1/e",
            plausible: (0.02, 2.0),
            // Below twice the smoothing speed v₀ of sign(α̇), the term would only sharpen the smoothed sign.
            bounds: (0.02, 20.0),
            is_torque: false,
            logarithmic: true,
            is_whole: false,
        }],
        physical: &[HOLDS_AT_REST],
        starts: &[&[1e-4, 2e-4, 0.1], &[1e-4, 2e-4, 0.5], &[1e-4, 2e-4, 2.0]],
        absent: Some(&[0.0, 0.0, 0.1]),
        replaces: &["body-coulomb-friction"],
        confused_with: &["body-coulomb-friction"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        has_kink: true,
        limit: Some((1, 0)),
        linearised: Linearised::AsDryFriction,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let ratio = 2.0 + bench.second;
                vec![bench.gravity_torque * s, bench.gravity_torque * s * ratio, bench.between(0.05, 1.0)]
            },
            first_guess: 1e-3,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        stribeck_level(p, at.rate_rad_s) * (at.rate_rad_s * (1.0 / v0.body_rad_s)).tanh()
    }
}
