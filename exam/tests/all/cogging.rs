//! The teeth of a motor: what they do to logs, and what a diagnosis makes of it.

use exam::{
    Answer, DriveProgram, ExperimentPlan, Hidden, Mark, SensorNoise, Truth, draw, mark, record,
};
use identify::{
    Effort, FitProblem, Progress, Record, Window, final_windows, identify, refit, simulate,
};
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

/// With the true parameters and the best start, windows leave the noise; one piece leaves nothing of the
/// measurement, for a millionth of a rad/s at the start has grown more than a thousandfold.
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

/// A bench whose driven log is unpredictable in one piece; one whose teeth hold the wheel against a
/// small current; one whose pushes the command does not show.
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

/// Of logs of forty seconds, over which the integrated noise of the wheel speed loses the phase, order and torque
/// are found; the phase too, from the beginnings of the logs, where the wheel's angle is known.
#[test]
fn long_logs_show_order_torque_and_phase() {
    let (torque_nm, order, phase_rad) = (2e-3, 12.0, 0.7);
    let truth = Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: vec![Hidden::Library(
            EffectId::WheelCogging,
            vec![torque_nm, order, phase_rad],
        )],
    };
    let noise = SensorNoise {
        std: [1.2e-3, 4e-3, 0.6],
    };
    let plan = |kind, driving| ExperimentPlan {
        name: format!("{kind:?} {driving:?}"),
        kind,
        angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        driving,
        duration_s: 40.0,
        sample_s: 0.004,
    };
    let balanced = DriveProgram::Balanced {
        gains: [-24.267242, -2.129739, -0.02258758],
        limit_a: 2.0,
        pushes: vec![],
    };
    let plans = [
        ExperimentPlan {
            angle_rad: 0.9,
            ..plan(Kind::FreeSwing, DriveProgram::None)
        },
        plan(Kind::SpinUp, DriveProgram::Step(0.2)),
        plan(Kind::SpinUp, DriveProgram::Step(-0.12)),
        ExperimentPlan {
            wheel_speed_rad_s: 60.0,
            ..plan(Kind::SpinUp, DriveProgram::None)
        },
        ExperimentPlan {
            angle_rad: std::f64::consts::PI + 0.03,
            ..plan(Kind::Balance, balanced)
        },
    ];
    let records = plans.iter().zip(3..).map(|(plan, seed)| {
        let log = record(&truth, plan, &noise, seed);
        let outputs = log.measured.map(Some);
        let current = Some(log.current_a);
        Record::new(&plan.name, plan.kind, log.time_s, outputs, current, false)
    });
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    let problem =
        FitProblem::from_records(records.collect(), known, Default::default()).expect("a problem");
    let model = Model::base().with(EffectId::WheelCogging);
    let fit = identify(&problem, &model, None).expect("a fit").fit;
    let at = model.position(EffectId::WheelCogging).expect("its place");
    let found = &fit.values[at..at + 3];
    assert!((found[0] / torque_nm - 1.0).abs() < 0.02, "{found:?}");
    assert_eq!(found[1], order);
    assert!((found[2] - phase_rad).abs() < 0.15, "{found:?}");
    let observations: usize = problem.records.iter().map(Record::observations).sum();
    let left = fit.minimum.cost / observations as f64;
    assert!((0.9..1.1).contains(&left), "{left}");
}
