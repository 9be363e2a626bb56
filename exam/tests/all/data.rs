//! Physical effects are no faults of the data: the data check refuses no bench of the exam, whatever is hidden in it.

use std::path::PathBuf;

use bench_files::{Bench, CurrentMeaning, Experiment, Known, LoadReport, Log};
use data_check::Severity;
use exam::{ExamBench, SENSOR_SEEDS, draw};
use identify::{Output, Record};
use plant::{GRAVITY_TORQUE, Kind, TORQUE_CONSTANT, WHEEL_INERTIA};
use rayon::prelude::*;

fn experiment(record: &Record) -> Experiment {
    let samples = |output| {
        record
            .channel(output)
            .map(|channel| channel.samples.clone())
    };
    Experiment {
        name: record.name.clone(),
        kind: record.kind,
        file: PathBuf::new(),
        log: Log {
            time_s: record.time_s.clone(),
            angle_rad: samples(Output::Angle),
            rate_rad_s: samples(Output::Rate),
            wheel_speed_rad_s: samples(Output::WheelSpeed),
            current_a: (record.kind != Kind::FreeSwing && !record.current_a.is_empty())
                .then(|| record.current_a.clone()),
            ..Log::default()
        },
        beside: Log::default(),
        current_meaning: CurrentMeaning::Command,
        accept: vec![],
        line: 0,
        report: LoadReport::default(),
    }
}

fn bench(drawn: &ExamBench) -> Bench {
    let known = drawn.problem.known;
    Bench {
        name: format!("seed {}", drawn.seed),
        folder: PathBuf::new(),
        known: Known {
            gravity_torque: known[GRAVITY_TORQUE],
            torque_constant: known[TORQUE_CONSTANT],
            wheel_inertia: known[WHEEL_INERTIA],
            ..Known::default()
        },
        controller: None,
        experiments: drawn.problem.records.iter().map(experiment).collect(),
        own_effects: vec![],
        hardware: None,
        notes: vec![],
    }
}

/// Requires that none of these benches is refused, and that few have a warning.
fn assert_no_fault(seeds: impl IntoParallelIterator<Item = u64>) {
    let said: Vec<(u64, String, usize)> = seeds
        .into_par_iter()
        .filter_map(draw)
        .map(|drawn| {
            let found = data_check::check(&bench(&drawn));
            for finding in &found {
                println!("seed {} {:?}: {finding:?}", drawn.seed, drawn.question);
            }
            let refused = found.iter().find(|f| f.severity == Severity::Refuse);
            (
                drawn.seed,
                refused.map_or(String::new(), |f| f.sentence.clone()),
                found.len(),
            )
        })
        .collect();
    println!("{} benches", said.len());
    for (seed, refused, _) in &said {
        assert_eq!(refused, "", "seed {seed}");
    }
    // Warnings are rare: one bench in ten at most has any.
    let warned = said.iter().filter(|(_, _, count)| *count > 0).count();
    assert!(10 * warned <= said.len(), "{warned} of {}", said.len());
}

#[test]
fn no_hidden_effect_passes_for_a_fault_of_the_data() {
    assert_no_fault(0..24_u64);
}

#[test]
#[ignore = "minutes: the same over more benches, a third of them with sensor effects"]
fn no_hidden_effect_of_many_passes_for_a_fault_of_the_data() {
    let sensors = SENSOR_SEEDS..SENSOR_SEEDS + 24;
    assert_no_fault((24..66_u64).chain(sensors).collect::<Vec<u64>>());
}
