//! Without a known torque parameters are found per unit of inertia.

use crate::common::{fitted, log, parameter, short_bench};
use crate::simulated::{Now, Physics, VALUES, coast_down, spin_up};
use identify::{FitProblem, Record, identify, without_value};
use plant::{EffectId, Kind, Model};

#[test]
fn without_a_known_torque_parameters_are_per_unit_of_inertia() {
    let records = short_bench(&Physics::base(), 2500);
    let swings: Vec<Record> = records
        .into_iter()
        .filter(|record| record.kind == Kind::FreeSwing)
        .collect();
    let problem = FitProblem::from_records(swings, [None; 4], Default::default()).expect("records");
    let found = fitted(&problem, &[]);
    let (gravity, std) = parameter(&found, "gravity_torque");
    let truth = VALUES[2] / VALUES[0];
    assert!((gravity / truth - 1.0).abs() < 1e-3, "{gravity} ± {std}");
    let position = found.fit.model.position_of("gravity_torque").expect("base");
    assert!(
        problem
            .unit(&found.fit.model, position)
            .ends_with("per kg m2")
    );
    assert!(
        found
            .statements
            .iter()
            .any(|s| s.contains("per unit of inertia"))
    );
}

/// A geared motor's light wheel: 4,000 N m/A per kg m2, and its speed in 50 ms.
#[test]
fn a_torque_constant_per_unit_of_a_small_inertia_is_within_its_bounds() {
    let physics = Physics {
        values: [VALUES[0], 1e-5, VALUES[2], 0.04, VALUES[4], 2e-4],
        ..Physics::base()
    };
    let spin_up = spin_up("spin-up", &|_| 1.0, 1.0);
    let problem = FitProblem::from_records(
        vec![log(&physics, &spin_up, 2608)],
        [None; 4],
        Default::default(),
    )
    .expect("records");
    let found = fitted(&problem, &[]);
    for (name, truth) in [
        ("torque_constant", 4000.0),
        ("wheel_viscous_friction", 20.0),
    ] {
        let (value, std) = parameter(&found, name);
        assert!((value - truth).abs() < 4.0 * std, "{name}: {value} ± {std}");
        assert!(std < 0.02 * truth, "{name}: {value} ± {std}");
    }
    let on_bounds = |statement: &String| statement.contains("bound");
    assert!(
        !found.statements.iter().any(on_bounds),
        "{:?}",
        found.statements
    );
}

/// The back-EMF constant is the torque constant, and stands per unit of inertia where that does: so do the
/// voltage and the resistance, and only their ratios to it mean anything.
#[test]
fn a_supply_limit_without_a_known_torque_is_per_unit_of_inertia() {
    let records = vec![log(
        &Physics::base(),
        &spin_up("spin-up", &|_| 0.5, 5.0),
        2607,
    )];
    let model = Model::base().with(EffectId::BackEmfLimit);
    let starts = |known: [Option<f64>; 4]| {
        let problem =
            FitProblem::from_records(records.clone(), known, Default::default()).expect("records");
        let base: Vec<f64> = problem.start_values(&model)[..4].to_vec();
        let base = [base[0], base[1], base[2], base[3]];
        let position = model.position(EffectId::BackEmfLimit).expect("added");
        let unit = problem.unit(&model, position);
        let starts = problem.starts(&problem.all_records(), EffectId::BackEmfLimit, &base);
        // The speed at which no current is left, rad/s, and the current that is left at standstill, A.
        let ends: Vec<(f64, f64)> = starts
            .iter()
            .map(|start| (start[0] / base[3], start[0] / start[1]))
            .collect();
        (unit, ends)
    };
    let (unit, known) = starts([None, None, None, Some(VALUES[3])]);
    assert_eq!(unit, "V");
    let (unit, per_inertia) = starts([None; 4]);
    assert_eq!(unit, "V per kg m2");
    assert_eq!(known.len(), per_inertia.len());
    for ((speed, current), (speed_per, current_per)) in known.iter().zip(&per_inertia) {
        assert!(
            (current_per / current - 1.0).abs() < 0.05,
            "{current} {current_per} A"
        );
        assert!(
            (speed_per / speed - 1.0).abs() < 0.05,
            "{speed} {speed_per} rad/s"
        );
    }
}

#[test]
fn a_spin_up_whose_current_nobody_wrote_down_gives_its_time_constant() {
    let current = |_: f64| 0.7;
    for seed in 2600..2604 {
        let mut record = log(&Physics::base(), &spin_up("spin-up", &current, 20.0), seed);
        let speed = record.channels.remove(0).samples;
        let outputs = [None, None, Some(speed)];
        let record = Record::new("spin-up", Kind::SpinUp, record.time_s, outputs, None, false);
        let known = [None, None, None, Some(VALUES[3])];
        let problem =
            FitProblem::from_records(vec![record], known, Default::default()).expect("a record");
        let found = fitted(&problem, &[]);
        let (friction, _) = parameter(&found, "wheel_viscous_friction");
        let (inertia, _) = parameter(&found, "wheel_inertia");
        let ratio = (friction / inertia) / (VALUES[5] / VALUES[1]);
        assert!((ratio - 1.0).abs() < 0.02, "seed {seed}: {ratio}");
        assert!(found.traces[0][0].rmse < 1.1 * 0.6, "seed {seed}");
        assert!(
            found
                .statements
                .iter()
                .any(|s| s.contains("per unit of inertia")),
            "{:?}",
            found.statements
        );
    }
}

/// Without a current, a stated torque constant tells nothing of the size of a torque, and a current offset shows only as
/// a torque. With the wheel's inertia both do.
#[test]
fn a_coast_down_gives_no_current_without_the_torque_constant_and_the_inertia() {
    let offset = |_: &crate::simulated::Now| -2e-3;
    let physics = Physics {
        on_wheel: &offset,
        ..Physics::base()
    };
    let mut logged = log(&physics, &coast_down("coast-down"), 2609);
    let speed = logged.channels.remove(0).samples;
    let no_current = Some(vec![0.0; speed.len()]);
    let outputs = [None, None, Some(speed)];
    let time_s = logged.time_s;
    let records = vec![Record::new(
        "coast-down",
        Kind::SpinUp,
        time_s,
        outputs,
        no_current,
        false,
    )];
    let fit = |known: [Option<f64>; 4]| {
        let problem =
            FitProblem::from_records(records.clone(), known, Default::default()).expect("a record");
        let model = Model::base().with(EffectId::CurrentOffset);
        // From a torque constant per unit of inertia and an offset of the right size: a start at no offset has no reason
        // to leave it.
        let rough = fitted(&problem, &[EffectId::CurrentOffset]);
        let mut values = rough.fit.values;
        if problem.known[3].is_none() {
            values[3] = VALUES[3] / VALUES[1];
        }
        values[model.position_of("current_offset").expect("in it")] = -0.05;
        let start = Some((values, rough.fit.minimum.windows));
        let found = identify(&problem, &model, start).expect("a fit");
        (problem, found)
    };
    for known in [[None; 4], [None, None, None, Some(VALUES[3])]] {
        let (problem, found) = fit(known);
        let friction = found.fit.model.position_of("wheel_viscous_friction");
        let unit = problem.unit(&found.fit.model, friction.expect("base"));
        assert!(unit.ends_with("per kg m2"), "{unit}");
        let position = found.fit.model.position_of("current_offset");
        let without = without_value(&problem, &found.fit);
        assert_eq!(without.len(), 1, "{without:?} {:?}", found.fit.values);
        assert_eq!(Some(without[0].position), position);
        let why = &without[0].why;
        assert!(
            why.contains("torque_constant and wheel_inertia under [known]"),
            "{why}"
        );
        let says = |statement: &String| statement.contains("current_offset has no value by itself");
        assert!(found.statements.iter().any(says), "{:?}", found.statements);
    }
    let (problem, found) = fit([None, Some(VALUES[1]), None, Some(VALUES[3])]);
    assert_eq!(without_value(&problem, &found.fit), []);
    let (value, std) = parameter(&found, "current_offset");
    let truth = -2e-3 / VALUES[3];
    assert!(
        (value - truth).abs() < 4.0 * std.max(1e-3 * truth.abs()),
        "{value} ± {std}"
    );
}

/// Without a known torque the amplitude of the cogging is per unit of the wheel's inertia, and its order and phase, which
/// are no torques, keep their units.
#[test]
fn teeth_have_no_unit_and_their_torque_is_per_unit_of_inertia() {
    let spin_up = spin_up("spin-up", &|_| 0.5, 1.0);
    let records = vec![log(&Physics::base(), &spin_up, 2609)];
    let model = Model::base().with(EffectId::WheelCogging);
    let units = |known: [Option<f64>; 4]| {
        let problem =
            FitProblem::from_records(records.clone(), known, Default::default()).expect("records");
        ["cogging_torque", "cogging_order", "cogging_phase"].map(|name| {
            let position = model.position_of(name).expect("a parameter");
            problem.unit(&model, position)
        })
    };
    assert_eq!(units([None; 4]), ["N m per kg m2", "1", "rad"]);
    let torque_constant = [None, None, None, Some(VALUES[3])];
    assert_eq!(units(torque_constant), ["N m", "1", "rad"]);
}

/// Friction that falls while the wheel starts, in one spin-up at one current: only the shape of the start tells the
/// inertia, and the reader is told how roughly. A coast-down tells the friction, and with it the inertia.
#[test]
fn an_inertia_that_is_known_roughly_is_said_to_be() {
    let stribeck = |now: &Now| {
        let speed = now.wheel_speed;
        (2e-3 + 3e-3 * (-(speed / 6.0).powi(2)).exp()) * -(speed / 0.1).tanh()
    };
    let physics = Physics {
        on_wheel: &stribeck,
        ..Physics::base()
    };
    let current = |time: f64| if time < 0.5 { 0.0 } else { 0.4 };
    let start = log(&physics, &spin_up("start", &current, 6.0), 4242);
    let coast = log(&physics, &coast_down("coast-down"), 4243);
    let rough = |records: Vec<Record>| {
        let known = [None, None, None, Some(VALUES[3])];
        let problem =
            FitProblem::from_records(records, known, Default::default()).expect("records");
        let found = fitted(&problem, &[EffectId::WheelStribeckFriction]);
        let (value, std) = parameter(&found, "wheel_inertia");
        let says = |statement: &String| {
            statement.starts_with("wheel_inertia = ") && statement.contains("% only")
        };
        (std / value, found.statements.iter().any(says))
    };
    let (share, is_said) = rough(vec![start.clone()]);
    assert!((0.1..1.0).contains(&share) && is_said, "{share} {is_said}");
    let (share, is_said) = rough(vec![start, coast]);
    assert!(share < 0.1 && !is_said, "{share} {is_said}");
}
