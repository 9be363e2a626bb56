//! The teeth of a motor in dense logs, through the whole diagnosis.

use diagnose::{Diagnosis, Options, Verdict, diagnose_with};
use exam::{ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Truth, record};
use identify::{FitProblem, Progress, Record, fit_until};
use plant::{EffectId, Kind, Model};

/// Three logs of 40,000 samples at 1 kHz, with teeth of this torque in N m, order and phase in rad.
fn problem(teeth: Option<[f64; 3]>, seed: u64) -> FitProblem {
    let truth = Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: teeth
            .map(|teeth| Hidden::Library(EffectId::WheelCogging, teeth.to_vec()))
            .into_iter()
            .collect(),
    };
    let noise = ChannelNoise {
        std: [1.2e-3, 4e-3, 0.6],
    };
    let plan = |name: &str, kind: Kind, angle_rad: f64, driving: DriveProgram| ExperimentPlan {
        name: name.to_owned(),
        kind,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving,
        duration_s: 40.0,
        sample_s: 0.001,
    };
    let plans = [
        plan("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
        plan("spin-up", Kind::SpinUp, 0.0, DriveProgram::Step(0.12)),
        plan("driven", Kind::Driven, 0.0, DriveProgram::Square(0.3)),
    ];
    let records = plans.iter().enumerate().map(|(index, plan)| {
        let log = record(&truth, plan, &noise, 10 * seed + index as u64);
        let outputs = log.measured.map(Some);
        let current = Some(log.current_a);
        Record::new(&plan.name, plan.kind, log.time_s, outputs, current, false)
    });
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_dense_records(records.collect(), known, Default::default()).expect("records")
}

fn diagnosed(problem: &FitProblem) -> Diagnosis {
    let (base, quiet) = (Model::base(), Progress::silent());
    let found = fit_until(problem, &base, None, &quiet).expect("a fit");
    let options = Options::default();
    diagnose_with(problem, &base, found.fit.minimum, &options, &quiet).expect("a verdict")
}

/// Few teeth and many: the order is right, and the torque within a tenth.
#[test]
fn teeth_of_dense_logs_are_counted() {
    for (seed, teeth) in [(1, [2e-3, 12.0, 0.7]), (2, [2.5e-3, 42.0, -1.0])] {
        let problem = problem(Some(teeth), seed);
        assert!(problem.shows_teeth(), "seed {seed}");
        let diagnosis = diagnosed(&problem);
        let certain = Model::base().with(EffectId::WheelCogging);
        assert_eq!(diagnosis.certain, certain, "seed {seed}");
        assert_eq!(diagnosis.verdict, Verdict::Explained, "seed {seed}");
        let last = diagnosis.steps.last().expect("a step");
        let value = |name: &str| {
            let at = certain.position_of(name).expect("a parameter");
            last.fit.values[at]
        };
        assert_eq!(value("cogging_order").round(), teeth[1], "seed {seed}");
        let torque = value("cogging_torque");
        assert!(
            (torque / teeth[0] - 1.0).abs() < 0.1,
            "seed {seed}: {torque} {teeth:?}"
        );
    }
}

/// Without teeth, dense logs are not searched for them again by fits in short windows.
#[test]
fn dense_logs_without_teeth_are_read_in_one_piece() {
    let problem = problem(None, 3);
    assert!(!problem.shows_teeth() && problem.needs_no_windows());
}
