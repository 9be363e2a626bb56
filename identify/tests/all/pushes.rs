//! Pushes that nobody recorded are found where and as large as they were, and nowhere else.

use crate::common::{fitted, log};
use crate::simulated::{Now, PUSHES, Physics, VALUES, balance, bench, free_swing, problem};
use identify::{Output, Record, find_pushes};
use plant::{Kind, Model};

/// True impulses in N m s.
fn impulse(size: f64) -> f64 {
    size * 0.05 * std::f64::consts::PI.sqrt()
}

#[test]
fn pushes_are_found_where_and_as_large_as_they_were_and_none_elsewhere() {
    let same_direction = [(0.02, 5.0), (0.025, 6.0)];
    type Case<'a> = (&'a str, &'a [(f64, f64)], f64);
    let cases: [Case; 4] = [
        ("four", &PUSHES, 0.0),
        ("two in one direction", &same_direction, 0.0),
        ("none", &[], 0.0),
        ("none, motor with a lag", &[], 0.004),
    ];
    for (name, pushes, lag) in cases {
        for seed in 2400..2406 {
            let physics = Physics {
                motor_lag_s: lag,
                ..Physics::base()
            };
            let records = vec![
                log(&physics, &free_swing("swing", 0.35, 10.0), seed + 50),
                log(&physics, &balance("balance", pushes), seed),
            ];
            let found = fitted(&problem(records), &[]);
            let found = &found.pushes[1];
            let said = format!("{name}, seed {seed}: {found:?}");
            assert_eq!(found.len(), pushes.len(), "{said}");
            for (push, (size, at)) in found.iter().zip(pushes) {
                assert!((push.time_s - at).abs() < 0.010, "{said}");
                let ratio = push.impulse_nms / impulse(*size);
                assert!((ratio - 1.0).abs() < 0.15, "{said}");
            }
        }
    }
}

/// The teeth of a motor move the command all the time, so that pushes drown in what the command says of the
/// torque on the body; the momentum of body and wheel does not know the motor.
#[test]
fn pushes_are_found_beside_the_cogging_of_a_motor() {
    let cogging = |now: &Now| -6e-3 * (12.0 * now.wheel_angle + 0.5).sin();
    let physics = Physics {
        on_wheel: &cogging,
        noise: [1.2e-3, 4e-3, 0.1, 2e-3],
        ..Physics::base()
    };
    for seed in 2480..2483 {
        let found = fitted(&problem(bench(&physics, seed)), &[]);
        let found = found.pushes.last().expect("the balance log");
        let said = format!("seed {seed}: {found:?}");
        assert_eq!(found.len(), PUSHES.len(), "{said}");
        for (push, (size, at)) in found.iter().zip(PUSHES) {
            assert!((push.time_s - at).abs() < 0.010, "{said}");
            let ratio = push.impulse_nms / impulse(size);
            assert!((ratio - 1.0).abs() < 0.15, "{said}");
        }
    }
}

/// A body ten times as heavy, whose loop takes a second to answer, and of the log only every 50th sample,
/// without rates: what is reported is a push, and a sentence says why there may be others.
#[test]
fn in_a_log_at_20_hz_no_echo_of_a_push_is_reported_as_one() {
    let large: Vec<(f64, f64)> = PUSHES.iter().map(|(size, at)| (4.0 * size, *at)).collect();
    let mut values = VALUES;
    values[0] *= 10.0;
    let physics = Physics {
        values,
        ..Physics::base()
    };
    let mut reported = 0;
    for seed in 2460..2466 {
        let slow = log(&physics, &balance("balance", &large), seed).every(50);
        let samples = |output| slow.channel(output).map(|channel| channel.samples.clone());
        let record = Record::new(
            "balance",
            Kind::Balance,
            slow.time_s.clone(),
            [samples(Output::Angle), None, samples(Output::WheelSpeed)],
            Some(slow.current_a.clone()),
            false,
        );
        let swing = log(&physics, &free_swing("swing", 0.35, 10.0), seed + 50);
        let found = fitted(&problem(vec![swing, record]), &[]);
        let said = format!("seed {seed}: {:?}", found.pushes[1]);
        eprintln!("{said}");
        for push in &found.pushes[1] {
            let is_true = large
                .iter()
                .any(|(size, at)| (push.time_s - at).abs() < 0.1 && push.impulse_nms * size > 0.0);
            assert!(is_true, "{said}");
        }
        reported += found.pushes[1].len();
        let sentence = "cannot be distinguished";
        assert!(found.statements.iter().any(|each| each.contains(sentence)));
    }
    eprintln!("{reported} of {} pushes reported", 6 * large.len());
    assert!(reported >= 3 * large.len());
}

#[test]
fn no_push_is_found_in_other_kinds_of_log() {
    let record = log(&Physics::base(), &free_swing("swing", 0.35, 10.0), 2450);
    let model = identify::PushModel::of(&Model::base(), &VALUES);
    assert_eq!(record.kind, Kind::FreeSwing);
    assert!(find_pushes(&record, &model).is_empty());
}
