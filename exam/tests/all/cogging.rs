//! Cogging of a motor: its traces in logs, and the verdicts of the diagnosis on them.

use exam::{Answer, Mark, draw, mark};
use identify::{Effort, Progress, Record, Window, final_windows, refit, simulate};
use plant::{EffectId, Kind, Model};

/// The bench of a seed whose driven log passes many teeth slowly.
const DRIVEN: u64 = 248;

/// χ² of one record for each observation.
fn cost(record: &Record, windows: &[Window], model: &Model, values: &[f64]) -> f64 {
    let mut sum = 0.0;
    for window in windows {
        simulate(record, window, model, values, |k, reading, _| {
            for channel in &record.channels {
                let error = (channel.samples[k] - channel.output.of(reading)) / channel.noise_std;
                if error.is_finite() {
                    sum += record.weight[k] * error * error;
                }
            }
        });
    }
    sum / record.observations() as f64
}

/// With the true parameters and the best starts, a simulation in windows leaves only the noise. A simulation in one
/// piece does not follow the log, because an error of 1e-6 rad/s at the start grows more than a thousandfold.
#[test]
fn a_driven_log_with_cogging_is_predictable_in_windows_only() {
    let bench = draw(DRIVEN).expect("a bench");
    let answer = Answer::of(&bench);
    assert_eq!(answer.effects, [EffectId::WheelCogging]);
    let model = Model::base().with(EffectId::WheelCogging);
    let names = model.parameters();
    let values: Vec<f64> = names
        .iter()
        .map(|info| {
            let known = answer.parameters.iter().find(|(name, _)| name == info.name);
            known.expect("every parameter is known").1
        })
        .collect();
    let cut = bench.problem.in_windows().expect("a driven log");
    let driven = |problem: &identify::FitProblem| -> Record {
        let mut records = problem.records.iter();
        let found = records.find(|record| record.kind == Kind::Driven);
        found.expect("a driven log").clone()
    };
    let best = |record: &Record| -> Vec<Window> {
        let start = vec![final_windows(record, &values)];
        let at = refit(&[record], &model, values.clone(), start, &[], Effort::FULL);
        at.windows[0].clone()
    };
    let (whole, in_windows) = (driven(&bench.problem), driven(&cut));
    let windows = best(&in_windows);
    let left = cost(&in_windows, &windows, &model, &values);
    assert!((0.8..1.3).contains(&left), "{left}");

    let one_piece = best(&whole);
    assert_eq!(one_piece.len(), 1);
    let left = cost(&whole, &one_piece, &model, &values);
    assert!(left > 10.0, "{left}");
    let end = |start: &Window| -> f64 {
        let mut last = 0.0;
        simulate(&whole, start, &model, &values, |_, reading, _| {
            last = reading.wheel_speed_rad_s;
        });
        last
    };
    let mut shifted = one_piece[0].clone();
    let speed = identify::Nuisance::of(&whole)
        .iter()
        .position(|&local| local == identify::Nuisance::WheelSpeed)
        .expect("the start has a wheel speed");
    shifted.nuisances[speed] += 1e-6;
    let growth = (end(&shifted) - end(&one_piece[0])).abs() / 1e-6;
    assert!(growth > 1e3, "{growth}");
}

/// Three benches: a driven log that cannot be predicted in one piece, a wheel that cogging holds against a small
/// current, and pushes that the command does not show.
#[test]
fn cogging_is_named_where_it_holds_the_wheel_or_hides_a_push() {
    for seed in [DRIVEN, 888, 928] {
        let bench = draw(seed).expect("a bench");
        let answer = Answer::of(&bench);
        assert_eq!(answer.effects, [EffectId::WheelCogging], "seed {seed}");
        let paper =
            mark(&bench.problem, &answer, EffectId::ALL, &Progress::silent()).expect("a verdict");
        assert_eq!(paper.named, [EffectId::WheelCogging], "seed {seed}");
        assert_eq!(paper.mark, Mark::Right, "seed {seed}");
    }
}
