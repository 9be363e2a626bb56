//! Stribeck friction of the wheel: more friction while the wheel hardly turns than at speed.

use super::body_stribeck_friction::stribeck_level;
use super::wheel_coulomb_friction::SLIDING_TORQUE;
use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::physical::{HOLDS_AT_REST, PhysicalRange};
use crate::{Kind, Scalar};

/// (μ_w + (μ_s − μ_w) exp(−(φ̇/v_s)²)) tanh(φ̇/v₀)
#[derive(Clone, Copy, Debug)]
pub struct WheelStribeckFriction;

impl Effect for WheelStribeckFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-stribeck-friction",
        equation: "(μ_w + (μ_s − μ_w) exp(−(φ̇/v_s)²)) tanh(φ̇/v₀)",
        meaning: "grease, seals or brushes of the wheel that hold until it turns",
        source: "Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30 (1994), eq. 6, on the wheel",
        fingerprint: "the wheel starts late, and a coasting wheel stops abruptly: the friction is largest in the last turns",
        prior: Prior { commonness: Commonness::Occasional, reason: "it takes grease, a seal or a brush, and a log of slow turns" },
        role: Role::Wheel,
        parameters: &[SLIDING_TORQUE, ParameterInfo {
            name: "wheel_breakaway_torque",
            unit: "N m",
            meaning: "friction torque as the speed goes to zero",
            plausible: (1e-5, 2e-2),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "wheel_stribeck_speed",
            unit: "rad/s",
            meaning: "speed at which the extra friction has fallen to 1/e",
            plausible: (2.0, 20.0),
            // Below twice the smoothing speed v₀ of sign(φ̇), the term would only sharpen the smoothed sign.
            bounds: (2.0, 200.0),
            is_torque: false,
            logarithmic: true,
            is_whole: false,
        }],
        starts: &[&[1e-4, 2e-4, 4.0], &[1e-4, 2e-4, 12.0]],
        absent: Some(&[0.0, 0.0, 5.0]),
        replaces: &["wheel-coulomb-friction"],
        confused_with: &["wheel-coulomb-friction"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        has_kink: true,
        limit: Some((1, 0)),
        physical: &[HOLDS_AT_REST, PhysicalRange {
            parameter: 2,
            over: None,
            range: (0.0, 50.0),
            reason: "the film carries from 0.1 m/s on at the latest (Armstrong-Hélouvry et al. 1994), which a bearing \
             of 2 mm radius reaches at 50 rad/s",
        }],
        drawn_since: 2,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let ratio = 2.0 + bench.second;
                vec![bench.top_torque() * s, bench.top_torque() * s * ratio, bench.between(3.0, 15.0)]
            },
            first_guess: 1e-2,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        stribeck_level(p, at.wheel_speed_rad_s) * (at.wheel_speed_rad_s * (1.0 / v0.wheel_rad_s)).tanh()
    }
}
