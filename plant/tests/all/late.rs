//! Sensors with a lag or a delay.

use plant::{Current, EffectId, Hold, Input, Kind, Model, Plant, Reading, State};

use crate::VALUES;

/// A model with these effects, and its parameters.
fn with(effects: &[(EffectId, f64)]) -> (Model, Vec<f64>) {
    let model = effects
        .iter()
        .fold(Model::base(), |model, (effect, _)| model.with(*effect));
    let mut values = VALUES.to_vec();
    values.resize(model.parameter_count(), 0.0);
    for (effect, value) in effects {
        values[model.position(*effect).expect("added")] = *value;
    }
    (model, values)
}

/// The readings of the sensors at these samples, and the states.
fn run(
    plant: &Plant<f64>,
    start: State<f64>,
    time_s: &[f64],
    samples: std::ops::Range<usize>,
    current: Current<f64>,
) -> (Vec<Reading<f64>>, Vec<State<f64>>) {
    let (mut readings, mut states) = (vec![], vec![]);
    plant.run(
        start,
        time_s,
        samples,
        current,
        None,
        |_, reading, state| {
            readings.push(*reading);
            states.push(*state);
        },
    );
    (readings, states)
}

fn times(step_s: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| k as f64 * step_s).collect()
}

/// A wheel that coasts down loses speed as exp(−t/c), which a first-order lag answers in closed form:
/// y = φ̇₀ (c e^(−t/c) − T e^(−t/T))/(c − T), y = v at the first sample; sampled finely or coarsely.
#[test]
fn a_lag_answers_a_coast_down_in_closed_form() {
    for (lag_s, step_s) in [(0.3, 0.01), (0.02, 0.1), (2.0, 0.05), (1e-4, 0.01)] {
        let (model, values) = with(&[(EffectId::WheelSpeedLag, lag_s)]);
        let plant = Plant::new(&model, &values, Kind::SpinUp);
        let start = State {
            wheel_speed_rad_s: 200.0,
            ..State::rest()
        };
        let time_s = times(step_s, 200);
        let (readings, _) = run(&plant, start, &time_s, 0..200, Current::Held(0.0));
        let coast_s = VALUES[1] / VALUES[5];
        for (t, reading) in time_s.iter().zip(readings) {
            // The closed form above for c = `coast_s` and T = `lag_s`.
            let own = coast_s / (coast_s - lag_s);
            let expected = 200.0 * (own * (-t / coast_s).exp() + (1.0 - own) * (-t / lag_s).exp());
            let error = (reading.wheel_speed_rad_s - expected).abs();
            assert!(error < 2e-6 * 200.0, "{lag_s} {step_s} {t}: {error}");
        }
    }
}

/// A delayed reading is the reading one delay earlier. Before the first sample everything stood still, or moved as the
/// model predicts ([`Plant::with_motion_before`]).
#[test]
fn a_delay_is_the_motion_of_a_while_ago() {
    let delay_s = 0.0437;
    let effects = [EffectId::AngleDelay, EffectId::RateDelay].map(|effect| (effect, delay_s));
    let (model, values) = with(&effects);
    let start = State {
        angle_rad: 0.7,
        rate_rad_s: -1.0,
        ..State::rest()
    };
    let time_s = times(0.01, 400);
    let plant = Plant::new(&model, &values, Kind::FreeSwing);
    let (late, _) = run(&plant, start, &time_s, 0..400, Current::Held(0.0));
    // The same motion, read one delay earlier without a delay.
    let asked: Vec<f64> = time_s
        .iter()
        .map(|t| t - delay_s)
        .filter(|t| *t > 0.0)
        .collect();
    let mut at_asked = vec![0.0];
    at_asked.extend(&asked);
    let prompt = Plant::new(&Model::base(), &VALUES, Kind::FreeSwing);
    let (then, _) = run(
        &prompt,
        start,
        &at_asked,
        0..at_asked.len(),
        Current::Held(0.0),
    );
    let before = time_s.len() - asked.len();
    for (k, reading) in late.iter().enumerate() {
        let expected = then[(k + 1).saturating_sub(before)];
        assert!((reading.angle_rad - expected.angle_rad).abs() < 2e-6, "{k}");
        assert!(
            (reading.rate_rad_s - expected.rate_rad_s).abs() < 2e-5,
            "{k}"
        );
    }
    // With the motion before the log, the reading at the first sample is the angle one delay earlier.
    let moved = plant.with_motion_before(1.0);
    let (late, _) = run(&moved, start, &time_s, 0..400, Current::Held(0.0));
    let first = late[0].angle_rad - (0.7 + delay_s);
    let curved = 0.5 * delay_s * delay_s * VALUES[2] / VALUES[0] * 0.7f64.sin();
    assert!((first + curved).abs() < 1e-3, "{first} {curved}");
}

/// A run over a window in the middle of a log gives the readings of the whole log: it integrates its motion backwards.
#[test]
fn a_window_knows_its_past() {
    let effects = [
        (EffectId::RateLag, 0.012),
        (EffectId::WheelSpeedLag, 0.02),
        (EffectId::AngleDelay, 0.007),
        (EffectId::RateDelay, 0.004),
        (EffectId::MotorLag, 0.006),
    ];
    let (model, values) = with(&effects);
    let time_s = times(0.004, 500);
    let current_a: Vec<f64> = time_s.iter().map(|t| 0.8 * (23.0 * t).sin()).collect();
    let input = Input::new(&time_s, &current_a, Hold::Zero);
    let plant = Plant::new(&model, &values, Kind::Driven);
    let start = State {
        angle_rad: 0.4,
        ..State::rest()
    };
    let current = Current::Recorded(&input);
    let (whole, states) = run(&plant, start, &time_s, 0..500, current);
    let swing =
        |of: fn(&Reading<f64>) -> f64| whole.iter().map(of).fold(0.0, |a: f64, b| a.max(b.abs()));
    let scales = [
        swing(|r| r.angle_rad),
        swing(|r| r.rate_rad_s),
        swing(|r| r.wheel_speed_rad_s),
    ];
    for first in [3, 100, 333] {
        let (part, _) = run(&plant, states[first], &time_s, first..first + 60, current);
        for (k, (a, b)) in part.iter().zip(&whole[first..]).enumerate() {
            let errors = [
                a.angle_rad - b.angle_rad,
                a.rate_rad_s - b.rate_rad_s,
                a.wheel_speed_rad_s - b.wheel_speed_rad_s,
            ];
            for (error, scale) in errors.iter().zip(scales) {
                assert!(
                    error.abs() < 2e-3 * scale,
                    "{first} + {k}: {errors:?} of {scales:?}"
                );
            }
        }
    }
}

/// In a spin-up, a delay of the wheel speed and a delay of the command give the same log. With viscous friction alone,
/// so do a lag of the sensor and a lag of the motor.
#[test]
fn the_sensor_and_the_motor_are_one_function_of_a_spin_up() {
    let time_s = times(0.005, 600);
    let current_a: Vec<f64> = time_s
        .iter()
        .map(|&t| if t < 0.2 { 0.0 } else { 1.1 })
        .collect();
    let input = Input::new(&time_s, &current_a, Hold::Zero);
    let says = |effect: EffectId| {
        let (model, values) = with(&[(effect, 0.03)]);
        let plant = Plant::new(&model, &values, Kind::SpinUp);
        let current = Current::Recorded(&input);
        let (readings, _) = run(&plant, State::rest(), &time_s, 0..600, current);
        readings
            .iter()
            .map(|r| r.wheel_speed_rad_s)
            .collect::<Vec<f64>>()
    };
    for (sensor, motor) in [
        (EffectId::WheelSpeedDelay, EffectId::InputDelay),
        (EffectId::WheelSpeedLag, EffectId::MotorLag),
    ] {
        for (k, (a, b)) in says(sensor).iter().zip(says(motor)).enumerate() {
            assert!((a - b).abs() < 1e-4, "{sensor:?} {k}: {a} {b}");
        }
    }
}

/// The reading of an eccentric encoder is α + e sin(α + ψ).
#[test]
fn an_eccentric_encoder_runs_ahead_once_a_turn() {
    let model = Model::base().with(EffectId::AngleEccentricity);
    let mut values = VALUES.to_vec();
    values.extend([0.05, 0.4]);
    let plant = Plant::new(&model, &values, Kind::Driven);
    for angle_rad in [-2.0, 0.0, 0.3, 3.0] {
        let state = State {
            angle_rad,
            ..State::rest()
        };
        let expected = angle_rad + 0.05 * f64::sin(angle_rad + 0.4);
        assert!((plant.read(&state).angle_rad - expected).abs() < 1e-15);
    }
}
