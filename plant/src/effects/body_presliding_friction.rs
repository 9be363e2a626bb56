//! Presliding (Dahl) friction of the pivot: the contact is a spring before it slides.
//!
//! Ḟ = σ α̇ (1 − sign(α̇) F/μ) depends on the path and not on time: over a displacement Δ in one
//! direction F → s μ + (F − s μ) exp(−σ |Δ|/μ), s = sign(Δ). The model uses this exact solution,
//! so that a stiff contact needs no smaller time step.

use super::body_coulomb_friction::SLIDING_TORQUE;
use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, Memory, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// Ḟ = σ α̇ (1 − sign(α̇) F/μ)
#[derive(Clone, Copy, Debug)]
pub struct BodyPreslidingFriction;

impl Effect for BodyPreslidingFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "body-presliding-friction",
        equation: "Ḟ = σ α̇ (1 − sign(α̇) F/μ)",
        meaning: "asperities of the contact bend before they slide",
        source: "P. Dahl, Aerospace Corp. TOR-0158(3107-18)-1 (1968); Åström & Canudas de Wit, IEEE CSM 28(6) (2008), eq. 1",
        fingerprint: "dry friction with a period that falls as the swing gets small: the contact acts as a spring",
        prior: Prior { commonness: Commonness::Occasional, reason: "it shows where the motion is not much larger than the bearing's deflection before it slips" },
        role: Role::Body,
        parameters: &[SLIDING_TORQUE, ParameterInfo {
            name: "body_presliding_stiffness",
            unit: "N m/rad",
            meaning: "stiffness of the contact before it slides",
            plausible: (1e-3, 2.0),
            bounds: (1e-4, 1e3),
            is_torque: true,
            logarithmic: true,
            is_whole: false,
        }],
        starts: &[&[1e-4, 0.003], &[1e-4, 0.01], &[1e-4, 0.05], &[3e-4, 0.2]],
        absent: None,
        replaces: &["body-coulomb-friction"],
        confused_with: &["body-softening-spring"],
        shows_in: &[Kind::FreeSwing, Kind::Balance, Kind::Driven],
        has_kink: true,
        linearised: Linearised::AsDryFriction,
        memory: Some(Memory { level: 0, stiffness: 1 }),
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let distance_rad = bench.between(3e-3, 0.05);
                vec![bench.gravity_torque * s, bench.gravity_torque * s / distance_rad]
            },
            first_guess: 1e-3,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(_p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        at.memory
    }

    #[inline(always)]
    fn remember<S: Scalar>(p: &[S], memory: S, displacement_rad: S) -> S {
        let limit = if displacement_rad.value() < 0.0 { -p[0] } else { p[0] };
        // With μ = 0 there is no contact; the guard keeps the exponent finite.
        let relaxed = if p[0].value() <= 0.0 {
            S::zero()
        } else {
            (-(p[1] * displacement_rad.abs() / p[0])).exp()
        };
        limit + (memory - limit) * relaxed
    }
}
