//! Known parameters come back from simulated logs, with errors that mean what they say.

use crate::common::{fitted, log, parameter};
use crate::simulated::{
    Now, PUSHES, Physics, VALUES, balance, bench, coast_down, data, free_swing, problem, spin_up,
};
use identify::{FitProblem, Record};
use plant::{EffectId, Kind};

#[test]
fn a_whole_bench_gives_both_inertias_within_half_a_percent() {
    for seed in 2200..2203 {
        let found = fitted(&problem(bench(&Physics::base(), seed)), &[]);
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
        let problem =
            FitProblem::from_records(records, known, Default::default()).expect("records");
        let found = fitted(&problem, &[]);
        let (inertia, _) = parameter(&found, "total_inertia");
        assert!(
            (inertia / VALUES[0] - 1.0).abs() < 1e-4,
            "seed {seed}: {inertia}"
        );
        let trace = &found.traces[0][0];
        assert!(trace.rmse < 1.1 * 1.2e-3, "seed {seed}: {}", trace.rmse);
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
        let problem =
            FitProblem::from_records(vec![record], known, Default::default()).expect("a record");
        let found = fitted(&problem, &[]);
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
        let found = fitted(&problem(records), &[EffectId::InputDelay]);
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
        let problem = problem(records);
        let found = fitted(&problem, &[EffectId::InputDelay]);
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
            let found = fitted(&problem(records), &[EffectId::WheelCoulombFriction]);
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
    let problem = FitProblem::new(&bench).expect("records");
    let found = fitted(&problem, &[EffectId::WheelCoulombFriction]);
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
        let found = fitted(&problem(records), &[EffectId::WheelCoulombFriction]);
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
        let found = fitted(&problem(bench(&physics, seed)), &[EffectId::WheelCogging]);
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
