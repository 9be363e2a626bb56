//! Benches on which no torque is known, only torques per unit of inertia, through the whole diagnosis.

use diagnose::{Options, Verdict, diagnose_with};
use exam::{ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Truth, record};
use identify::{FitProblem, Progress, Record, fit_until};
use plant::{EffectId, Kind, Model};

/// A dry pivot is dry friction and no Stribeck curve, where a driven wheel shows body and wheel in one unknown scale. The
/// logs then determine the ratios of the torques many orders better than the inertias.
#[test]
fn dry_friction_of_unknown_scale_is_no_stribeck_curve() {
    let truth = Truth {
        base: [2.30344e-3, 1.36125e-4, 0.245158, 0.0335],
        body_viscous: 2.12e-5,
        wheel_viscous: 1.75204e-5,
        hidden: vec![Hidden::Library(
            EffectId::BodyCoulombFriction,
            vec![4.485e-4],
        )],
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
        duration_s: 12.0,
        sample_s: 0.005,
    };
    let plans = [
        plan("swing", Kind::FreeSwing, 0.7, DriveProgram::None),
        plan("driven", Kind::Driven, 0.0, DriveProgram::Square(0.5)),
    ];
    for seed in [5, 6] {
        let records = plans.iter().enumerate().map(|(index, plan)| {
            let log = record(&truth, plan, &noise, 10 * seed + index as u64);
            let outputs = log.measured.map(Some);
            let current = Some(log.current_a);
            Record::new(&plan.name, plan.kind, log.time_s, outputs, current, false)
        });
        let known = [None; 4];
        let problem = FitProblem::from_records(records.collect(), known, Default::default())
            .expect("records");
        let (base, quiet) = (Model::base(), Progress::silent());
        let found = fit_until(&problem, &base, None, &quiet).expect("a fit");
        let options = Options::default();
        let diagnosis =
            diagnose_with(&problem, &base, found.fit.minimum, &options, &quiet).expect("a verdict");
        assert_eq!(diagnosis.verdict, Verdict::Explained, "seed {seed}");
        let certain = Model::base().with(EffectId::BodyCoulombFriction);
        assert_eq!(diagnosis.certain, certain, "seed {seed}");
    }
}
