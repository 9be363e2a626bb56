//! Quadratic (air) drag of the body.

use crate::effect::{Effect, EffectInfo, Instant, Linearised, MAX_PARAMETERS, ParameterInfo, Role, Smoothing};
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
        replaces: &[],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::Exactly,
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S; MAX_PARAMETERS], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * at.rate_rad_s * at.rate_rad_s.abs()
    }
}
