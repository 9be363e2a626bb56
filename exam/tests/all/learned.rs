//! Hidden torques that no effect of the library describes and that depend on one coordinate. The program names the
//! coordinate; a learned curve over it lowers the error of every log to the noise, and a model with the curve predicts an
//! unseen log better than one without.

use std::sync::Arc;

use exam::{
    DriveProgram, ExperimentPlan, Hidden, Outsider, SensorNoise, StatedTorque, TrueInstant, Truth,
    record,
};
use identify::{
    Effort, FitProblem, PredictedSeries, Record, best_missing_curve, final_windows, identify,
    refit, traces,
};
use plant::{EffectId, Kind, LearnedCoordinate, LearnedCurve, Model};

const NOISE: SensorNoise = SensorNoise {
    std: [1.2e-3, 4e-3, 0.6],
};
const SEED: u64 = 1800;
/// Largest error, over the noise of its sensor, with the curve.
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

fn problem(hidden: Hidden, plans: &[ExperimentPlan]) -> FitProblem {
    let truth = Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: vec![hidden],
    };
    let records = plans.iter().zip(SEED..).map(|(plan, seed)| {
        let log = record(&truth, plan, &NOISE, seed);
        Record::new(
            &plan.name,
            plan.kind,
            log.time_s.clone(),
            log.measured.clone().map(Some),
            Some(log.current_a.clone()),
            false,
        )
    });
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_records(records.collect(), known, Default::default()).expect("records")
}

/// The largest error of all series over the noise of their sensors.
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
    let windows = vec![final_windows(&record, &values)];
    let fitted = refit(&[&record], model, values, windows, &[], Effort::FULL);
    let traces = traces(&record, &fitted.windows[0], model, &fitted.values);
    worst(&[&record], &[traces])
}

/// Learns the hidden torque from these logs as a curve over the coordinate. The log at `unseen` is also predicted by a
/// model that is fitted to the others.
fn learns(hidden: Hidden, plans: &[ExperimentPlan], coordinate: LearnedCoordinate, unseen: usize) {
    let problem = problem(hidden, plans);
    let records = problem.all_records();
    let base = Model::base();
    let plain = identify(&problem, &base, None).expect("a fit");
    let (model, minimum) = (&plain.fit.model, &plain.fit.minimum);
    let free = problem.free(model);
    let missing = best_missing_curve(&records, &minimum.windows, model, &minimum.values, &free);
    let missing = missing.expect("a torque is missing");
    assert_eq!(missing.coordinate, coordinate);

    let knots = [0.0, 1.0, 2.0, 3.0];
    let larger = base.with(LearnedCurve::effect(coordinate, &knots, None).expect("knots"));
    let found = identify(&problem, &larger, None).expect("a fit");
    let (before, after) = (
        worst(&records, &plain.traces),
        worst(&records, &found.traces),
    );
    let (alone, with) = (
        held_out(&problem, unseen, &base),
        held_out(&problem, unseen, &larger),
    );
    println!(
        "seed {SEED}, {coordinate:?}: error {before:.2} -> {after:.2} of the noise, held out {alone:.2} -> {with:.2}"
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
