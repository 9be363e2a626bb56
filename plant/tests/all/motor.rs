//! The motor chain: delay, lag, static stages, and thinned logs, which have fewer samples than their current.

use plant::{Current, EffectId, Hold, Input, Kind, Model, Plant, State};

use crate::VALUES;

/// A command that alternates across a dead zone of 0.03 A. The mean command of 0.01 A lies within the dead zone, but
/// the samples of 0.05 A and −0.03 A pass 0.02 A and 0 A: the mean current is 0.01 A.
#[test]
fn each_sample_of_the_command_passes_the_motor_also_where_the_log_is_thinned() {
    let model = Model::base().with(EffectId::MotorDeadZone);
    let values = [&VALUES[..], &[0.03]].concat();
    let plant = Plant::new(&model, &values, Kind::SpinUp);
    let time_s: Vec<f64> = (0..=1000).map(|k| k as f64 * 1e-3).collect();
    let command = |k: usize| 0.01 + if k.is_multiple_of(2) { 0.04 } else { -0.04 };
    let current_a: Vec<f64> = (0..=1000).map(command).collect();
    let input = Input::new(&time_s, &current_a, Hold::Zero);
    let end = |step: usize| {
        let times: Vec<f64> = time_s.iter().copied().step_by(step).collect();
        let mut end = 0.0;
        plant.run(
            State::rest(),
            &times,
            0..times.len(),
            Current::Recorded(&input),
            None,
            |_, reading, _| end = reading.wheel_speed_rad_s,
        );
        end
    };
    let (j, r) = (VALUES[1], VALUES[5]);
    let exact = 0.0335 * 0.01 / r * (1.0 - (-r / j).exp());
    for step in [1, 4] {
        assert!(
            (end(step) / exact - 1.0).abs() < 1e-3,
            "{step}: {} {exact}",
            end(step)
        );
    }
}

/// With a delay, the motor receives the command from before the log and then the recorded command, shifted by the
/// delay; also in a thinned log and with further stages of the motor.
#[test]
fn a_delay_carries_the_command_from_before_the_log() {
    let (before_a, delay_s) = (-0.7, 0.013);
    let command = |k: usize| 0.4 + 0.3 * (k as f64 * 0.05).sin();
    let later = |k: usize| if k < 13 { before_a } else { command(k - 13) };
    let time_s: Vec<f64> = (0..=400).map(|k| k as f64 * 1e-3).collect();
    let input = |current: &dyn Fn(usize) -> f64| {
        let current_a: Vec<f64> = (0..=400).map(current).collect();
        Input::new(&time_s, &current_a, Hold::Zero)
    };
    let end = |model: &Model, own: &[f64], input: &Input, step: usize| {
        let values = [&VALUES[..], own].concat();
        let plant = Plant::new(model, &values, Kind::SpinUp);
        let times: Vec<f64> = time_s.iter().copied().step_by(step).collect();
        let start = State {
            current_a: before_a,
            ..State::rest()
        };
        let current = Current::Recorded(input);
        let mut end = 0.0;
        plant.run(
            start,
            &times,
            0..times.len(),
            current,
            None,
            |_, reading, _| {
                end = reading.wheel_speed_rad_s;
            },
        );
        end
    };
    let (recorded, shifted) = (input(&command), input(&later));
    let plain = Model::base();
    let delayed = plain.with(EffectId::InputDelay);
    for step in [1, 5] {
        let (a, b) = (
            end(&delayed, &[delay_s], &recorded, step),
            end(&plain, &[], &shifted, step),
        );
        assert!((a - b).abs() < 1e-6 * b.abs(), "{step}: {a} {b}");
        let saturated = plain.with(EffectId::MotorSaturation);
        let both = saturated.with(EffectId::InputDelay);
        let own = |effect: EffectId| -> f64 {
            if effect == EffectId::InputDelay {
                delay_s
            } else {
                0.5
            }
        };
        let chain: Vec<f64> = both.effects().iter().skip(2).map(|&e| own(e)).collect();
        let (a, b) = (
            end(&both, &chain, &recorded, step),
            end(&saturated, &[0.5], &shifted, step),
        );
        assert!((a - b).abs() < 1e-6 * b.abs(), "{step}, chain: {a} {b}");
    }
}
