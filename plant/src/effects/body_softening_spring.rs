//! A spring that softens with the angle.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// −κ₃ α³
#[derive(Clone, Copy, Debug)]
pub struct BodySofteningSpring;

impl Effect for BodySofteningSpring {
    const INFO: EffectInfo = EffectInfo {
        name: "body-softening-spring",
        equation: "−κ₃ α³",
        meaning: "a suspension or cable whose stiffness falls with deflection",
        source: "Landau & Lifshitz, Mechanics (3rd ed. 1976), § 28, the cubic term of the restoring torque",
        fingerprint: "the period grows with the amplitude by more than a pendulum allows",
        prior: Prior { commonness: Commonness::Rare, reason: "it takes a suspension that softens as it bends" },
        role: Role::Body,
        parameters: &[ParameterInfo {
            name: "spring_softening",
            unit: "N m/rad3",
            meaning: "coefficient of the cubic term: how much the spring softens",
            plausible: (1e-3, 1.0),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-3]],
        absent: Some(&[0.0]),
        confused_with: &["body-presliding-friction"],
        shows_in: &[Kind::FreeSwing, Kind::Driven],
        angle_power: Some(3),
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.gravity_torque * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        -(p[0] * at.angle_rad * at.angle_rad * at.angle_rad)
    }
}
