//! A spring that softens with the angle.

use crate::effect::{Effect, EffectInfo, Instant, Linearised, MAX_PARAMETERS, ParameterInfo, Role, Smoothing};
use crate::{Kind, Scalar};

/// −κ₃ α³
#[derive(Clone, Copy, Debug)]
pub struct BodySofteningSpring;

impl Effect for BodySofteningSpring {
    const INFO: EffectInfo = EffectInfo {
        name: "body-softening-spring",
        equation: "−κ₃ α³",
        meaning: "a suspension or cable whose stiffness falls with deflection",
        source: "contract",
        fingerprint: "the period grows with the amplitude by more than a pendulum allows",
        role: Role::Body,
        parameters: &[ParameterInfo {
            name: "spring_softening",
            unit: "N m/rad3",
            meaning: "cubic coefficient",
            plausible: (1e-3, 1.0),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-3]],
        absent: Some(&[0.0]),
        replaces: &[],
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S; MAX_PARAMETERS], at: &Instant<S>, _v0: &Smoothing) -> S {
        -(p[0] * at.angle_rad * at.angle_rad * at.angle_rad)
    }
}
