//! Cogging of the motor.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Instant, ParameterInfo, Ripple, Role, Smoothing, StartFrom};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// a sin(n φ + ψ)
#[derive(Clone, Copy, Debug)]
pub struct WheelCogging;

impl Effect for WheelCogging {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-cogging",
        equation: "a sin(n φ + ψ)",
        meaning: "the magnets of the rotor prefer certain positions of the stator",
        source: "Hanselman, Brushless Permanent Magnet Motor Design (2003), ch. 10",
        fingerprint: "a slow wheel speeds up and slows down n times in every turn",
        prior: Prior { commonness: Commonness::Occasional, reason: "motors with iron teeth have it, coreless ones not" },
        role: Role::Wheel,
        parameters: &[ParameterInfo {
            name: "cogging_torque",
            unit: "N m",
            meaning: "amplitude",
            plausible: (1e-5, 1e-2),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "cogging_order",
            unit: "1",
            meaning: "periods in one turn of the wheel",
            plausible: (1.0, 60.0),
            bounds: (0.5, 500.0),
            is_torque: false,
            logarithmic: false,
            is_whole: true,
        },
        ParameterInfo {
            name: "cogging_phase",
            unit: "rad",
            meaning: "phase where a log starts",
            plausible: (-std::f64::consts::PI, std::f64::consts::PI),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-4, 1.0, 0.0]],
        absent: Some(&[0.0, 1.0, 0.0]),
        confused_with: &["wheel-unbalance"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        uses_wheel_angle: true,
        ripple: Some(Ripple { amplitude: 0, order: 1, phase: 2 }),
        start_from: StartFrom::Ripple,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                const ORDERS: [f64; 10] = [1.0, 2.0, 4.0, 6.0, 7.0, 8.0, 12.0, 16.0, 24.0, 36.0];
                let order = ORDERS[(bench.shape * ORDERS.len() as f64) as usize];
                vec![bench.top_torque() * s, order, std::f64::consts::PI * bench.second]
            },
            first_guess: 0.05,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn torque<S: Scalar>(p: &[S], at: &Instant<S>, _v0: &Smoothing) -> S {
        p[0] * (p[1] * at.wheel_angle_rad + p[2]).sin()
    }
}
