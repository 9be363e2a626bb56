//! Known parameters come back from simulated logs, with errors that mean what they say.

use identify::{
    Effort, Identification, KnownPromise, Outcome, Output, Record, Setup, Unknowns, carry_over,
    cost, describe, find_pushes, identify, promise, refit,
};
use plant::{EffectId, Kind, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::simulated::{
    Experiment, Now, PUSHES, Physics, VALUES, balance, bench, coast_down, data, free_swing, setup,
    simulate, spin_up,
};

fn fitted(setup: &Setup, effects: &[EffectId]) -> Identification {
    let model = effects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    identify(setup, &model, None).expect("a fit")
}

/// Value and standard error of a parameter.
fn parameter(found: &Identification, name: &str) -> (f64, f64) {
    let position = found.fit.model.position_of(name).expect("in the model");
    let std = found.fit.std(position).unwrap_or(f64::NAN);
    (found.fit.values[position], std)
}

fn log(physics: &Physics, experiment: &Experiment, seed: u64) -> Record {
    simulate(physics, experiment, &mut ChaCha8Rng::seed_from_u64(seed))
}

/// A shorter bench, so that many can be drawn.
fn short_bench(physics: &Physics, seed: u64) -> Vec<Record> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let forward = |_: f64| 0.6;
    let reversed = |_: f64| -0.6;
    [
        spin_up("spin-up 0.6 A", &forward, 3.0),
        spin_up("spin-up -0.6 A", &reversed, 3.0),
        free_swing("free swing 20 deg", 20f64.to_radians(), 8.0),
        free_swing("free swing 52 deg", 52f64.to_radians(), 8.0),
        Experiment {
            length_s: 6.0,
            ..balance("balance", &PUSHES)
        },
    ]
    .iter()
    .map(|experiment| simulate(physics, experiment, &mut rng))
    .collect()
}

#[test]
fn the_truth_lies_within_two_standard_errors_as_often_as_it_should() {
    let names = [
        ("total_inertia", VALUES[0]),
        ("wheel_inertia", VALUES[1]),
        ("body_viscous_friction", VALUES[4]),
        ("wheel_viscous_friction", VALUES[5]),
    ];
    let seeds = 2000..2150u64;
    let errors: Vec<[f64; 4]> = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let found = fitted(&setup(short_bench(&Physics::base(), seed)), &[]);
            names.map(|(name, truth)| {
                let (value, std) = parameter(&found, name);
                if name.ends_with("inertia") {
                    let relative = value / truth - 1.0;
                    assert!(relative.abs() < 5e-3, "seed {seed} {name}: {relative}");
                }
                (value - truth) / std
            })
        })
        .collect();
    let mut inside = 0;
    for (index, (name, _)) in names.iter().enumerate() {
        let own = errors.iter().filter(|e| e[index].abs() < 2.0).count();
        let rms =
            (errors.iter().map(|e| e[index].powi(2)).sum::<f64>() / errors.len() as f64).sqrt();
        let mean = errors.iter().map(|e| e[index]).sum::<f64>() / errors.len() as f64;
        eprintln!(
            "{name}: {own} of {} within two, mean {mean:.2} rms {rms:.2}",
            errors.len()
        );
        inside += own;
    }
    let rate = inside as f64 / (4 * errors.len()) as f64;
    eprintln!("coverage {rate}");
    assert!((0.92..=0.98).contains(&rate), "{rate}, seeds {seeds:?}");
}

/// The wheel integrates the noise of the recorded current to a random walk that no residual shows: without
/// it in the standard errors, dry friction of the wheel lies outside two of them every other time.
#[test]
fn the_noise_of_the_recorded_current_is_in_the_standard_errors() {
    let dry = |now: &Now| -6e-4 * now.wheel_speed.tanh();
    let physics = Physics {
        on_wheel: &dry,
        ..Physics::base()
    };
    let seeds = 2600..2640u64;
    let inside: usize = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let forward = |_: f64| 0.6;
            let records = [
                spin_up("spin-up 0.6 A", &forward, 5.0),
                coast_down("coast-down"),
                free_swing("free swing 20 deg", 20f64.to_radians(), 8.0),
            ]
            .iter()
            .map(|experiment| simulate(&physics, experiment, &mut rng))
            .collect();
            let found = fitted(&setup(records), &[EffectId::WheelCoulombFriction]);
            let (value, std) = parameter(&found, "wheel_coulomb_torque");
            usize::from((value - 6e-4).abs() < 2.0 * std)
        })
        .sum();
    eprintln!("{inside} of 40 within two");
    // 95.4 % of 40, less three binomial standard deviations.
    assert!(inside >= 35, "{inside} of 40, seeds {seeds:?}");
}

/// A real bearing sticks; the model's passes through zero speed over 1 rad/s, near which a balancing wheel
/// lives. The standard errors know of it.
#[test]
fn that_a_real_joint_sticks_is_in_the_standard_errors() {
    let truth = 1.2e-3;
    let sticks = |now: &Now| -truth * (now.wheel_speed / 0.05).tanh();
    let physics = Physics {
        on_wheel: &sticks,
        ..Physics::base()
    };
    let seeds = 2700..2720u64;
    let errors: Vec<f64> = seeds
        .clone()
        .into_par_iter()
        .map(|seed| {
            let setup = setup(short_bench(&physics, seed));
            let found = fitted(&setup, &[EffectId::WheelCoulombFriction]);
            let (value, std) = parameter(&found, "wheel_coulomb_torque");
            (value - truth) / std
        })
        .collect();
    eprintln!("errors in standard errors {errors:.2?}");
    // Stick is one standard error of the model, beside which the noise of these logs is small.
    for error in errors {
        assert!(
            (0.3..2.0).contains(&error.abs()),
            "{error}, seeds {seeds:?}"
        );
    }
}

#[test]
fn a_whole_bench_gives_both_inertias_within_half_a_percent() {
    for seed in 2200..2203 {
        let found = fitted(&setup(bench(&Physics::base(), seed)), &[]);
        for (name, truth) in [("total_inertia", VALUES[0]), ("wheel_inertia", VALUES[1])] {
            let (value, _) = parameter(&found, name);
            assert!(
                (value / truth - 1.0).abs() < 5e-3,
                "seed {seed} {name}: {value}"
            );
        }
        for traces in &found.traces {
            for trace in traces {
                assert!(
                    trace.fit_percent > 30.0,
                    "seed {seed}: {:?} {}",
                    trace.output,
                    trace.fit_percent
                );
            }
        }
    }
}

#[test]
fn a_log_of_more_than_a_hundred_periods_converges_from_a_plain_start() {
    for seed in 2300..2303 {
        let long = free_swing("long", 0.6, 90.0);
        let known = [None, None, Some(VALUES[2]), None];
        let records = vec![log(&Physics::base(), &long, seed)];
        let setup = Setup::from_records(records, known, Default::default()).expect("records");
        let found = fitted(&setup, &[]);
        let (inertia, _) = parameter(&found, "total_inertia");
        assert!(
            (inertia / VALUES[0] - 1.0).abs() < 1e-4,
            "seed {seed}: {inertia}"
        );
        let trace = &found.traces[0][0];
        assert!(trace.rmse < 1.1 * 1.2e-3, "seed {seed}: {}", trace.rmse);
    }
}

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
            let found = fitted(&setup(records), &[]);
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
        let found = fitted(&setup(bench(&physics, seed)), &[]);
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
        let found = fitted(&setup(vec![swing, record]), &[]);
        let said = format!("seed {seed}: {:?}", found.pushes[1]);
        eprintln!("{said}");
        for push in &found.pushes[1] {
            let is_true = large
                .iter()
                .any(|(size, at)| (push.time_s - at).abs() < 0.1 && push.impulse_nms * size > 0.0);
            assert!(is_true, "{said}");
        }
        reported += found.pushes[1].len();
        let sentence = "cannot be told from the answer";
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

#[test]
fn without_a_known_torque_parameters_are_per_unit_of_inertia() {
    let records = short_bench(&Physics::base(), 2500);
    let swings: Vec<Record> = records
        .into_iter()
        .filter(|record| record.kind == Kind::FreeSwing)
        .collect();
    let setup = Setup::from_records(swings, [None; 4], Default::default()).expect("records");
    let found = fitted(&setup, &[]);
    let (gravity, std) = parameter(&found, "gravity_torque");
    let truth = VALUES[2] / VALUES[0];
    assert!((gravity / truth - 1.0).abs() < 1e-3, "{gravity} ± {std}");
    let position = found.fit.model.position_of("gravity_torque").expect("base");
    assert!(
        setup
            .unit(&found.fit.model, position)
            .ends_with("per kg m2")
    );
    assert!(
        found
            .statements
            .iter()
            .any(|s| s.contains("per unit of inertia"))
    );
}

/// The back-EMF constant is the torque constant, and stands per unit of inertia where that does: so do the
/// voltage and the resistance, and only their ratios to it mean anything.
#[test]
fn a_supply_limit_without_a_known_torque_is_per_unit_of_inertia() {
    let records = vec![log(
        &Physics::base(),
        &spin_up("spin-up", &|_| 0.5, 5.0),
        2607,
    )];
    let model = Model::base().with(EffectId::BackEmfLimit);
    let starts = |known: [Option<f64>; 4]| {
        let setup =
            Setup::from_records(records.clone(), known, Default::default()).expect("records");
        let base: Vec<f64> = setup.start_values(&model)[..4].to_vec();
        let base = [base[0], base[1], base[2], base[3]];
        let position = model.position(EffectId::BackEmfLimit).expect("added");
        let unit = setup.unit(&model, position);
        let starts = setup.starts(&setup.all_records(), EffectId::BackEmfLimit, &base);
        // The speed at which no current is left, rad/s, and the current that is left at standstill, A.
        let ends: Vec<(f64, f64)> = starts
            .iter()
            .map(|start| (start[0] / base[3], start[0] / start[1]))
            .collect();
        (unit, ends)
    };
    let (unit, known) = starts([None, None, None, Some(VALUES[3])]);
    assert_eq!(unit, "V");
    let (unit, per_inertia) = starts([None; 4]);
    assert_eq!(unit, "V per kg m2");
    assert_eq!(known.len(), per_inertia.len());
    for ((speed, current), (speed_per, current_per)) in known.iter().zip(&per_inertia) {
        assert!(
            (current_per / current - 1.0).abs() < 0.05,
            "{current} {current_per} A"
        );
        assert!(
            (speed_per / speed - 1.0).abs() < 0.05,
            "{speed} {speed_per} rad/s"
        );
    }
}

#[test]
fn a_spin_up_whose_current_nobody_wrote_down_gives_its_time_constant() {
    let current = |_: f64| 0.7;
    for seed in 2600..2604 {
        let mut record = log(&Physics::base(), &spin_up("spin-up", &current, 20.0), seed);
        let speed = record.channels.remove(0).samples;
        let outputs = [None, None, Some(speed)];
        let record = Record::new("spin-up", Kind::SpinUp, record.time_s, outputs, None, false);
        let known = [None, None, None, Some(VALUES[3])];
        let setup = Setup::from_records(vec![record], known, Default::default()).expect("a record");
        let found = fitted(&setup, &[]);
        let (friction, _) = parameter(&found, "wheel_viscous_friction");
        let (inertia, _) = parameter(&found, "wheel_inertia");
        let ratio = (friction / inertia) / (VALUES[5] / VALUES[1]);
        assert!((ratio - 1.0).abs() < 0.02, "seed {seed}: {ratio}");
        assert!(found.traces[0][0].rmse < 1.1 * 0.6, "seed {seed}");
        assert!(
            found
                .statements
                .iter()
                .any(|s| s.contains("per unit of inertia")),
            "{:?}",
            found.statements
        );
    }
}

#[test]
fn an_encoder_of_coarse_steps_gives_the_same_parameters() {
    for seed in 2700..2704 {
        let physics = Physics {
            noise: [3e-4, 4e-3, 0.6, 2e-3],
            angle_step: 0.01,
            ..Physics::base()
        };
        let record = log(&physics, &free_swing("swing", 0.5, 20.0), seed);
        let outputs = [Some(record.channels[0].samples.clone()), None, None];
        let record = Record::new(
            "swing",
            Kind::FreeSwing,
            record.time_s,
            outputs,
            None,
            false,
        );
        assert!(record.channels[0].quantum.is_some(), "seed {seed}");
        let known = [None, None, Some(VALUES[2]), None];
        let setup = Setup::from_records(vec![record], known, Default::default()).expect("a record");
        let found = fitted(&setup, &[]);
        let (inertia, _) = parameter(&found, "total_inertia");
        assert!(
            (inertia / VALUES[0] - 1.0).abs() < 2e-3,
            "seed {seed}: {inertia}"
        );
        let (friction, std) = parameter(&found, "body_viscous_friction");
        assert!(
            (friction - VALUES[4]).abs() < 4.0 * std,
            "seed {seed}: {friction} ± {std}"
        );
    }
}

/// What is known of a fit is not worked out again, unless other samples count.
#[test]
fn a_fit_is_described_where_it_is_the_bench_s_own() {
    let whole = setup(short_bench(&Physics::base(), 2860));
    let found = fitted(&whole, &[]);
    let again = describe(&whole, &found.fit).expect("its own fit");
    assert_eq!(again.fit.values, found.fit.values);
    assert_eq!(again.statements, found.statements);
    assert_eq!(again.traces[0][0].rmse, found.traces[0][0].rmse);
    let mut other = whole.clone();
    other.records[2].weight[100..200].fill(0.0);
    assert!(describe(&other, &found.fit).is_none());
}

/// What was commanded before a log began acts on its first samples, and nobody recorded it: a controller that
/// had just been switched on, or one that had long been at work.
#[test]
fn a_delay_comes_back_whatever_was_commanded_before_the_log() {
    for (before, seed) in [(None, 2850), (Some(0.0), 2851), (Some(-0.5), 2852)] {
        let physics = Physics {
            delay_steps: 8,
            command_before_a: before,
            ..Physics::base()
        };
        let records = vec![
            log(&physics, &free_swing("swing", 0.35, 10.0), seed + 50),
            log(&physics, &balance("balance", &[]), seed),
        ];
        let found = fitted(&setup(records), &[EffectId::InputDelay]);
        let (delay_s, std) = parameter(&found, "input_delay");
        let said = format!("{before:?}, seed {seed}: {delay_s:.5} ± {std:.1e} s");
        eprintln!("{said}");
        assert!((delay_s - 0.008).abs() < 4.0 * std && std < 2e-4, "{said}");
        for (trace, noise) in found.traces[1].iter().zip(physics.noise) {
            assert!(trace.rmse < 1.05 * noise, "{said}: {}", trace.rmse);
        }
    }
}

/// Between any two samples of a noisy command the cost has a minimum of its own.
#[test]
fn a_delay_comes_back_from_many_samples_away() {
    for (delay_steps, seed) in [(3, 2860), (5, 2861), (6, 2862), (14, 2863)] {
        let mut physics = Physics {
            delay_steps,
            ..Physics::base()
        };
        for noise in &mut physics.noise[..3] {
            *noise *= 4.0;
        }
        let records = vec![
            log(&physics, &free_swing("swing", 0.35, 10.0), seed + 50),
            log(&physics, &balance("balance", &[]), seed),
        ];
        let setup = setup(records);
        let found = fitted(&setup, &[EffectId::InputDelay]);
        let (delay_s, std) = parameter(&found, "input_delay");
        let truth_s = 1e-3 * delay_steps as f64;
        let said = format!("{truth_s} s, seed {seed}: {delay_s:.5} ± {std:.1e} s");
        eprintln!("{said}");
        assert!((delay_s - truth_s).abs() < 4.0 * std, "{said}");
    }
}

#[test]
fn dry_friction_of_the_wheel_comes_back_from_a_balance_log_alone() {
    let dry = 1.2e-3;
    let smooth = |now: &Now| -dry * now.wheel_speed.tanh();
    let sticks = |now: &Now| -dry * (now.wheel_speed / 0.05).tanh();
    for seed in 2800..2804 {
        let estimate = |on_wheel: &(dyn Fn(&Now) -> f64 + Sync)| {
            let physics = Physics {
                on_wheel,
                ..Physics::base()
            };
            let records = vec![log(&physics, &balance("balance", &PUSHES), seed)];
            let found = fitted(&setup(records), &[EffectId::WheelCoulombFriction]);
            parameter(&found, "wheel_coulomb_torque")
        };
        // Friction that is smoothed as the model's is leaves only the noise.
        let (value, _) = estimate(&smooth);
        eprintln!("seed {seed}: {value:.4e}");
        assert!((value / dry - 1.0).abs() < 0.02, "seed {seed}: {value}");
        // A wheel that turns slowly all the time feels a bearing that sticks: the stated error says so.
        let (value, std) = estimate(&sticks);
        eprintln!("seed {seed}, sticking: {value:.4e} ± {std:.1e}");
        assert!(
            (value - dry).abs() < 2.0 * std && std < 0.2 * dry,
            "seed {seed}: {value} ± {std}"
        );
    }
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn dry_friction_of_the_reference_wheel_comes_back_from_its_balance_log_alone() {
    let mut bench = bench_files::Bench::load(&data("hidden/d-dry-wheel")).expect("a bench");
    bench
        .experiments
        .retain(|experiment| experiment.kind == Kind::Balance);
    let setup = Setup::new(&bench).expect("records");
    let found = fitted(&setup, &[EffectId::WheelCoulombFriction]);
    let (value, std) = parameter(&found, "wheel_coulomb_torque");
    eprintln!("{value:.4e} ± {std:.1e}");
    assert!((value / 1.2e-3 - 1.0).abs() < 0.02, "{value} ± {std}");
    assert!((value - 1.2e-3).abs() < 4.0 * std, "{value} ± {std}");
    assert_eq!(found.pushes[0].len(), 4);
}

#[test]
fn a_coast_down_to_standstill_gives_both_frictions_of_the_wheel() {
    let on_wheel = |now: &Now| -1.2e-3 * now.wheel_speed.tanh();
    let physics = Physics {
        on_wheel: &on_wheel,
        ..Physics::base()
    };
    let current = |_: f64| 0.6;
    for seed in 2900..2904 {
        let records = vec![
            log(&physics, &coast_down("coast-down"), seed),
            log(&physics, &spin_up("spin-up", &current, 6.0), seed + 50),
        ];
        let found = fitted(&setup(records), &[EffectId::WheelCoulombFriction]);
        for (name, truth) in [
            ("wheel_coulomb_torque", 1.2e-3),
            ("wheel_viscous_friction", VALUES[5]),
            ("wheel_inertia", VALUES[1]),
        ] {
            let (value, std) = parameter(&found, name);
            assert!(
                (value / truth - 1.0).abs() < 0.01,
                "seed {seed} {name}: {value} ± {std}"
            );
        }
    }
}

/// From one cable to another that is as taut the way is straight in stiffness and stiffness times rest angle.
#[test]
fn a_cable_is_found_from_a_wrong_one_in_few_steps() {
    let (stiffness, rest_angle) = (2e-3, 0.5);
    let cable = |now: &Now| -stiffness * (now.angle - rest_angle);
    let physics = Physics {
        on_body: &cable,
        ..Physics::base()
    };
    for seed in 2700..2703 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let records = [
            free_swing("free swing 20 deg", 20f64.to_radians(), 20.0),
            free_swing("free swing 52 deg", 52f64.to_radians(), 20.0),
        ]
        .iter()
        .map(|experiment| simulate(&physics, experiment, &mut rng))
        .collect();
        let setup = setup(records);
        let found = fitted(&setup, &[EffectId::BodyCableSpring]);
        let model = &found.fit.model;
        let at = model.position(EffectId::BodyCableSpring).expect("a cable");
        let mut values = found.fit.values.clone();
        values[at] *= 0.25;
        values[at + 1] *= 4.0;
        let records = setup.all_records();
        let windows = found.fit.minimum.windows.clone();
        let free = setup.free(model);
        let again = refit(&records, model, values, windows, &free, Effort::FULL);
        assert!(
            again.evaluations <= 12,
            "seed {seed}: {}",
            again.evaluations
        );
        assert!(
            (again.cost - found.fit.minimum.cost).abs() < 0.1,
            "seed {seed}"
        );
        for (name, truth) in [
            ("cable_stiffness", stiffness),
            ("cable_rest_angle", rest_angle),
        ] {
            let (value, std) = parameter(&found, name);
            assert!(
                (value - truth).abs() < 4.0 * std,
                "seed {seed} {name}: {value} {std}"
            );
        }
    }
}

/// The parameters of the motor come back from a thinned log as from the whole one.
#[test]
fn a_thinned_log_says_what_the_whole_log_says() {
    let (zone, lag) = (0.03, 0.008);
    let motor = |current: f64| current.signum() * (current.abs() - zone).max(0.0);
    let physics = Physics {
        motor: &motor,
        motor_lag_s: lag,
        ..Physics::base()
    };
    for seed in 2900..2902 {
        let whole = setup(short_bench(&physics, seed));
        let (thin, steps) = whole.thinned(63.0);
        assert_eq!(steps, [1, 1, 2, 2, 4], "seed {seed}");
        let effects = [EffectId::MotorDeadZone, EffectId::MotorLag];
        let found = [&whole, &thin].map(|setup| fitted(setup, &effects));
        for (found, setup) in found.iter().zip([&whole, &thin]) {
            let observations: usize = setup.records.iter().map(Record::observations).sum();
            let mean_square = found.fit.minimum.cost / observations as f64;
            let spread = (2.0 / observations as f64).sqrt();
            assert!(
                (mean_square - 1.0).abs() < 6.0 * spread + 0.02,
                "seed {seed}: {mean_square}"
            );
        }
        for (name, truth) in [("dead_zone", zone), ("motor_lag", lag)] {
            for found in &found {
                let (value, std) = parameter(found, name);
                assert!(
                    (value - truth).abs() < 4.0 * std,
                    "seed {seed} {name}: {value} {std}"
                );
            }
        }
    }
}

#[test]
fn the_cost_without_derivatives_is_that_of_the_fit() {
    let whole = setup(short_bench(&Physics::base(), 2950));
    let (thin, _) = whole.thinned(63.0);
    for setup in [&whole, &thin] {
        let fit = fitted(setup, &[EffectId::WheelCogging, EffectId::MotorLag]).fit;
        let again = cost(
            &setup.all_records(),
            &fit.model,
            &fit.values,
            &fit.minimum.windows,
        );
        assert!((again / fit.minimum.cost - 1.0).abs() < 1e-9, "{again}");
    }
}

/// A fit that would not come to where it matters ends early; one that does ends where it would have anyway.
#[test]
fn a_goal_ends_only_fits_that_do_not_reach_it() {
    let cable = |now: &Now| -2e-3 * (now.angle - 0.5);
    let physics = Physics {
        on_body: &cable,
        ..Physics::base()
    };
    let bench = setup(short_bench(&physics, 2960));
    let records = bench.all_records();
    let found = fitted(&bench, &[EffectId::BodyCableSpring]).fit;
    // The curve of Stribeck lies along a curved valley.
    let other = fitted(&bench, &[EffectId::BodyStribeckFriction]).fit;
    let refitted = |fit: &identify::Fit, effort: Effort| {
        let mut values = fit.values.clone();
        *values.last_mut().expect("a parameter") *= 3.0;
        let windows = fit.minimum.windows.clone();
        let free = bench.free(&fit.model);
        refit(&records, &fit.model, values, windows, &free, effort)
    };
    let goal = 1.5 * found.minimum.cost;
    assert!(other.minimum.cost > 3.0 * goal, "{}", other.minimum.cost);
    let efforts = [Effort::FULL, Effort::FULL.towards(goal)];
    let [free, aimed] = efforts.map(|effort| refitted(&other, effort));
    assert_eq!(aimed.outcome, Outcome::Outclassed);
    assert!(aimed.evaluations < free.evaluations, "{}", free.evaluations);
    let [free, aimed] = efforts.map(|effort| refitted(&found, effort));
    assert_eq!(free.values, aimed.values);
    assert!(aimed.outcome.was_successful());
}

/// Many suspects are scored in one simulation, and records that a suspect does not touch are not simulated
/// again: neither may change what a suspect promises.
#[test]
fn a_suspect_promises_the_same_alone_and_beside_others_at_zero() {
    let setup = setup(short_bench(&Physics::base(), 2800));
    let records = setup.all_records();
    let base = fitted(&setup, &[]).fit;
    let suspects = [
        EffectId::BodyQuadraticDrag,
        EffectId::WheelQuadraticDrag,
        EffectId::CurrentOffset,
        EffectId::AngleOffset,
    ];
    let unknowns = |model: &Model| Unknowns::new(model, &setup.free(model));
    let at_zero = |model: &Model| {
        let zeros = vec![0.0; model.parameter_count()];
        carry_over(&base.model, &base.values, model, &zeros)
    };
    let windows = &base.minimum.windows;
    let of_base = promise(
        &records,
        &base.model,
        &base.values,
        windows,
        &unknowns(&base.model),
        None,
    );
    let all = suspects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    let together = promise(
        &records,
        &all,
        &at_zero(&all),
        windows,
        &unknowns(&all),
        None,
    );
    for effect in suspects {
        let model = base.model.with(effect);
        let (values, own) = (at_zero(&model), unknowns(&model));
        let known = KnownPromise {
            model: &base.model,
            values: &base.values,
            unknowns: &unknowns(&base.model),
            promise: &of_base,
            leaves_no_trace: &|_| false,
        };
        let every = vec![true; own.free.len()];
        let [alone, reused] = [None, Some(known)].map(|known| {
            let promise = promise(&records, &model, &values, windows, &own, known);
            promise.step(&values, &own, &every).cost
        });
        let names = all.parameters();
        let whole = unknowns(&all);
        let moves: Vec<bool> = whole
            .free
            .iter()
            .map(|&at| model.position_of(names[at].name).is_some())
            .collect();
        let beside = together.step(&at_zero(&all), &whole, &moves).cost;
        let gain = of_base.cost() - alone;
        for other in [reused, beside] {
            assert!(
                (other - alone).abs() < 1e-6 * (1.0 + gain.abs()),
                "{effect:?} {alone} {other}"
            );
        }
    }
}

/// The order of cogging is read off the wheel's speed, and the wheel's angle in the windows of a balance log
/// is known as well as the noise of its speed lets it.
#[test]
fn cogging_is_found_with_its_order() {
    let (torque, order, phase) = (1.5e-3, 7.0, 0.5);
    let cogging = |now: &Now| -torque * (order * now.wheel_angle + phase).sin();
    let physics = Physics {
        on_wheel: &cogging,
        ..Physics::base()
    };
    for seed in 2900..2902 {
        let found = fitted(&setup(bench(&physics, seed)), &[EffectId::WheelCogging]);
        let at = found
            .fit
            .model
            .position(EffectId::WheelCogging)
            .expect("cogging");
        assert_eq!(found.fit.values[at + 1], order, "seed {seed}");
        let (value, std) = parameter(&found, "cogging_torque");
        assert!(
            (value - torque).abs() < 4.0 * std,
            "seed {seed}: {value} {std}"
        );
    }
}
