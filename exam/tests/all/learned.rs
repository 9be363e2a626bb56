//! Hidden torques that no effect of the library describes and that depend on one coordinate. The program names the
//! coordinate; a learned curve over it lowers the error of every log to the noise, and a model with the curve predicts
//! an unseen log better than one without.

use std::sync::Arc;

use exam::{
    ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Outsider, StatedTorque, TrueInstant, Truth,
    record,
};
use identify::{
    Effort, FitProblem, PredictedSeries, Record, best_missing_curve, fit_from_scratch, identify,
    traces,
};
use plant::{EffectId, Kind, LearnedCoordinate, LearnedCurve, Model};

const NOISE: ChannelNoise = ChannelNoise {
    std: [1.2e-3, 4e-3, 0.6],
};
const SEED: u64 = 1800;
/// Largest accepted error with the curve, in units of the sensor's noise.
const FOLLOWS: f64 = 1.5;

/// A term that the library does not have, as a torque that acts on the body or the wheel.
fn acting(on_body: bool, torque: impl Fn(&TrueInstant) -> f64 + Send + Sync + 'static) -> Hidden {
    let against = move |_: &[f64], at: &TrueInstant| -torque(at);
    // The exam uses the torque alone; the name is a placeholder.
    let name = EffectId::BodySofteningSpring;
    let torque = Arc::new(against);
    Hidden::Stated(name, vec![], StatedTorque { on_body, torque })
}

fn swing(angle_rad: f64) -> ExperimentPlan {
    ExperimentPlan {
        name: format!("swing {angle_rad} rad"),
        kind: Kind::FreeSwing,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving: DriveProgram::None,
        duration_s: 12.0,
        sample_s: 0.005,
    }
}

fn driven(angle_rad: f64, current_a: f64) -> ExperimentPlan {
    ExperimentPlan {
        name: format!("driven {current_a} A"),
        kind: Kind::Driven,
        driving: DriveProgram::Square(current_a),
        duration_s: 8.0,
        ..swing(angle_rad)
    }
}

fn coast_down(wheel_speed_rad_s: f64) -> ExperimentPlan {
    ExperimentPlan {
        name: format!("coast-down {wheel_speed_rad_s} rad/s"),
        kind: Kind::SpinUp,
        angle_rad: 0.0,
        wheel_speed_rad_s,
        ..swing(0.0)
    }
}

fn truth(hidden: Hidden) -> Truth {
    Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: vec![hidden],
    }
}

fn recorded(truth: &Truth, plan: &ExperimentPlan, seed: u64) -> Record {
    let log = record(truth, plan, &NOISE, seed);
    Record::new(
        &plan.name,
        plan.kind,
        log.time_s.clone(),
        log.measured.clone().map(Some),
        Some(log.current_a.clone()),
        false,
    )
}

fn problem_of(records: Vec<Record>, truth: &Truth) -> FitProblem {
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_records(records, known, Default::default()).expect("records")
}

fn problem(hidden: Hidden, plans: &[ExperimentPlan], seed: u64) -> FitProblem {
    let truth = truth(hidden);
    let records = plans.iter().zip(seed..);
    let records = records.map(|(plan, seed)| recorded(&truth, plan, seed));
    problem_of(records.collect(), &truth)
}

/// The largest root mean square error of all series, in units of the noise of their sensors.
fn worst(records: &[&Record], traces: &[Vec<PredictedSeries>]) -> f64 {
    let pairs = records.iter().zip(traces);
    let ratios = pairs.flat_map(|(record, traces)| {
        let series = record.channels.iter().zip(traces);
        series.map(|(channel, trace)| trace.rmse / channel.noise_std)
    });
    ratios.fold(0.0, f64::max)
}

/// The error in a log that the model was not fitted to.
fn held_out(problem: &FitProblem, without: usize, model: &Model) -> f64 {
    let mut others = problem.clone();
    let record = others.records.remove(without);
    let found = identify(&others, model, None).expect("a fit");
    let (model, values) = (&found.fit.model, found.fit.values.clone());
    // Only the start of the log is fitted.
    let fitted = fit_from_scratch(&[&record], model, values, &[], Effort::FULL);
    let traces = traces(&record, &fitted.windows[0], model, &fitted.values);
    worst(&[&record], &[traces])
}

/// Learns the hidden torque from these logs as a curve over the coordinate. The log at `unseen` is also predicted by a
/// model that is fitted to the others.
fn learns(hidden: Hidden, plans: &[ExperimentPlan], coordinate: LearnedCoordinate, unseen: usize) {
    learns_drawn(hidden, plans, coordinate, unseen, SEED);
}

/// Learns the hidden torque like [`learns`], with the noise of this seed.
fn learns_drawn(
    hidden: Hidden,
    plans: &[ExperimentPlan],
    coordinate: LearnedCoordinate,
    unseen: usize,
    seed: u64,
) {
    learns_in(&problem(hidden, plans, seed), coordinate, unseen, seed);
}

fn learns_in(problem: &FitProblem, coordinate: LearnedCoordinate, unseen: usize, seed: u64) {
    let records = problem.all_records();
    let base = Model::base();
    let plain = identify(problem, &base, None).expect("a fit");
    let (model, minimum) = (&plain.fit.model, &plain.fit.minimum);
    let free = problem.free(model);
    let missing = best_missing_curve(&records, &minimum.windows, model, &minimum.values, &free);
    let missing = missing.expect("a torque is missing");
    assert_eq!(missing.coordinate, coordinate);

    let knots = [0.0, 1.0, 2.0, 3.0];
    let larger = base.with(LearnedCurve::effect(coordinate, &knots, None).expect("knots"));
    let found = identify(problem, &larger, None).expect("a fit");
    let (before, after) = (
        worst(&records, &plain.traces),
        worst(&records, &found.traces),
    );
    let (alone, with) = (
        held_out(problem, unseen, &base),
        held_out(problem, unseen, &larger),
    );
    println!(
        "seed {seed}, {coordinate:?}: error {before:.2} -> {after:.2} of the noise, held out {alone:.2} -> {with:.2}"
    );
    assert!(before > 3.0 && after < FOLLOWS, "{before} -> {after}");
    assert!(with < alone, "held out {alone} -> {with}");
}

const SWINGS: [f64; 4] = [0.2, 0.45, 0.7, 0.95];

#[test]
fn a_magnet_is_learned_over_the_angle() {
    let magnet = Hidden::Outsider(Outsider::MagnetNearAnAngle, [4e-3, 0.12, 0.08]);
    learns(magnet, &SWINGS.map(swing), LearnedCoordinate::Angle, 1);
}

#[test]
fn a_soft_stop_is_learned_over_the_angle() {
    let stop = Hidden::Outsider(Outsider::SoftStop, [0.02, 0.25, 0.0]);
    learns(stop, &SWINGS.map(swing), LearnedCoordinate::Angle, 1);
}

/// A pivot that rubs most at one speed.
#[test]
fn a_resonance_of_the_pivot_is_learned_over_the_rate() {
    let resonance = acting(true, |at| {
        let z = (at.rate_rad_s.abs() - 1.5) / 0.5;
        -1.2e-3 * (-z * z).exp() * at.rate_rad_s.signum()
    });
    learns(resonance, &SWINGS.map(swing), LearnedCoordinate::Rate, 1);
}

#[test]
fn a_resonance_of_the_wheel_is_learned_over_its_speed() {
    let resonance = acting(false, |at| {
        let z = (at.wheel_speed_rad_s.abs() - 40.0) / 15.0;
        -1.5e-3 * (-z * z).exp() * at.wheel_speed_rad_s.signum()
    });
    let plans = [
        driven(0.0, 0.3),
        driven(0.3, 0.4),
        coast_down(80.0),
        coast_down(-60.0),
    ];
    learns(resonance, &plans, LearnedCoordinate::WheelSpeed, 1);
}

/// A torque over the wheel's angle that is not sinusoidal: `per_turn` narrow bumps per turn.
fn pull(per_turn: f64, peak_nm: f64, width: f64, phase_rad: f64) -> Hidden {
    acting(false, move |at| {
        let z = (per_turn * at.wheel_angle_rad - phase_rad).cos() - 1.0;
        peak_nm * ((z / (width * width)).exp() - 0.25)
    })
}

/// Four seconds of a square wave of the current, in which the wheel makes a few turns in both directions.
fn turning(angle_rad: f64, current_a: f64) -> ExperimentPlan {
    ExperimentPlan {
        duration_s: 4.0,
        sample_s: 0.01,
        ..driven(angle_rad, current_a)
    }
}

#[test]
fn a_pull_at_one_place_of_the_turn_is_learned_over_the_wheels_angle() {
    let plans = [turning(0.0, 0.1), turning(0.3, 0.2), turning(0.0, 0.3)];
    let hidden = pull(1.0, 2e-3, 0.5, 0.7);
    learns(hidden, &plans, LearnedCoordinate::WheelAngle, 1);
}

/// Four benches: one to three bumps per turn, narrow and wide, with and without coast-downs.
#[test]
#[ignore = "run apart: half a minute on four benches"]
fn pulls_are_learned_over_the_wheels_angle_on_many_benches() {
    let square_waves = [
        driven(0.0, 0.1),
        driven(0.3, 0.2),
        driven(0.0, 0.3),
        driven(0.4, 0.4),
    ];
    let coasting = [
        square_waves[2].clone(),
        square_waves[3].clone(),
        coast_down(80.0),
        coast_down(-60.0),
    ];
    for (seed, per_turn, width, phase_rad, plans) in [
        (42, 1.0, 0.7, 3.0, &square_waves),
        (7, 1.0, 0.5, 0.7, &coasting),
        (99, 3.0, 0.5, 0.7, &square_waves),
        (123, 2.0, 0.6, 5.0, &square_waves),
    ] {
        let hidden = pull(per_turn, 2e-3, width, phase_rad);
        learns_drawn(hidden, plans, LearnedCoordinate::WheelAngle, 1, seed);
    }
}

/// With an encoder on the wheel, each log may begin at another angle of the wheel; the curve is over the wheel's
/// absolute angle.
#[test]
fn an_encoder_on_the_wheel_says_where_each_log_begins() {
    let encoder_step = std::f64::consts::TAU / 4096.0;
    let plans = [turning(0.0, 0.1), turning(0.3, 0.2), turning(0.0, 0.3)];
    let stood_rad = [0.0, 2.1, 4.4];
    let records = plans.iter().zip(stood_rad).zip(SEED..);
    let records = records.map(|((plan, stood_rad), seed)| {
        // The simulator counts the wheel's angle from the start of the log.
        let truth = truth(pull(1.0, 2e-3, 0.5, 0.7 - stood_rad));
        let mut record = recorded(&truth, plan, seed);
        let exact = exam::record(&truth, plan, &ChannelNoise { std: [0.0; 3] }, seed);
        let speed = &exact.measured[2];
        let mut angle_rad = vec![stood_rad];
        for k in 1..speed.len() {
            let step_s = exact.time_s[k] - exact.time_s[k - 1];
            angle_rad.push(angle_rad[k - 1] + 0.5 * (speed[k] + speed[k - 1]) * step_s);
        }
        let counts = angle_rad.iter().map(|angle| (angle / encoder_step).round());
        record.set_wheel_angles(&counts.map(|count| count * encoder_step).collect::<Vec<_>>());
        record
    });
    let problem = problem_of(records.collect(), &truth(pull(1.0, 2e-3, 0.5, 0.7)));
    learns_in(&problem, LearnedCoordinate::WheelAngle, 1, SEED);
}

/// Ten benches whose hidden torque has numbers drawn by lot: magnets and soft stops over the angle, resonances over both
/// speeds, pulls over the wheel's angle.
#[test]
#[ignore = "run apart: minutes on ten benches"]
fn ten_drawn_benches_with_a_torque_over_one_coordinate() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(SEED);
    let mut between = move |low: f64, high: f64| rng.random_range(low..high);
    let hanging = SWINGS.map(swing);
    let moving = [
        driven(0.0, 0.3),
        driven(0.3, 0.4),
        coast_down(80.0),
        coast_down(-60.0),
    ];
    let square_waves = [
        driven(0.0, 0.1),
        driven(0.3, 0.2),
        driven(0.0, 0.3),
        driven(0.4, 0.4),
    ];
    for seed in 0..10 {
        let (hidden, plans, coordinate) = match seed % 5 {
            0 => {
                let magnet = [between(2e-3, 6e-3), between(-0.2, 0.2), between(0.06, 0.15)];
                println!("a magnet: {magnet:?}");
                let hidden = Hidden::Outsider(Outsider::MagnetNearAnAngle, magnet);
                (hidden, &hanging, LearnedCoordinate::Angle)
            }
            1 => {
                let stop = [between(0.01, 0.04), between(0.2, 0.4), 0.0];
                println!("a soft stop: {stop:?}");
                let hidden = Hidden::Outsider(Outsider::SoftStop, stop);
                (hidden, &hanging, LearnedCoordinate::Angle)
            }
            2 => {
                let (peak, at, width) =
                    (between(8e-4, 2e-3), between(1.0, 2.5), between(0.35, 0.7));
                println!("a resonance of the pivot: {peak} N m at {at} rad/s, {width} rad/s");
                let hidden = acting(true, move |at_instant| {
                    let z = (at_instant.rate_rad_s.abs() - at) / width;
                    -peak * (-z * z).exp() * at_instant.rate_rad_s.signum()
                });
                (hidden, &hanging, LearnedCoordinate::Rate)
            }
            3 => {
                let (peak, at, width) = (
                    between(1e-3, 2e-3),
                    between(25.0, 50.0),
                    between(10.0, 20.0),
                );
                println!("a resonance of the wheel: {peak} N m at {at} rad/s, {width} rad/s");
                let hidden = acting(false, move |at_instant| {
                    let z = (at_instant.wheel_speed_rad_s.abs() - at) / width;
                    -peak * (-z * z).exp() * at_instant.wheel_speed_rad_s.signum()
                });
                (hidden, &moving, LearnedCoordinate::WheelSpeed)
            }
            _ => {
                let per_turn = between(1.0, 4.0).floor();
                let (width, phase) = (between(0.5, 0.7), between(0.0, 6.0));
                println!("a pull: {per_turn} a turn, width {width}, phase {phase} rad");
                let hidden = pull(per_turn, 2e-3, width, phase);
                (hidden, &square_waves, LearnedCoordinate::WheelAngle)
            }
        };
        learns_drawn(hidden, plans, coordinate, 1, seed);
    }
}
