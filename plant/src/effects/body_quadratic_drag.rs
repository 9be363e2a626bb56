//! Quadratic (air) drag of the body.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// c α̇ |α̇|
#[derive(Clone, Copy, Debug)]
pub struct BodyQuadraticDrag;

impl Effect for BodyQuadraticDrag {
    const INFO: EffectInfo = EffectInfo {
        name: "body-quadratic-drag",
        equation: "c α̇ |α̇|",
        meaning: "air displaced by the body",
        source: "Nelson & Olsson, Am. J. Phys. 54 (1986) 112, eq. 3",
        fingerprint: "large swings lose a larger fraction of their amplitude in a cycle than small ones",
        prior: Prior { commonness: Commonness::Occasional, reason: "where the body is large and light for its speed" },
        role: Role::Body,
        parameters: &[ParameterInfo {
            name: "body_quadratic_drag",
            unit: "N m s2/rad2",
            meaning: "torque per squared rate",
            plausible: (1e-6, 1e-3),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-5]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        linearised: Linearised::Exactly,
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.total_inertia * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * at.rate_rad_s * at.rate_rad_s.abs()
    }
}
