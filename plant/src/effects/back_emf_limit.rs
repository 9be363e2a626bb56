//! The supply cannot drive the full current into a fast motor.

use crate::effect::{Effect, EffectInfo, Instant, Linearised, MAX_PARAMETERS, ParameterInfo, Role};
use crate::{Kind, Scalar};

/// |i| ≤ (V − k_e |φ̇|)/R where current and speed have one sign, k_e = τ
#[derive(Clone, Copy, Debug)]
pub struct BackEmfLimit;

impl Effect for BackEmfLimit {
    const INFO: EffectInfo = EffectInfo {
        name: "back-emf-limit",
        equation: "|i| ≤ (V − k_e |φ̇|)/R where current and speed have one sign, k_e = τ",
        meaning: "the back-EMF of the motor uses up the supply voltage",
        source: "contract",
        fingerprint: "a spin-up bends over at a high speed and ends at a speed that does not depend on the current",
        role: Role::Motor,
        parameters: &[ParameterInfo {
            name: "supply_voltage",
            unit: "V",
            meaning: "voltage of the supply",
            plausible: (5.0, 48.0),
            bounds: (0.1, 1e12),
            is_torque: true,
            logarithmic: true,
            is_whole: false,
        },
        ParameterInfo {
            name: "winding_resistance",
            unit: "Ohm",
            meaning: "resistance of winding and drive",
            plausible: (0.2, 20.0),
            bounds: (0.01, 1e9),
            is_torque: true,
            logarithmic: true,
            is_whole: false,
        }],
        starts: &[&[12.0, 2.0], &[12.0, 8.0], &[16.0, 2.0], &[16.0, 8.0], &[20.0, 3.0], &[24.0, 2.0], &[24.0, 8.0], &[30.0, 10.0]],
        absent: Some(&[1e12, 1.0]),
        replaces: &[],
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        has_kink: false,
        product: None,
        limit: None,
        linearised: Linearised::LeftOut,
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S; MAX_PARAMETERS],
        current_a: S,
        at: &Instant<S>,
        torque_constant: S,
    ) -> S {
        let speed = at.wheel_speed_rad_s;
        if current_a.value() * speed.value() <= 0.0 {
            return current_a;
        }
        let mut limit = (p[0] - torque_constant * speed.abs()) / p[1];
        if limit.value() < 0.0 {
            limit = S::zero();
        }
        if current_a.abs().value() <= limit.value() {
            current_a
        } else if current_a.value() < 0.0 {
            -limit
        } else {
            limit
        }
    }
}
