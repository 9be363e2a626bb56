//! The supply voltage limits the current of a fast motor.

use crate::prior::{Commonness, Prior};
use crate::effect::{Driving, Effect, EffectInfo, Instant, ParameterInfo, Role, StartFrom};
use crate::hiding::Hiding;
use crate::{Kind, Scalar};

/// |i| ≤ (V − k_e |φ̇|)/R where current and speed have the same sign, k_e = τ
#[derive(Clone, Copy, Debug)]
pub struct BackEmfLimit;

impl Effect for BackEmfLimit {
    const INFO: EffectInfo = EffectInfo {
        name: "back-emf-limit",
        equation: "|i| ≤ (V − k_e |φ̇|)/R where current and speed have one sign, k_e = τ",
        meaning: "the back-EMF of the motor uses up the supply voltage",
        source: "Krishnan, Electric Motor Drives (2001), ch. 9, voltage limit of a brushless motor",
        fingerprint: "a spin-up bends over at a high speed and ends at a speed that does not depend on the current",
        prior: Prior { commonness: Commonness::Occasional, reason: "only a fast wheel on a low supply reaches it" },
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
        shows_in: &[Kind::SpinUp, Kind::Balance, Kind::Driven],
        is_electrical: true,
        is_limit: true,
        start_from: StartFrom::Driving(supplies),
        hiding: Some(Hiding {
            // The limit is reached at the share 1/(1 + s) of the highest speed, with the highest current.
            parameters: |s, bench| {
                let (current_a, speed) = (bench.top_current_a, bench.top_wheel_speed_rad_s);
                let torque_constant = bench.torque_constant;
                let resistance = bench.between(0.3, 3.0) * torque_constant * speed / current_a.max(1e-9);
                let reached = speed / (1.0 + s);
                vec![resistance * current_a + torque_constant * reached, resistance]
            },
            first_guess: 0.1,
            beyond_plausible: false,
        }),
        ..EffectInfo::PLAIN
    };

    #[inline(always)]
    fn current<S: Scalar>(
        p: &[S],
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

/// Winding resistances in ohm that are tried as starts for a fit of the supply limit.
const RESISTANCES_OHM: [f64; 3] = [1.0, 3.0, 10.0];
/// Shares of the driving samples within the supply limit that are tried as starts.
const SUFFICES: [f64; 2] = [0.8, 0.97];

/// Starts for the supply (V and ohm) that suffice for some of the requested operating points and not for the others:
/// quantiles of R |i| + k_e |φ̇| over the samples in which the motor drives the wheel. A supply whose limit is never
/// reached has no influence; one whose limit is always reached gives a motor without current.
fn supplies(driving: &Driving) -> Vec<Vec<f64>> {
    let mut starts = vec![];
    for resistance in RESISTANCES_OHM.map(|resistance| resistance * driving.ohm) {
        let asked = driving.samples.iter();
        let mut asked_v: Vec<f64> = asked
            .map(|(speed, current)| resistance * current + driving.torque_constant * speed)
            .collect();
        asked_v.sort_by(f64::total_cmp);
        for share in SUFFICES {
            let at = (share * asked_v.len() as f64) as usize;
            starts.extend(asked_v.get(at).map(|voltage| vec![*voltage, resistance]));
        }
    }
    starts
}
