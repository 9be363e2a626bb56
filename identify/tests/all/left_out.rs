//! Dense logs of which a fit reads a part: what is left out changes nothing but the amount of data.

use crate::common::log;
use crate::simulated::{Experiment, NOISE, Physics, VALUES, free_swing, problem, spin_up};
use identify::{
    BALANCE_WINDOW_S, Effort, Record, finish, fit_from_scratch, joined, refit, traces,
    traces_that_count,
};
use plant::{Kind, Model};

/// Inertias and frictions.
const FREE: [usize; 4] = [0, 1, 4, 5];

/// The noise of a recorded command is estimated from the whole log: that is no matter here.
fn physics() -> Physics<'static> {
    let [angle, rate, speed, _] = NOISE;
    Physics {
        noise: [angle, rate, speed, 0.0],
        ..Physics::base()
    }
}

fn square(time_s: f64) -> f64 {
    if (time_s / 1.5) as i64 % 2 == 0 {
        0.4
    } else {
        -0.4
    }
}

/// Standard errors of a fit in short windows.
fn standard_errors(record: &Record) -> Vec<f64> {
    let (records, model) = ([record], Model::base());
    let windows = joined(&records, &VALUES, &[vec![]]);
    let found = refit(
        &records,
        &model,
        VALUES.to_vec(),
        windows,
        &FREE,
        Effort::FULL,
    );
    let fit = finish(&records, &model, &FREE, found);
    let std = |&at: &usize| fit.std(at).expect("a standard error");
    FREE.iter().map(std).collect()
}

/// A log of which a fifth counts has the standard errors of a log that ends there: a window of which nothing counts has
/// no start that would take a degree of freedom, and no residual. Nor is it predicted in the search.
#[test]
fn windows_of_which_nothing_counts_change_no_standard_error() {
    for seed in 0..3 {
        let experiment = Experiment {
            kind: Kind::Driven,
            step_s: 0.004,
            ..spin_up("driven", &square, 30.0)
        };
        let mut record = log(&physics(), &experiment, seed);
        record.window_s = BALANCE_WINDOW_S;
        let windows = joined(&[&record], &VALUES, &[vec![]]).remove(0);
        let end = windows[windows.len() / 5].samples.start;
        record.weight[end..].fill(0.0);
        let whole = standard_errors(&record);
        let part = standard_errors(&record.slice(0..end));
        for (whole, part) in whole.iter().zip(&part) {
            let ratio = whole / part;
            assert!((ratio - 1.0).abs() < 1e-3, "seed {seed}: {ratio}");
        }
        let model = Model::base();
        let all = traces(&record, &windows, &model, &VALUES);
        let counted = traces_that_count(&record, &windows, &model, &VALUES);
        for (all, counted) in all.iter().zip(&counted) {
            assert_eq!(all.predicted[..end], counted.predicted[..end]);
            assert!(counted.predicted[end..].iter().all(|value| value.is_nan()));
            assert_eq!(
                (all.rmse, all.fit_percent),
                (counted.rmse, counted.fit_percent)
            );
        }
    }
}

/// A fit whose first stages read fewer samples of dense logs ends where a fit of all samples ends that starts from the
/// truth.
#[test]
fn a_fit_of_dense_logs_ends_at_the_minimum_of_all_samples() {
    for seed in 0..2 {
        let (at_2_ms, at_1_ms) = (0.002, 0.001);
        let experiments = [
            Experiment {
                step_s: at_2_ms,
                ..spin_up("spin-up", &|_| 0.3, 40.0)
            },
            Experiment {
                step_s: at_2_ms,
                ..free_swing("swing", 0.9, 40.0)
            },
            Experiment {
                kind: Kind::Driven,
                step_s: at_1_ms,
                ..spin_up("driven", &square, 20.0)
            },
        ];
        let of = |experiment| log(&physics(), experiment, seed);
        let problem = problem(experiments.iter().map(of).collect());
        let (records, model) = (problem.all_records(), Model::base());
        let free = problem.free(&model);
        let start = problem.start_values(&model);
        let found = fit_from_scratch(&records, &model, start, &free, Effort::FULL);
        let (truth, windows) = (VALUES.to_vec(), found.windows.clone());
        let least = refit(&records, &model, truth, windows, &free, Effort::FULL);
        let fit = finish(&records, &model, &free, least.clone());
        let excess = found.cost - least.cost;
        assert!(excess.abs() < 0.1, "seed {seed}: {excess}");
        for &at in &free {
            let std = fit.std(at).expect("a standard error");
            let away = (found.values[at] - least.values[at]) / std;
            assert!(away.abs() < 0.05, "seed {seed}, parameter {at}: {away}");
        }
    }
}
