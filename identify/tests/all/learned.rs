//! A torque that no effect of the library accounts for is learned as a curve, and the model then follows the logs.

use bench_files::Bench;
use identify::{
    Effort, FitProblem, Identification, PredictedSeries, Record, best_missing_curve, final_windows,
    identify, refit, traces,
};
use plant::{EffectId, LearnedCoordinate, LearnedCurve, Model};

use crate::common::{log, short_bench};
use crate::simulated::{Now, Physics, coast_down, data, problem, spin_up};

/// A magnet of the size of the shown bench's: an eighth of a radian wide.
fn magnet(now: &Now) -> f64 {
    let z = (now.angle - 0.15) / 0.06;
    0.006 * z * (-z * z).exp()
}

fn with_curve(model: &Model, coordinate: LearnedCoordinate) -> Model {
    let knots = [0.0, 1.0, 2.0, 3.0];
    model.with(LearnedCurve::effect(coordinate, &knots, None).expect("knots"))
}

/// Root mean square error of every series that the coordinate's torque moves, over the noise of its sensor.
fn over_noise(records: &[&Record], traces: &[Vec<PredictedSeries>]) -> Vec<(String, f64)> {
    let mut out = vec![];
    for (record, traces) in records.iter().zip(traces) {
        for (channel, trace) in record.channels.iter().zip(traces) {
            out.push((
                format!("{}/{}", record.name, trace.output.name()),
                trace.rmse / channel.noise_std,
            ));
        }
    }
    out
}

fn worst(ratios: &[(String, f64)]) -> f64 {
    ratios.iter().map(|(_, ratio)| *ratio).fold(0.0, f64::max)
}

/// The curve of a fit, at one place.
fn torque(found: &Identification, at: f64) -> f64 {
    let (model, values) = (&found.fit.model, &found.fit.values);
    let effect = model.learned().next().expect("a curve");
    let curve = effect.info().learned.expect("a curve");
    let own = model.range_of(effect).expect("in the model");
    curve.spline.value(&values[own], at)
}

/// The errors of a model in a log that it was not fitted to.
fn held_out(problem: &FitProblem, without: usize, model: &Model) -> f64 {
    let mut others = problem.clone();
    let record = others.records.remove(without);
    let found = identify(&others, model, None).expect("a fit");
    let windows = vec![final_windows(&record, &found.fit.values)];
    let (model, values) = (&found.fit.model, found.fit.values.clone());
    let fitted = refit(&[&record], model, values, windows, &[], Effort::FULL);
    let traces = traces(&record, &fitted.windows[0], model, &fitted.values);
    worst(&over_noise(&[&record], &[traces]))
}

struct Case<'a> {
    records: &'a dyn Fn(u64) -> Vec<Record>,
    coordinate: LearnedCoordinate,
    /// The torque as it acts.
    truth: &'a dyn Fn(f64) -> f64,
    /// Where it is looked at.
    places: &'a [f64],
    /// What the curve may miss of it, N m. The model's own terms take up their part, which is told apart.
    within: f64,
    held_out: usize,
}

fn learns(case: &Case, base: &Model) {
    for seed in [181] {
        let problem = problem((case.records)(seed));
        let plain = identify(&problem, base, None).expect("a fit");
        let records = problem.all_records();
        let before = over_noise(&records, &plain.traces);
        let (model, minimum) = (&plain.fit.model, &plain.fit.minimum);
        let free = problem.free(model);
        let missing = best_missing_curve(&records, &minimum.windows, model, &minimum.values, &free)
            .expect("a torque is missing");
        assert_eq!(missing.coordinate, case.coordinate, "seed {seed}");
        let larger = with_curve(base, case.coordinate);
        let found = identify(&problem, &larger, None).expect("a fit");
        let after = over_noise(&records, &found.traces);
        eprintln!(
            "seed {seed} {:?}: {before:.2?}\n -> {after:.2?}",
            case.coordinate
        );
        assert!(worst(&before) > 3.0, "seed {seed}: {before:?}");
        assert!(worst(&after) < 1.5, "seed {seed}: {after:?}");
        for &place in case.places {
            let (curve, truth) = (torque(&found, place), (case.truth)(place));
            eprintln!("  at {place}: {curve:.3e}, truth {truth:.3e}");
            assert!(
                (curve - truth).abs() < case.within,
                "seed {seed} at {place}: {curve} {truth}"
            );
        }
        let (seen, unseen) = (
            held_out(&problem, case.held_out, base),
            held_out(&problem, case.held_out, &larger),
        );
        eprintln!("  held out {seen:.2} -> {unseen:.2}");
        assert!(unseen < seen, "seed {seed}: held out {seen} -> {unseen}");
    }
}

#[test]
fn a_magnet_is_learned_over_the_angle() {
    let truth = |angle: f64| {
        let z = (angle - 0.15) / 0.06;
        0.006 * z * (-z * z).exp()
    };
    let physics = Physics {
        on_body: &magnet,
        ..Physics::base()
    };
    learns(
        &Case {
            records: &|seed| short_bench(&physics, seed),
            coordinate: LearnedCoordinate::Angle,
            truth: &truth,
            places: &[-0.3, 0.0, 0.1, 0.15, 0.2, 0.35],
            within: 2.5e-4,
            held_out: 2,
        },
        &Model::base(),
    );
}

#[test]
fn a_torque_over_the_wheel_speed_is_learned() {
    // A resonance of the bearing at 80 rad/s, which no friction of the library has.
    let on_wheel = |now: &Now| {
        let z = (now.wheel_speed.abs() - 80.0) / 30.0;
        -2e-3 * (-z * z).exp() * now.wheel_speed.signum()
    };
    let truth = |speed: f64| {
        let z = (speed.abs() - 80.0) / 30.0;
        -2e-3 * (-z * z).exp() * speed.signum()
    };
    let physics = Physics {
        on_wheel: &on_wheel,
        ..Physics::base()
    };
    learns(
        &Case {
            // Several spin-ups pass the place, and one comes back through it.
            records: &|seed| {
                let currents = [0.15, 0.25, 0.35, -0.2, -0.35];
                let mut records: Vec<Record> = currents
                    .into_iter()
                    .map(|current| {
                        let held = move |_: f64| current;
                        let name = format!("spin-up {current} A");
                        log(&physics, &spin_up(&name, &held, 5.0), seed)
                    })
                    .collect();
                records.push(log(&physics, &coast_down("coast-down"), seed));
                records
            },
            coordinate: LearnedCoordinate::WheelSpeed,
            truth: &truth,
            places: &[50.0, 80.0, 110.0],
            within: 4e-4,
            held_out: 2,
        },
        &Model::base(),
    );
}

/// The shown bench with the magnet: dry friction and the curve bring every log to the noise.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_magnet_of_the_shown_bench_is_learned() {
    let bench = Bench::load(&data("hidden/f-unknown-magnet")).expect("a bench");
    let problem = FitProblem::new(&bench).expect("records");
    let records = problem.all_records();
    let base = Model::base().with(EffectId::BodyCoulombFriction);
    let before = identify(&problem, &base, None).expect("a fit");
    let before = over_noise(&records, &before.traces);
    let start = std::time::Instant::now();
    let larger = with_curve(&base, LearnedCoordinate::Angle);
    let found = identify(&problem, &larger, None).expect("a fit");
    let after = over_noise(&records, &found.traces);
    eprintln!(
        "{before:.2?}\n{after:.2?} {:.1} s",
        start.elapsed().as_secs_f64()
    );
    for place in [-0.5, -0.2, 0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.4, 0.8, 3.1] {
        let z: f64 = (place - 0.15) / 0.06;
        eprintln!(
            "{place}: {:.3e} {:.3e}",
            torque(&found, place),
            0.006 * z * (-z * z).exp()
        );
    }
    let swings = |list: &[(String, f64)]| -> Vec<(String, f64)> {
        let of_swings = list.iter().filter(|(name, _)| name.contains("swing"));
        of_swings.cloned().collect()
    };
    assert!(worst(&swings(&before)) > 2.0);
    assert!(worst(&after) < 1.5);
    for without in 0..problem.records.len() {
        if problem.records[without].name.contains("swing") {
            let (seen, unseen) = (
                held_out(&problem, without, &base),
                held_out(&problem, without, &larger),
            );
            eprintln!(
                "{} held out {seen:.2} -> {unseen:.2}",
                problem.records[without].name
            );
            assert!(unseen < seen);
        }
    }
}
