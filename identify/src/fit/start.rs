//! A first guess of the base parameters, computed from the samples without simulation.
//!
//! The equations of motion are linear in G/Θ, τ/j_w and the friction ratios. They are multiplied by a test function
//! ("bump") ψ(t), which vanishes with its derivative at both ends of a short interval, and integrated by parts. The
//! result holds for the measured angle and wheel speed themselves, so no noise is differentiated
//! (the weak form, or modulating-function method of Shinbrot, Trans. ASME 79 (1957)). One linear
//! least-squares problem then gives the ratios. Values that were measured directly turn them into parameters.

use plant::{GRAVITY_TORQUE, Kind, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use super::integrated::integrated_ratios;
use super::ratios::{Ratios, positive};
use super::rows::Rows;
use crate::records::{BUMP_S, Output, Record, angle_samples, bumps};

/// Length of the bump in a balance log, s. It is as short as a push by hand, so that most of the response to a push
/// falls into other bumps than the push itself.
const BALANCE_BUMP_S: f64 = 0.1;
/// A log with fewer samples may be too short for a bump, or have fewer bumps than the equation has unknowns: a spin-up
/// at a few samples per second, or one period of a swing.
const FEW_SAMPLES: usize = 256;

/// The samples in which the motor drives the wheel (current and speed have the same sign): absolute wheel speed in
/// rad/s and absolute current in A.
pub(crate) fn driving_samples(records: &[&Record]) -> Vec<(f64, f64)> {
    let mut driven: Vec<(f64, f64)> = vec![];
    for record in records {
        let Some(channel) = record.channel(Output::WheelSpeed) else {
            continue;
        };
        let at = channel.samples.iter().zip(&record.current_a);
        let at = at.filter(|(speed, current)| **speed * **current > 0.0);
        driven.extend(at.map(|(speed, current)| (speed.abs(), current.abs())));
    }
    driven
}

/// Sine and cosine of these angles.
fn sines(angle: &[f64]) -> (Vec<f64>, Vec<f64>) {
    angle.iter().map(|angle| angle.sin_cos()).unzip()
}

/// Computes the ratios from these records.
pub fn ratios(records: &[&Record]) -> Ratios {
    let mut locked = Rows::new(3);
    let mut free = Rows::new(5);
    let mut momentum = Rows::new(4);
    let mut wheel = Rows::new(2);
    for record in records {
        let angle = angle_samples(record);
        let wheel_speed = record.channel(Output::WheelSpeed).map(|c| &c.samples);
        let current = (!record.current_a.is_empty()).then_some(&record.current_a);
        let (sine, cosine) = sines(angle.as_deref().unwrap_or(&[]));
        bumps(record, BUMP_S, |bump| {
            if let Some(angle) = &angle
                && record.kind != Kind::SpinUp
            {
                let second = bump.integral(angle, 2);
                let first = bump.integral(angle, 1);
                let (sine, cosine) = (bump.integral(&sine, 0), bump.integral(&cosine, 0));
                if record.kind == Kind::FreeSwing {
                    locked.push(&[-sine, -cosine, first], second);
                } else if let Some(current) = current {
                    let drive = bump.integral(current, 0);
                    let spin = wheel_speed.map_or(0.0, |speed| bump.integral(speed, 0));
                    free.push(&[-sine, -cosine, first, -drive, spin], second);
                }
            }
            if let (Some(speed), Some(current)) = (wheel_speed, current) {
                let body = match (&angle, record.kind) {
                    (Some(angle), Kind::Balance | Kind::Driven) => bump.integral(angle, 2),
                    _ => 0.0,
                };
                let change = body - bump.integral(speed, 1);
                let drive = bump.integral(current, 0);
                let spin = bump.integral(speed, 0);
                wheel.push(&[drive, -spin], change);
            }
        });
    }
    for record in records.iter().filter(|r| r.kind == Kind::Balance) {
        let (Some(angle), Some(speed)) =
            (angle_samples(record), record.channel(Output::WheelSpeed))
        else {
            continue;
        };
        let rate = record.channel(Output::Rate).map(|c| &c.samples);
        let (sine, cosine) = sines(&angle);
        bumps(record, BALANCE_BUMP_S, |bump| {
            let (second, first) = match rate {
                Some(rate) => (-bump.integral(rate, 1), bump.integral(rate, 0)),
                None => (bump.integral(&angle, 2), -bump.integral(&angle, 1)),
            };
            let spin = -bump.integral(&speed.samples, 1);
            let (sine, cosine) = (bump.integral(&sine, 0), bump.integral(&cosine, 0));
            // Solved for the wheel's acceleration: its two large terms nearly cancel, and its noise is the largest.
            momentum.push(&[-second, -first, -sine, -cosine], spin);
        });
    }
    let mut ratios = Ratios::of_solutions(locked.solve(), free.solve(), wheel.solve());
    if let Some(solution) = momentum.solve_absolute() {
        // Θ α̈ + j_w φ̈ + r_b α̇ + G sin α = 0 contains neither the motor nor the friction of the wheel.
        let gravity = solution[2].hypot(solution[3]);
        ratios.gravity_over_wheel = positive(gravity);
        if ratios.gravity_over_total.is_none() {
            ratios.gravity_over_total = positive(gravity / solution[0]);
            ratios.friction_over_total = positive(solution[1] / solution[0]);
        }
    }
    // A log of a few samples has no bump, but its equations can be integrated.
    let is_short = |record: &&&Record| record.len() < FEW_SAMPLES;
    if records.iter().any(|record| is_short(&record)) {
        ratios = ratios.or(integrated_ratios(records, FEW_SAMPLES));
    }
    ratios
}

/// j_w/Θ where nothing shows it: about that of the thesis' bench.
const WHEEL_SHARE: f64 = 0.05;

/// Fills in the base parameters (positions 0 to 3) that are not known, and returns them with r_b and r_w. A parameter
/// about which the samples say nothing gets a harmless placeholder.
pub fn base_values(ratios: &Ratios, known: &[Option<f64>; 4]) -> ([f64; 4], f64, f64) {
    let mut total = known[TOTAL_INERTIA];
    let mut wheel = known[WHEEL_INERTIA];
    let mut gravity = known[GRAVITY_TORQUE];
    let mut torque = known[TORQUE_CONSTANT];
    let r = ratios;
    // One rule can make another applicable. Four rounds are enough for all of them. A wheel that is only dragged by the body
    // hardly shows its inertia; a usual share then lets the other rules go on.
    for round in 0..8 {
        if round == 4 {
            let free_body = gravity.zip(r.gravity_over_free).map(|(g, a)| g / a);
            let share = total.or(free_body.map(|free| free / (1.0 - WHEEL_SHARE)));
            wheel = wheel.or(share.map(|total| WHEEL_SHARE * total));
        }
        if let (None, Some(g), Some(a)) = (total, gravity, r.gravity_over_total) {
            total = Some(g / a);
        }
        if let (None, Some(t), Some(a)) = (gravity, total, r.gravity_over_total) {
            gravity = Some(t * a);
        }
        // The rules that do not depend on the wheel's friction come first.
        if let (None, Some(g), Some(a)) = (wheel, gravity, r.gravity_over_wheel) {
            wheel = Some(g / a);
        }
        if let (None, Some(j), Some(a)) = (gravity, wheel, r.gravity_over_wheel) {
            gravity = Some(j * a);
        }
        if let (None, Some(t), Some(w)) = (wheel, torque, r.torque_over_wheel) {
            wheel = Some(t / w);
        }
        if let (None, Some(j), Some(w)) = (torque, wheel, r.torque_over_wheel) {
            torque = Some(j * w);
        }
        if let (None, Some(g), Some(c), Some(a)) =
            (torque, gravity, r.torque_over_free, r.gravity_over_free)
        {
            torque = Some(c * g / a);
        }
        if let (None, Some(t), Some(c), Some(a)) =
            (gravity, torque, r.torque_over_free, r.gravity_over_free)
        {
            gravity = Some(t * a / c);
        }
        if let (None, Some(g), Some(j), Some(a)) = (total, gravity, wheel, r.gravity_over_free) {
            total = Some(g / a + j);
        }
        if let (None, Some(t), Some(j), Some(c)) = (total, torque, wheel, r.torque_over_free) {
            total = Some(t / c + j);
        }
        if let (None, Some(t), Some(j), Some(a)) = (gravity, total, wheel, r.gravity_over_free) {
            gravity = Some(a * (t - j));
        }
        if let (None, Some(t), Some(j), Some(c)) = (torque, total, wheel, r.torque_over_free) {
            torque = Some(c * (t - j));
        }
    }
    let total = total.or(wheel.map(|j| j / WHEEL_SHARE)).unwrap_or(1.0);
    // A guess must satisfy Θ > j_w. A given value (also the 1 for an unknown scale) is kept.
    let wheel = known[WHEEL_INERTIA]
        .unwrap_or_else(|| wheel.unwrap_or(WHEEL_SHARE * total).min(0.9 * total));
    let gravity = gravity.unwrap_or(100.0 * total);
    let torque = torque.unwrap_or(100.0 * wheel);
    // Noise can make the estimated friction negative; the fit needs a start inside its bounds.
    let body_friction = r.friction_over_total.unwrap_or(0.01).clamp(1e-3, 10.0) * total;
    let wheel_friction = r.friction_over_wheel.unwrap_or(0.1).clamp(1e-3, 10.0) * wheel;
    (
        [total, wheel, gravity, torque],
        body_friction,
        wheel_friction,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::{Current, Driving, EffectId, Hold, Input, Model, Plant, StartFrom, State};

    #[test]
    fn a_supply_from_which_a_fit_starts_holds_in_a_part_of_the_log() {
        let time_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.01).collect();
        let speed: Vec<f64> = time_s.iter().map(|t| 100.0 * t).collect();
        let current = vec![0.8; 500];
        let outputs = [None, None, Some(speed.clone())];
        let record = Record::new("x", Kind::SpinUp, time_s, outputs, Some(current), false);
        let torque_constant = 0.03;
        let StartFrom::Driving(supplies) = EffectId::BackEmfLimit.info().start_from else {
            panic!("the limit of a supply starts from what was asked of the motor");
        };
        let starts_from = |record: &Record| {
            supplies(&Driving {
                samples: driving_samples(&[record]),
                torque_constant,
                ohm: 1.0,
            })
        };
        let starts = starts_from(&record);
        assert!(!starts.is_empty());
        for start in starts {
            let holds = |speed: &&f64| (start[0] - torque_constant * **speed) / start[1] >= 0.8;
            let share = speed.iter().filter(holds).count() as f64 / speed.len() as f64;
            assert!((0.75..1.0).contains(&share), "{start:?}: {share}");
        }
        // A log without a current says nothing about a supply.
        let still = Record::new(
            "x",
            Kind::SpinUp,
            record.time_s.clone(),
            [None, None, Some(speed)],
            Some(vec![0.0; 500]),
            false,
        );
        assert!(starts_from(&still).is_empty());
    }

    #[test]
    fn ratios_of_noise_free_logs_are_right_within_a_percent() {
        let values = [2.3e-3, 1.36e-4, 0.245, 0.0335, 5e-4, 1.75e-5];
        let time_s: Vec<f64> = (0..2000).map(|k| k as f64 * 0.004).collect();
        let current: Vec<f64> = time_s.iter().map(|t| 0.5 * (3.0 * t).sin() + 0.2).collect();
        let input = Input::new(&time_s, &current, Hold::Linear);
        let make = |kind: Kind| {
            let plant = Plant::new(&Model::base(), &values, kind);
            let start = State {
                angle_rad: if kind == Kind::SpinUp { 0.0 } else { 0.5 },
                ..State::rest()
            };
            let (mut angle, mut speed) = (vec![], vec![]);
            let drive = match kind {
                Kind::FreeSwing => Current::Held(0.0),
                _ => Current::Recorded(&input),
            };
            plant.run(start, &time_s, 0..2000, drive, None, |_, reading, _| {
                angle.push(reading.angle_rad);
                speed.push(reading.wheel_speed_rad_s);
            });
            Record::new(
                "x",
                kind,
                time_s.clone(),
                [Some(angle), None, Some(speed)],
                Some(current.clone()),
                true,
            )
        };
        let records = [
            make(Kind::FreeSwing),
            make(Kind::SpinUp),
            make(Kind::Driven),
        ];
        let found = ratios(&records.iter().collect::<Vec<_>>());
        let near = |found: Option<f64>, truth: f64| {
            let found = found.expect("found");
            assert!((found / truth - 1.0).abs() < 0.01, "{found} {truth}");
        };
        near(found.gravity_over_total, 0.245 / 2.3e-3);
        near(found.gravity_over_free, 0.245 / (2.3e-3 - 1.36e-4));
        near(found.torque_over_free, 0.0335 / (2.3e-3 - 1.36e-4));
        near(found.torque_over_wheel, 0.0335 / 1.36e-4);
        near(found.friction_over_wheel, 1.75e-5 / 1.36e-4);
        // Either torque that is known gives all four.
        for known in [
            [None, None, Some(0.245), None],
            [None, None, None, Some(0.0335)],
        ] {
            let (base, _, _) = base_values(&found, &known);
            for (guess, truth) in base.iter().zip(&values) {
                assert!((guess / truth - 1.0).abs() < 0.05, "{base:?}");
            }
        }
    }
}
