//! Logs of real rigs that are awkward to diagnose: a swing of a few periods, a contact that acts as a spring, a wheel that
//! no current drives.

use crate::thesis_bench::diagnosed;
use diagnose::Diagnosis;
use exam::{ChannelNoise, DriveProgram, ExperimentPlan, Hidden, Truth, record};
use identify::{FitProblem, Identification, Record, identify};
use plant::{EffectId, Kind, Model, Output};

/// The log of a body that is let go, with these channels.
fn let_go(
    truth: &Truth,
    (kind, angle_rad): (Kind, f64),
    [duration_s, sample_s]: [f64; 2],
    std: [f64; 3],
    shown: &[Output],
    seed: u64,
) -> Record {
    let plan = ExperimentPlan {
        name: "swing".to_owned(),
        kind,
        angle_rad,
        wheel_speed_rad_s: 0.0,
        driving: DriveProgram::None,
        duration_s,
        sample_s,
    };
    let log = record(truth, &plan, &ChannelNoise { std }, seed);
    let [angle, rate, wheel_speed] = log.measured;
    let measured = [
        (Output::Angle, angle),
        (Output::Rate, rate),
        (Output::WheelSpeed, wheel_speed),
    ];
    let outputs = measured.map(|(output, samples)| shown.contains(&output).then_some(samples));
    let current = vec![0.0; log.time_s.len()];
    Record::new("swing", kind, log.time_s, outputs, Some(current), false)
}

fn problem(record: Record, gravity_torque: Option<f64>) -> FitProblem {
    let known = [None, None, gravity_torque, None];
    FitProblem::from_records(vec![record], known, Default::default()).expect("records")
}

/// Root mean square of what the last step leaves of the only series.
fn left(found: &Diagnosis) -> f64 {
    found.last().expect("a step").candidate.rmse()[0]
}

/// A contact that bends by a tenth of the swing before it slips is, for the most part, a spring that is lost as the swing
/// grows. Dry friction without the spring promises next to nothing beside a softening spring, and is still the way to
/// the answer.
#[test]
fn presliding_is_found_where_dry_friction_alone_promises_little() {
    let truth = Truth {
        base: [3.2e-3, 1e-4, 0.237, 0.03],
        body_viscous: 1e-4,
        wheel_viscous: 1e-5,
        hidden: vec![Hidden::Library(
            EffectId::BodyPreslidingFriction,
            vec![5e-3, 0.09],
        )],
    };
    for seed in 9100..9104 {
        let std = [1.8e-3, 0.0, 0.0];
        let swing = (Kind::FreeSwing, 0.5);
        let log = let_go(&truth, swing, [15.0, 0.01], std, &[Output::Angle], seed);
        let found = diagnosed(&problem(log, None));
        let added = found.certain_effects();
        assert_eq!(added, [EffectId::BodyPreslidingFriction], "seed {seed}");
        assert!(left(&found) < 1.1 * std[0], "seed {seed}: {}", left(&found));
    }
}

/// Six periods of a cube on an edge, with the zero of its angle a little off. Neither dry friction nor the offset takes
/// enough away to outweigh its own parameter with so few independent values; both together leave the noise.
#[test]
fn two_effects_are_found_in_a_swing_of_a_few_periods() {
    let truth = Truth {
        base: [8.67e-3, 1e-4, 0.6254, 0.03],
        body_viscous: 3e-3,
        wheel_viscous: 1e-5,
        hidden: vec![
            Hidden::Library(EffectId::BodyCoulombFriction, vec![0.02]),
            Hidden::Library(EffectId::AngleOffset, vec![0.03]),
        ],
    };
    for seed in 9200..9204 {
        let std = [5e-3, 0.0, 0.0];
        let swing = (Kind::FreeSwing, 0.7);
        let log = let_go(&truth, swing, [5.0, 0.005], std, &[Output::Angle], seed);
        let found = diagnosed(&problem(log, None));
        let added = found.last().expect("a step").candidate.set();
        let expected = [EffectId::BodyCoulombFriction, EffectId::AngleOffset];
        assert_eq!(added, expected, "seed {seed}");
        assert!(left(&found) < 1.1 * std[0], "seed {seed}: {}", left(&found));
    }
}

/// A wheel that turns freely on a swinging body shows r_w/j_w, and the body G/(Θ − j_w); j_w itself shows only in the
/// friction of the wheel's bearing, which is a small part of the body's.
#[test]
fn a_swing_with_a_free_wheel_is_identified_although_its_inertia_is_open() {
    let truth = Truth {
        base: [5.6e-3, 3e-4, 0.353, 0.03],
        body_viscous: 2e-4,
        wheel_viscous: 3e-5,
        hidden: vec![],
    };
    let all = [Output::Angle, Output::Rate, Output::WheelSpeed];
    let value = |found: &Identification, name: &str| {
        let at = found.fit.model.position_of(name).expect("base");
        found.fit.values[at]
    };
    for (seed, shown) in [(9300, &all[..]), (9301, &[all[0], all[2]])] {
        for known in [None, Some(truth.base[2])] {
            let swing = (Kind::Driven, 1.0);
            let std = [2e-3, 8e-3, 0.15];
            let log = let_go(&truth, swing, [20.0, 0.005], std, shown, seed);
            let found = identify(&problem(log, known), &Model::base(), None)
                .unwrap_or_else(|error| panic!("seed {seed}, G {known:?}: {error}"));
            let wheel = value(&found, "wheel_inertia");
            let body = value(&found, "total_inertia") - wheel;
            let square = value(&found, "gravity_torque") / body;
            let expected = truth.base[2] / (truth.base[0] - truth.base[1]);
            assert!((square / expected - 1.0).abs() < 2e-3, "seed {seed}");
            let decay = value(&found, "wheel_viscous_friction") / wheel;
            let expected = truth.wheel_viscous / truth.base[1];
            assert!((decay / expected - 1.0).abs() < 0.1, "seed {seed}: {decay}");
            let is_said = |one: &String| one.contains("how the wheel answers to a current");
            let wheel_std = found.fit.std(plant::WHEEL_INERTIA);
            let is_open = wheel_std.is_none_or(|std| std >= wheel);
            assert_eq!(found.statements.iter().any(is_said), is_open, "seed {seed}");
        }
    }
}
