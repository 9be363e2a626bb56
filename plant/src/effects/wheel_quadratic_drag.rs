//! Quadratic (air) drag of the wheel.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, Linearised, ParameterInfo, Role, Smoothing};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// c_w φ̇ |φ̇|
#[derive(Clone, Copy, Debug)]
pub struct WheelQuadraticDrag;

impl Effect for WheelQuadraticDrag {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-quadratic-drag",
        equation: "c_w φ̇ |φ̇|",
        meaning: "air moved by the spinning wheel",
        source: "Nelson & Olsson, Am. J. Phys. 54 (1986) 112, eq. 3, on the wheel",
        fingerprint: "a fast wheel loses a larger fraction of its speed in a second than a slow one",
        prior: Prior { commonness: Commonness::Occasional, reason: "where the wheel is fast and its rim not smooth" },
        role: Role::Wheel,
        parameters: &[ParameterInfo {
            name: "wheel_quadratic_drag",
            unit: "N m s2/rad2",
            meaning: "torque per squared wheel speed",
            plausible: (1e-9, 1e-6),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-8]],
        absent: Some(&[0.0]),
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        linearised: Linearised::Exactly,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let speed = bench.top_wheel_speed_rad_s;
                vec![bench.top_torque() / (speed * speed) * s]
            },
            first_guess: 1e-2,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * at.wheel_speed_rad_s * at.wheel_speed_rad_s.abs()
    }
}
