//! A cable that pulls the body like a spring.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// κ (α − α₀)
#[derive(Clone, Copy, Debug)]
pub struct BodyCableSpring;

impl Effect for BodyCableSpring {
    const INFO: EffectInfo = EffectInfo {
        name: "body-cable-spring",
        equation: "κ (α − α₀)",
        meaning: "the supply or sensor cable bends as the body turns",
        source: "Landau & Lifshitz, Mechanics (3rd ed. 1976), § 21, a linear restoring torque",
        fingerprint: "the angle at which the body hangs and the angle at which it balances both move, and the period changes",
        prior: Prior { commonness: Commonness::Occasional, reason: "where a cable bridges the pivot" },
        role: Role::Body,
        parameters: &[ParameterInfo {
            name: "cable_stiffness",
            unit: "N m/rad",
            meaning: "bending stiffness of the cable",
            plausible: (1e-4, 5e-2),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "cable_rest_angle",
            unit: "rad",
            meaning: "angle at which the cable exerts no torque",
            plausible: (-1.5, 1.5),
            bounds: (-6.3, 6.3),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-3, 0.0], &[1e-3, 1.0], &[1e-3, -1.0]],
        absent: Some(&[0.0, 0.0]),
        confused_with: &["angle-offset"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        product: Some((0, 1)),
        linearised: Linearised::Exactly,
        angle_power: Some(1),
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.gravity_torque * s, bench.second], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * (at.angle_rad - p[1])
    }
}
