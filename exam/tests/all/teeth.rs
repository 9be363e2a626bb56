//! The teeth of a motor in dense logs, through the whole diagnosis.

use diagnose::Verdict;
use exam::{DriveProgram, Hidden};
use identify::FitProblem;
use plant::{EffectId, Kind, Model};

use crate::thesis_bench::{Planned, diagnosed, logs, truth};

const PLANNED: [Planned; 3] = [
    ("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
    ("spin-up", Kind::SpinUp, 0.0, DriveProgram::Step(0.12)),
    ("driven", Kind::Driven, 0.0, DriveProgram::Square(0.3)),
];

/// Three logs of 40,000 samples at 1 kHz, with teeth of this torque in N m, order and phase in rad.
fn problem(teeth: Option<[f64; 3]>, seed: u64) -> FitProblem {
    problem_of(&PLANNED, teeth, seed)
}

/// As [`problem`], of these experiments.
fn problem_of(planned: &[Planned], teeth: Option<[f64; 3]>, seed: u64) -> FitProblem {
    let hidden = |teeth: [f64; 3]| Hidden::Library(EffectId::WheelCogging, teeth.to_vec());
    let truth = truth(teeth.map(hidden));
    let records = logs(&truth, planned, [40.0, 0.001], seed);
    let known = [None, None, Some(truth.base[2]), Some(truth.base[3])];
    FitProblem::from_dense_records(records, known, Default::default()).expect("records")
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

/// Many logs, of which fewer windows count each, tell order and torque as well. Every log begins at a tooth of its own and
/// is turned to the others' teeth, so that the phase contradicts nothing.
#[test]
fn many_dense_logs_are_explained_by_their_teeth() {
    let spin_up = |name, current_a| (name, Kind::SpinUp, 0.0, DriveProgram::Step(current_a));
    let driven = |name, current_a| (name, Kind::Driven, 0.0, DriveProgram::Square(current_a));
    let planned = [
        ("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
        spin_up("slow", 0.06),
        spin_up("faster", 0.09),
        spin_up("fast", 0.12),
        spin_up("back", -0.1),
        driven("driven", 0.2),
        driven("driven more", 0.4),
    ];
    for (seed, teeth) in [(11, [1.2e-3, 7.0, -2.0]), (12, [2e-3, 12.0, 0.2])] {
        let problem = problem_of(&planned, Some(teeth), seed);
        let diagnosis = diagnosed(&problem);
        let certain = Model::base().with(EffectId::WheelCogging);
        assert_eq!(diagnosis.certain, certain, "seed {seed}");
        assert_eq!(diagnosis.verdict, Verdict::Explained, "seed {seed}");
        let fit = &diagnosis.last().expect("a step").fit;
        let at = |name: &str| certain.position_of(name).expect("a parameter");
        let order = fit.values[at("cogging_order")];
        assert_eq!(order.round(), teeth[1], "seed {seed}");
        let torque = fit.values[at("cogging_torque")];
        let std = fit.std(at("cogging_torque")).expect("a standard error");
        let sigmas = (torque - teeth[0]).abs() / std;
        assert!(sigmas < 4.0, "seed {seed}: {torque} ± {std}, {sigmas}");
    }
}
