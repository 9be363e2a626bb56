//! Logs that contradict each other, or what was measured directly, are named; logs that do not, are
//! not.

use identify::{Contradiction, FitProblem, Record, contradictions, identify};
use plant::{Kind, Model};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulated::{
    Physics, VALUES, balance, coast_down, free_swing, problem, simulate, spin_up,
};

fn found(problem: &FitProblem) -> (Vec<Contradiction>, Vec<String>) {
    let model = Model::base();
    let found = identify(problem, &model, None).expect("a fit");
    let fit = &found.fit;
    let list = contradictions(problem, &model, &fit.values, &fit.minimum.windows, &[]);
    (list, found.statements)
}

/// A bench of five short logs; `odd` is the physics of the log named so.
fn logs(seed: u64, odd: Option<(&str, &Physics)>) -> Vec<Record> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let base = Physics::base();
    [
        spin_up("spin-up 0.6 A", &|_| 0.6, 3.0),
        spin_up("spin-up -0.6 A", &|_| -0.6, 3.0),
        coast_down("coast-down"),
        free_swing("free swing", 0.35, 10.0),
        crate::simulated::Experiment {
            length_s: 5.0,
            ..balance("balance", &[])
        },
    ]
    .iter()
    .map(|experiment| {
        let physics = match odd {
            Some((name, physics)) if name == experiment.name => physics,
            _ => &base,
        };
        simulate(physics, experiment, &mut rng)
    })
    .collect()
}

#[test]
fn logs_of_one_bench_do_not_contradict_each_other() {
    // Over 200 benches fewer than 1 % may be accused: one in 200 has p = 0.18 at the stated rate.
    let seeds = 200;
    let mut accused = 0;
    let mut largest: f64 = 0.0;
    for seed in 0..seeds {
        let records = logs(1000 + seed, None)
            .into_iter()
            .filter(|record| record.kind != Kind::Balance || seed % 10 == 0)
            .collect();
        let (list, _) = found(&problem(records));
        if let Some(first) = list.first() {
            eprintln!("seed {}: {}", 1000 + seed, first.sentence());
            accused += 1;
            largest = largest.max(first.sigmas);
        }
    }
    eprintln!("{accused} of {seeds} accused, the largest at {largest:.1}");
    assert!(accused * 100 < seeds, "{accused} of {seeds}");
}

#[test]
fn the_log_of_another_wheel_is_named() {
    let mut other = Physics::base();
    other.values[1] *= 1.05;
    let (list, statements) = found(&problem(logs(1, Some(("spin-up -0.6 A", &other)))));
    for each in &list {
        eprintln!("{}", each.sentence());
    }
    let first = list.first().expect("a contradiction");
    assert_eq!(first.one.who, "experiment \"spin-up -0.6 A\"");
    assert_eq!(first.parameter, "wheel_inertia");
    assert!((first.one.value / other.values[1] - 1.0).abs() < 0.01);
    assert!((first.other.value / VALUES[1] - 1.0).abs() < 0.01);
    assert_eq!(list.len(), 1, "one wrong log is one contradiction");
    assert!(statements.contains(&first.sentence()));
}

#[test]
fn a_torque_constant_against_a_known_inertia_is_named() {
    // Both given, the torque constant 4 % too large.
    let records: Vec<Record> = logs(2, None)
        .into_iter()
        .filter(|record| record.kind == Kind::SpinUp)
        .collect();
    let known = [None, Some(VALUES[1]), None, Some(1.04 * VALUES[3])];
    let problem = FitProblem::from_records(records, known, Default::default()).expect("records");
    let (list, _) = found(&problem);
    let first = list.first().expect("a contradiction");
    eprintln!("{}", first.sentence());
    assert_eq!(first.one.who, "[known]");
    // Which of the two is wrong, nobody can say: both are named with what they would have to be.
    let mut wanted: Vec<(&str, f64)> = vec![(first.parameter, first.other.value)];
    wanted.extend(first.instead.iter().map(|each| (each.0, each.2)));
    let of = |name: &str| {
        let each = wanted.iter().find(|each| each.0 == name);
        each.map(|each| each.1).expect("named")
    };
    assert!((of("torque_constant") / VALUES[3] - 1.0).abs() < 0.005);
    assert!((of("wheel_inertia") / (1.04 * VALUES[1]) - 1.0).abs() < 0.005);
}

#[test]
fn a_gravity_torque_against_the_torque_constant_is_named() {
    let known = [None, None, Some(1.03 * VALUES[2]), Some(VALUES[3])];
    let problem =
        FitProblem::from_records(logs(3, None), known, Default::default()).expect("records");
    let (list, _) = found(&problem);
    let first = list.first().expect("a contradiction");
    eprintln!("{}", first.sentence());
    assert_eq!(first.one.who, "[known]");
    assert_eq!(list.len(), 1);
    let names: Vec<&str> = std::iter::once(first.parameter)
        .chain(first.instead.iter().map(|each| each.0))
        .collect();
    assert!(names.contains(&"gravity_torque") && names.contains(&"torque_constant"));
}
