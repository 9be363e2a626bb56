//! The wheel's centre of mass lies beside its axis.

use crate::prior::{Commonness, Prior};
use crate::effect::{Effect, EffectInfo, Given, Instant, ParameterInfo, Role, Unbalance};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// p [g sin(α + χ) + …] with χ = φ + ψ, from the Lagrangian of a mass that turns with the wheel at a distance from its
/// axis; p is mass times distance in kg m, k the distance from the pivot to the axis in m.
///
/// A mass at the distance r from the axis has the height −k cos α − r cos(α + χ) above the pivot. Its velocity is the
/// sum of k α̇ perpendicular to the direction α and r (α̇ + φ̇) perpendicular to the direction α + χ. The terms with
/// r² are part of the wheel's inertia j_w.
#[derive(Clone, Copy, Debug)]
pub struct WheelUnbalance;

impl Effect for WheelUnbalance {
    const INFO: EffectInfo = EffectInfo {
        name: "wheel-unbalance",
        equation: "χ = φ + ψ; body: p [g sin(α + χ) + k (2α̈ + φ̈) cos χ − k φ̇ (2α̇ + φ̇) sin χ], \
                   wheel: p [g sin(α + χ) + k α̈ cos χ + k α̇² sin χ]",
        meaning: "the wheel's centre of mass lies beside its axis",
        source: "Lagrange's equations for a mass on the wheel at a distance from its axis; Genta, Dynamics of Rotating Systems (2005), ch. 2",
        fingerprint: "the body shakes once in every turn of the wheel, with the square of its speed; a slow wheel swings like a pendulum",
        prior: Prior { commonness: Commonness::Occasional, reason: "wheels are turned or printed, and seldom balanced" },
        role: Role::Wheel,
        parameters: &[ParameterInfo {
            name: "wheel_unbalance",
            unit: "kg m",
            meaning: "p, mass times distance from the axis",
            plausible: (1e-8, 1e-3),
            bounds: (0.0, f64::INFINITY),
            is_torque: true,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "wheel_unbalance_phase",
            unit: "rad",
            meaning: "ψ, angle from the body's line of centres to the heavy side where a log starts",
            plausible: (-std::f64::consts::PI, std::f64::consts::PI),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "pivot_to_wheel",
            unit: "m",
            meaning: "k, from the pivot to the axis of the wheel; measured, not fitted",
            plausible: (0.01, 1.0),
            bounds: (0.0, 100.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        },
        ParameterInfo {
            name: "gravity",
            unit: "m/s2",
            meaning: "g; measured, not fitted",
            plausible: (9.76, 9.84),
            bounds: (0.0, 30.0),
            is_torque: false,
            logarithmic: false,
            is_whole: false,
        }],
        starts: &[&[1e-6, 0.0, 0.085, 9.81], &[1e-6, 2.1, 0.085, 9.81], &[1e-6, -2.1, 0.085, 9.81]],
        absent: Some(&[0.0, 0.0, 0.085, 9.81]),
        given: &[(2, Given::PivotToWheel), (3, Given::Gravity)],
        confused_with: &["wheel-cogging"],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        uses_wheel_angle: true,
        polar: Some((0, 1)),
        is_unbalance: true,
        drawn_since: 1,
        hiding: Some(Hiding {
            parameters: |s, bench| {
                let phase = std::f64::consts::PI * bench.second;
                vec![bench.top_torque() * s / 9.81, phase, bench.pivot_to_wheel_m, 9.81]
            },
            first_guess: 0.02,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn unbalance<S: Scalar>(p: &[S], at: &Instant<S>) -> Unbalance<S> {
        let heavy_side = at.wheel_angle_rad + p[1];
        let (sin, cos) = (heavy_side.sin(), (heavy_side + std::f64::consts::FRAC_PI_2).sin());
        let (rate, speed) = (at.rate_rad_s, at.wheel_speed_rad_s);
        let arm = p[0] * p[2];
        let weight = p[0] * p[3] * (at.angle_rad + heavy_side).sin();
        Unbalance {
            coupling: arm * cos,
            body_torque: weight - arm * speed * (rate * 2.0 + speed) * sin,
            wheel_torque: weight + arm * rate * rate * sin,
        }
    }
}
