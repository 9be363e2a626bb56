//! Logs, and rows of logs, that do not say what a fit takes them to say: they are left out, and that is said.

use crate::common::parameter;
use crate::simulated::{
    Experiment, NOISE, Now, PUSHES, Physics, VALUES, balance, free_swing, simulate, spin_up,
};
use bench_files::{Bench, FilesInMemory};
use identify::{
    FitProblem, HeldStart, IdentifyError, Output, Record, Unknowns, failed_series, final_windows,
    held_start, identify,
};
use plant::{Kind, Model};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// The rows `from..` of a log, every `step`-th of them, as a file.
fn csv(record: &Record, from: usize, step: usize) -> String {
    let mut text = "time_s,current_A".to_owned();
    for channel in &record.channels {
        text.push_str(match channel.output {
            Output::Angle => ",angle_rad",
            Output::Rate => ",rate_rad_s",
            Output::WheelSpeed => ",wheel_speed_rad_s",
        });
    }
    for k in (from..record.len()).step_by(step) {
        text.push_str(&format!("\n{},{}", record.time_s[k], record.current_a[k]));
        for channel in &record.channels {
            text.push_str(&format!(",{}", channel.samples[k]));
        }
    }
    text.push('\n');
    text
}

/// A bench of these files.
fn bench(values: &[f64; 6], logs: &[(&Record, String)], head: &str, balance: &str) -> Bench {
    let mut files = FilesInMemory::default();
    let mut toml = format!(
        "[known]\ngravity_torque = {}\ntorque_constant = {}\n{head}\n",
        values[2], values[3]
    );
    for (index, (record, text)) in logs.iter().enumerate() {
        let more = match record.kind {
            Kind::Balance => balance,
            _ => "",
        };
        toml.push_str(&format!(
            "[[experiment]]\nname = \"{}\"\nkind = \"{}\"\nfile = \"{index}.csv\"\n{more}\n",
            record.name,
            record.kind.name()
        ));
        files.insert(format!("{index}.csv"), text.clone());
    }
    files.insert("bench.toml", toml);
    Bench::from_files(&files).unwrap_or_else(|error| panic!("{error}"))
}

/// The controller of the simulated balance logs, which gives a command every `sample_time` seconds.
fn controller(sample_time: f64) -> String {
    format!(
        "[controller]\ngains = [-24.267242, -2.129739, -0.02258758]\ncurrent_limit = 2.0\n\
         sample_time = {sample_time}"
    )
}

/// A bench of another size and with another gravity, on which the same controller balances.
fn plant_of(rng: &mut ChaCha8Rng) -> [f64; 6] {
    let size = rng.random_range(0.5..2.0);
    let gravity = rng.random_range(0.9..1.1);
    let mut values = VALUES.map(|value| size * value);
    values[2] *= gravity;
    values
}

/// Swings, spin-ups and a balance log with a controller of this rate.
fn logs(physics: &Physics, step_s: f64, rng: &mut ChaCha8Rng) -> Vec<Record> {
    let forward = |_: f64| 0.6;
    let reversed = |_: f64| -0.6;
    [
        spin_up("spin-up", &forward, 3.0),
        spin_up("reversed", &reversed, 3.0),
        free_swing("small swing", 0.35, 8.0),
        free_swing("large swing", 0.9, 8.0),
        Experiment {
            length_s: 8.0,
            step_s,
            ..balance("balance", &PUSHES[..2])
        },
    ]
    .iter()
    .map(|experiment| simulate(physics, experiment, rng))
    .collect()
}

/// Every n-th row of a balance log does not say what acted between the rows. The log is left out, and the truth lies within
/// two standard errors as often as it must; alone, it gives no model. With every command, it is used.
#[test]
fn commands_between_the_rows_spoil_no_parameter() {
    let (mut inside, mut all) = (0, 0);
    for seed in 0..40 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let values = plant_of(&mut rng);
        let physics = Physics {
            values,
            ..Physics::base()
        };
        let step_s = [0.002, 0.004][seed as usize % 2];
        let records = logs(&physics, step_s, &mut rng);
        let every = [2, 3, 5, 10, 20, 40][seed as usize % 6];
        let files = |every: usize| -> Vec<(&Record, String)> {
            let step = |record: &Record| {
                if record.kind == Kind::Balance {
                    every
                } else {
                    1
                }
            };
            let each = records.iter();
            each.map(|record| (record, csv(record, 0, step(record))))
                .collect()
        };
        let head = controller(step_s);
        let problem = FitProblem::new(&bench(&values, &files(every), &head, "")).expect("logs");
        let what = format!("seed {seed}, every {every}");
        assert_eq!(problem.records.len(), 4, "{what}");
        let found = identify(&problem, &Model::base(), None).expect("a fit");
        let said = |statement: &&String| statement.starts_with("balance: the controller gave");
        assert_eq!(found.statements.iter().filter(said).count(), 1, "{what}");
        for (name, truth) in [("total_inertia", values[0]), ("wheel_inertia", values[1])] {
            let (value, std) = parameter(&found, name);
            inside += usize::from((value - truth).abs() < 2.0 * std);
            all += 1;
        }
        // The log alone says nothing.
        let alone = &files(every)[4..];
        let error = FitProblem::new(&bench(&values, alone, &head, "")).map(|_| ());
        let Err(IdentifyError::NothingUsable { notes }) = &error else {
            panic!("{what}: {error:?}");
        };
        assert_eq!(notes.len(), 1, "{what}");
        if seed >= 6 {
            continue;
        }
        // With every row, or where the user says so, it is used.
        for (every, accept) in [(1, ""), (every, "accept = [\"sparse-commands\"]")] {
            let whole = FitProblem::new(&bench(&values, &files(every), &head, accept));
            let whole = whole.expect("logs");
            assert_eq!((whole.records.len(), whole.notes.len()), (5, 0), "{what}");
        }
        // So is one of which nothing tells the controller's rate, and that is said.
        let untold = FitProblem::new(&bench(&values, &files(1), "", "")).expect("logs");
        assert_eq!((untold.records.len(), untold.notes.len()), (5, 1), "{what}");
    }
    // Of 80 intervals of two standard errors, fewer than 69 hold the truth once in 10⁴ times.
    assert!(inside >= 69, "{inside} of {all}, seeds 0..40");
}

/// Where nothing tells the controller's rate, a balance log with a row now and then pulls the fit away from what the swings
/// show. There is a model with the truth, or none.
#[test]
fn no_fit_loses_a_swing_to_another_log_without_a_word() {
    let mut failed = 0;
    for seed in 0..24 {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        let values = plant_of(&mut rng);
        let physics = Physics {
            values,
            noise: [1e-3, 5e-3, 0.5, 0.0],
            on_body: &dry,
            ..Physics::base()
        };
        let records = logs(&physics, 0.004, &mut rng);
        let files: Vec<(&Record, String)> = records
            .iter()
            .map(|record| {
                let step = match record.kind {
                    Kind::Balance => 40,
                    Kind::FreeSwing => 25,
                    _ => 40,
                };
                (record, csv(record, 0, step))
            })
            .collect();
        let problem = FitProblem::new(&bench(&values, &files, "", "")).expect("logs");
        match identify(&problem, &Model::base(), None) {
            Ok(found) => {
                let (value, _) = parameter(&found, "total_inertia");
                let off = (value / values[0] - 1.0).abs();
                assert!(
                    off < 0.02,
                    "seed {}: {value}, truth {}",
                    100 + seed,
                    values[0]
                );
            }
            Err(error) => {
                let is_said = matches!(
                    error,
                    IdentifyError::NoBetterThanMeans { .. } | IdentifyError::InertiaOpen { .. }
                );
                assert!(is_said, "seed {}: {error}", 100 + seed);
                failed += 1;
            }
        }
    }
    eprintln!("{failed} of 24 failed");
}

/// Spin-ups and a balance log that are followed well do not hide that two swings are missed altogether.
#[test]
fn other_logs_do_not_outweigh_a_swing_that_is_missed() {
    for seed in 0..10 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let values = plant_of(&mut rng);
        let physics = Physics {
            values,
            ..Physics::base()
        };
        let forward = |_: f64| 0.6;
        let experiments = [
            spin_up("spin-up", &forward, 30.0),
            free_swing("small swing", 0.35, 8.0),
            free_swing("large swing", 0.9, 8.0),
            // It shares parameters with both, and so makes a group of all.
            Experiment {
                length_s: 0.2,
                step_s: 0.004,
                ..balance("balance", &[])
            },
        ];
        let mut simulated = |one: &Experiment| simulate(&physics, one, &mut rng);
        let records: Vec<Record> = experiments.iter().map(&mut simulated).collect();
        let records: Vec<&Record> = records.iter().collect();
        let model = Model::base();
        let unknowns = Unknowns::new(&model, &[0, 1, 4, 5]);
        let failed = |values: &[f64]| {
            let of = |record: &&Record| final_windows(record, values);
            let windows: Vec<_> = records.iter().map(of).collect();
            failed_series(&records, &model, values, &windows, &unknowns)
        };
        assert_eq!(failed(&values), [], "seed {seed}");
        // A body so heavy and so damped that it creeps to its rest where the logs swing.
        let mut creeping = values;
        creeping[0] *= 5.0;
        creeping[4] = 10.0 * (creeping[0] * creeping[2]).sqrt();
        let missed = failed(&creeping);
        for name in ["small swing", "large swing"] {
            let of_swing = missed.iter().filter(|one| one.experiment == name);
            assert_eq!(of_swing.count(), 2, "seed {seed}: {missed:?}");
        }
    }
}

/// A free swing from rest, held for a while before it begins.
struct Hold {
    record: Record,
    rows: usize,
    period_s: f64,
}

fn held(physics: &Physics, seed: u64, share: f64, has_rate: bool, has_angle: bool) -> Hold {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let angle = rng.random_range(0.15..1.2);
    let step_s = [0.002, 0.005, 0.01][seed as usize % 3];
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let swing = Experiment {
        step_s,
        ..free_swing("swing", side * angle, 10.0)
    };
    let clean = simulate(physics, &swing, &mut rng);
    let values = physics.values;
    let period_s = plant::period_s(&values);
    let rows = (share * period_s / step_s).round() as usize;
    let mut before = |samples: &[f64], at: f64, noise: f64| -> Vec<f64> {
        let noise = Normal::new(at, noise).expect("positive");
        let held = (0..rows).map(|_| noise.sample(&mut rng));
        held.chain(samples.iter().copied()).collect()
    };
    let of = |output: Output| clean.channel(output).map_or(vec![], |c| c.samples.clone());
    let angle = before(&of(Output::Angle), side * angle, physics.noise[0]);
    let rate = before(&of(Output::Rate), 0.0, physics.noise[1]);
    let count = angle.len();
    let record = Record::new(
        "swing",
        Kind::FreeSwing,
        (0..count).map(|k| step_s * k as f64).collect(),
        [has_angle.then_some(angle), has_rate.then_some(rate), None],
        Some(vec![0.0; count]),
        false,
    );
    Hold {
        record,
        rows,
        period_s,
    }
}

fn dry(now: &Now) -> f64 {
    -4e-4 * (now.rate / 0.002).tanh()
}

/// The rows before a release are found from angle, rate, or both, and none where the body swings from the first row, from a
/// turning point or in the middle of a swing.
#[test]
fn a_hold_is_found_and_a_turning_point_is_none() {
    for seed in 0..60 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let physics = Physics {
            values: plant_of(&mut rng),
            on_body: if seed % 4 < 2 {
                &crate::simulated::nothing
            } else {
                &dry
            },
            ..Physics::base()
        };
        for (has_rate, has_angle) in [(true, true), (true, false), (false, true)] {
            let what = format!("seed {seed}, rate {has_rate}, angle {has_angle}");
            for share in [0.1, 0.2, 0.3, 0.5, 1.5] {
                let hold = held(&physics, seed, share, has_rate, has_angle);
                let found: HeldStart = held_start(&hold.record)
                    .unwrap_or_else(|| panic!("{what}: a hold of {share} periods"));
                let off = found.rows.abs_diff(hold.rows) as f64;
                let step_s = hold.record.time_s[1];
                assert!(
                    off <= 2.0 + 0.02 * hold.period_s / step_s,
                    "{what}: {} rows of {}",
                    found.rows,
                    hold.rows
                );
            }
            let free = held(&physics, seed, 0.0, has_rate, has_angle);
            let count = free.record.len();
            let per_period = free.period_s / free.record.time_s[1];
            for later in [0.0, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9] {
                let part = free.record.slice((later * per_period) as usize..count);
                assert_eq!(held_start(&part), None, "{what}: {later} periods later");
            }
        }
    }
}

/// The inertia is that of the swing, not of the hand, and what was left out is said.
#[test]
fn the_rows_before_a_release_do_not_spoil_the_fit() {
    let (mut inside, mut all) = (0, 0);
    for seed in 200..240 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let values = plant_of(&mut rng);
        let physics = Physics {
            values,
            noise: NOISE,
            ..Physics::base()
        };
        let share = [0.1, 0.15, 0.25, 0.35, 0.5][seed as usize % 5];
        let hold = held(&physics, seed, share, true, true);
        let files = [(&hold.record, csv(&hold.record, 0, 1))];
        let problem = FitProblem::new(&bench(&values, &files, "", "")).expect("a log");
        let found = identify(&problem, &Model::base(), None).expect("a fit");
        let said = |statement: &&String| statement.contains("stands still");
        assert_eq!(
            found.statements.iter().filter(said).count(),
            1,
            "seed {seed}"
        );
        let (value, std) = parameter(&found, "total_inertia");
        inside += usize::from((value - values[0]).abs() < 2.0 * std);
        all += 1;
    }
    // Fewer than 32 of 40 intervals of two standard errors hold the truth once in 4000 times.
    assert!(inside >= 32, "{inside} of {all}, seeds 200..240");
}
