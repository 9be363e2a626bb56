//! Coulomb (dry) friction of the wheel.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// μ_w, also of the larger effect that contains this one.
pub(super) const SLIDING_TORQUE: ParameterInfo = ParameterInfo {
    name: "wheel_coulomb_torque",
    unit: "N m",
    meaning: "sliding friction torque of the wheel",
    plausible: (1e-5, 1e-2),
    bounds: (0.0, f64::INFINITY),
    is_torque: true,
    logarithmic: false,
    is_whole: false,
};

/// μ_w tanh(φ̇/v₀)
#[derive(Clone, Copy, Debug)]
pub struct WheelCoulombFriction;

impl Effect for WheelCoulombFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-coulomb-friction",
        equation: "μ_w tanh(φ̇/v₀)",
        meaning: "dry rubbing in the bearings of wheel and motor",
        source: "thesis 3.10, on the wheel",
        fingerprint: "a coasting wheel slows down along a straight line and stops; a reversed current gives the mirror image",
        prior: Prior { commonness: Commonness::Usual, reason: "every bearing and brush has it" },
        role: Role::Wheel,
        parameters: &[SLIDING_TORQUE],
        starts: &[&[1e-4]],
        absent: Some(&[0.0]),
        confused_with: &["current-offset", "motor-dead-zone", "wheel-stribeck-friction"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        has_kink: true,
        hiding: Some(Hiding { parameters: |s, bench| vec![bench.top_torque() * s], first_guess: 1e-2, beyond_plausible: false }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, v0: &Smoothing) -> S {
        p[0] * (at.wheel_speed_rad_s * (1.0 / v0.wheel_rad_s)).tanh()
    }
}
