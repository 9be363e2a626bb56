//! Viscous friction of the wheel: part of the base model.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing, StartFrom};
use crate::{Kind, Scalar};

/// r_w φ̇
#[derive(Clone, Copy, Debug)]
pub struct WheelViscousFriction;

impl Effect for WheelViscousFriction {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-viscous-friction",
        equation: "r_w φ̇",
        meaning: "bearing grease and eddy currents of the motor",
        source: "thesis 1.26",
        fingerprint: "a coasting wheel loses the same fraction of its speed in every second",
        prior: Prior { commonness: Commonness::Usual, reason: "every bearing, and the eddy currents of the motor" },
        role: Role::Wheel,
        parameters: &[ParameterInfo {
            name: "wheel_viscous_friction",
            unit: "N m s/rad",
            meaning: "viscous friction of wheel and motor",
            plausible: (1e-7, 1e-3),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[2e-5]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        linearised: Linearised::Exactly,
        start_from: StartFrom::Damping,
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * at.wheel_speed_rad_s
    }
}
