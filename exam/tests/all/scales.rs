//! Benches on which no torque is known, only torques per unit of inertia, through the whole diagnosis.

use diagnose::Verdict;
use exam::{DriveProgram, Hidden};
use identify::FitProblem;
use plant::{EffectId, Kind, Model};

use crate::thesis_bench::{Planned, diagnosed, logs, truth};

const PLANNED: [Planned; 2] = [
    ("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
    ("driven", Kind::Driven, 0.0, DriveProgram::Square(0.5)),
];

/// A dry pivot is dry friction and no Stribeck curve, where a driven wheel shows body and wheel in one unknown scale. The
/// logs then determine the ratios of the torques many orders better than the inertias.
#[test]
fn dry_friction_of_unknown_scale_is_no_stribeck_curve() {
    let dry = Hidden::Library(EffectId::BodyCoulombFriction, vec![4.485e-4]);
    let truth = truth(Some(dry));
    for seed in [5, 6] {
        let records = logs(&truth, &PLANNED, [12.0, 0.005], seed);
        let problem =
            FitProblem::from_records(records, [None; 4], Default::default()).expect("records");
        let diagnosis = diagnosed(&problem);
        assert_eq!(diagnosis.verdict, Verdict::Explained, "seed {seed}");
        let certain = Model::base().with(EffectId::BodyCoulombFriction);
        assert_eq!(diagnosis.certain, certain, "seed {seed}");
    }
}
