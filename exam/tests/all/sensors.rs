//! Lags and delays of sensors through the whole diagnosis. If the logs distinguish them from lags and delays of the
//! motor, they are named; otherwise the verdict is a tie and names the experiment that would settle it.

use diagnose::{Diagnosis, Options, Verdict, diagnose_with};
use exam::{ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Truth, record};
use identify::{FitProblem, Progress, Record, fit_until};
use plant::{EffectId, Kind, Model};

const NOISE: ChannelNoise = ChannelNoise {
    std: [1e-3, 5e-3, 0.5],
};

fn truth(effect: EffectId, parameters: Vec<f64>) -> Truth {
    Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: vec![Hidden::Library(effect, parameters)],
    }
}

fn plan(name: &str, kind: Kind, angle_rad: f64, driving: DriveProgram) -> ExperimentPlan {
    ExperimentPlan {
        name: name.to_owned(),
        kind,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving,
        duration_s: if kind == Kind::FreeSwing { 12.0 } else { 4.0 },
        sample_s: 0.005,
    }
}

fn problem(truth: &Truth, plans: &[ExperimentPlan], seed: u64) -> FitProblem {
    let records = plans.iter().enumerate().map(|(index, plan)| {
        let log = record(truth, plan, &NOISE, seed + index as u64);
        let outputs = log.measured.clone().map(Some);
        let current = Some(log.current_a.clone());
        Record::new(
            &plan.name,
            plan.kind,
            log.time_s.clone(),
            outputs,
            current,
            false,
        )
    });
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_records(records.collect(), known, Default::default()).expect("records")
}

fn diagnosed(problem: &FitProblem) -> Diagnosis {
    let (base, quiet) = (Model::base(), Progress::silent());
    let found = fit_until(problem, &base, None, &quiet).expect("a fit");
    diagnose_with(
        problem,
        &base,
        found.fit.minimum,
        &Options::default(),
        &quiet,
    )
    .expect("done")
}

fn clamped() -> Vec<ExperimentPlan> {
    vec![
        plan("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
        plan("up", Kind::SpinUp, 0.0, DriveProgram::Step(0.6)),
        plan("down", Kind::SpinUp, 0.0, DriveProgram::Step(-0.4)),
    ]
}

/// With the body clamped, a filtered wheel speed and a lag of the motor give the same log: the verdict names both.
#[test]
fn a_filtered_wheel_speed_is_no_motor_lag_for_certain() {
    let seed = 411;
    let truth = truth(EffectId::WheelSpeedLag, vec![0.03]);
    let found = diagnosed(&problem(&truth, &clamped(), seed));
    let sets = &found.ambiguous_between;
    assert_eq!(found.verdict, Verdict::Ambiguous, "seed {seed}: {sets:?}");
    for effect in [EffectId::WheelSpeedLag, EffectId::MotorLag] {
        assert!(sets.contains(&vec![effect]), "seed {seed}: {sets:?}");
    }
    let next = found.next_experiment;
    assert!(next.contains("body hanging free"), "{next}");
}

/// A body that hangs free feels the torque at once and so distinguishes a late sensor from a late motor.
#[test]
fn a_free_body_tells_the_sensor_from_the_motor() {
    let seed = 421;
    let mut plans = clamped();
    plans.push(plan("driven", Kind::Driven, 0.0, DriveProgram::Square(0.4)));
    for (effect, parameters) in [
        (EffectId::WheelSpeedLag, vec![0.03]),
        (EffectId::WheelSpeedDelay, vec![0.02]),
        (EffectId::MotorLag, vec![0.03]),
        (EffectId::RateDelay, vec![0.015]),
    ] {
        let found = diagnosed(&problem(&truth(effect, parameters), &plans, seed));
        assert_eq!(found.verdict, Verdict::Explained, "seed {seed}: {effect:?}");
        assert_eq!(found.certain_effects(), [effect], "seed {seed}");
    }
}
