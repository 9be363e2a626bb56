//! Where a model fails is named by the right coordinate and place, and nowhere else.

use crate::simulated::{self, Now, Physics, bench, data, nothing, problem};
use identify::{Coordinate, FailureMap, FitProblem, ResidualKind, breakdown, identify};
use plant::{EffectId, Model};

/// Fits the base model and `effects`, and breaks what remains down.
fn failure_map(problem: &FitProblem, effects: &[EffectId]) -> FailureMap {
    let model = effects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    let found = identify(problem, &model, None).expect("a fit");
    breakdown(
        &problem.records,
        &found.fit.minimum.windows,
        &found.traces,
        &model,
        &found.fit.values,
    )
}

fn describe(map: &FailureMap) -> String {
    let mut text = String::new();
    for e in &map.explained {
        text += &format!(
            "{:?} {} {:.3} z {:.1}\n",
            e.on,
            e.coordinate.name(),
            e.share,
            e.significance
        );
    }
    for r in &map.regions {
        text += &format!(
            "{} {} {:?} {} {:.3}..{:.3} share {:.2} size {:.1} {}\n",
            r.experiment,
            r.channel,
            r.quantity,
            r.coordinate.name(),
            r.from,
            r.to,
            r.share_of_error,
            r.size,
            r.is_significant
        );
    }
    text
}

/// A magnet near `place`: it pulls towards its side and pushes away on the other.
fn magnet(angle: f64, place: f64, width: f64, size: f64) -> f64 {
    let z = (angle - place) / width;
    size * z * (-z * z).exp()
}

const DRY: f64 = 3e-4;

fn dry(now: &Now) -> f64 {
    -DRY * (now.rate / 0.01).tanh()
}

#[test]
fn a_magnet_is_found_at_its_angle() {
    for (seed, place) in [(1, -0.22), (2, 0.1), (3, 0.28)] {
        let on_body = |now: &Now| dry(now) + magnet(now.angle, place, 0.06, 0.004);
        let physics = Physics {
            on_body: &on_body,
            ..Physics::base()
        };
        let map = failure_map(
            &problem(bench(&physics, seed)),
            &[EffectId::BodyCoulombFriction],
        );
        let top = &map.regions[0];
        let said = describe(&map);
        assert_eq!(top.coordinate, Coordinate::Angle, "seed {seed}\n{said}");
        assert_eq!(top.channel, "angle", "seed {seed}\n{said}");
        // It reaches its extremes at 0.71 widths to both sides.
        assert!(top.from < place && place < top.to, "seed {seed}\n{said}");
        assert!(top.to - top.from < 4.0 * 0.06, "seed {seed}\n{said}");
        assert!(
            (0.5 * (top.from + top.to) - place).abs() < 0.06,
            "seed {seed}\n{said}"
        );
        assert!(top.share_of_error > 0.6, "seed {seed}\n{said}");
    }
}

#[test]
fn every_kind_of_missing_torque_is_named_by_its_coordinate() {
    let drag = |now: &Now| -2.5e-5 * now.rate * now.rate.abs();
    let drifting = |now: &Now| dry(now) * (1.0 + now.time_s / 10.0);
    let rubbing = |now: &Now| {
        let beyond = 1.0 / (1.0 + (-(now.angle - 0.25) / 0.01).exp());
        dry(now) + 3.0 * dry(now) * beyond
    };
    let dry_wheel = |now: &Now| -1.2e-3 * now.wheel_speed.tanh();
    let cogging = |now: &Now| 6e-4 * (6.0 * now.wheel_angle + 0.4).sin();
    let coulomb = [EffectId::BodyCoulombFriction];
    type Case<'a> = (
        &'a str,
        simulated::Torque<'a>,
        simulated::Torque<'a>,
        &'a [EffectId],
        Coordinate,
        &'a str,
    );
    let cases: [Case; 6] = [
        ("dry pivot", &dry, &nothing, &[], Coordinate::Rate, "angle"),
        ("air drag", &drag, &nothing, &[], Coordinate::Rate, "angle"),
        (
            "drift",
            &drifting,
            &nothing,
            &coulomb,
            Coordinate::Time,
            "angle",
        ),
        (
            "rubbing",
            &rubbing,
            &nothing,
            &coulomb,
            Coordinate::Angle,
            "angle",
        ),
        (
            "dry wheel",
            &nothing,
            &dry_wheel,
            &[],
            Coordinate::WheelSpeed,
            "wheel_speed",
        ),
        (
            "cogging",
            &nothing,
            &cogging,
            &[],
            Coordinate::WheelAngle,
            "wheel_speed",
        ),
    ];
    for (seed, (name, on_body, on_wheel, effects, coordinate, channel)) in cases.iter().enumerate()
    {
        let physics = Physics {
            on_body: *on_body,
            on_wheel: *on_wheel,
            ..Physics::base()
        };
        let map = failure_map(&problem(bench(&physics, 100 + seed as u64)), effects);
        let top = &map.regions[0];
        let said = format!("{name}, seed {}\n{}", 100 + seed, describe(&map));
        assert!(top.is_significant, "{said}");
        assert_eq!(top.quantity, ResidualKind::ResidualTorque, "{said}");
        assert_eq!(
            (top.coordinate, top.channel),
            (*coordinate, *channel),
            "{said}"
        );
    }
}

#[test]
fn the_right_model_fails_nowhere_and_still_says_where_its_error_is_largest() {
    let (mut significant, mut tried) = (0, 0);
    for seed in 0..8 {
        let physics = Physics {
            on_body: &dry,
            ..Physics::base()
        };
        let map = failure_map(
            &problem(bench(&physics, 1000 + seed)),
            &[EffectId::BodyCoulombFriction],
        );
        assert!(!map.regions.is_empty());
        if map.regions[0].is_significant {
            eprintln!("seed {}\n{}", 1000 + seed, describe(&map));
        }
        significant += usize::from(map.regions[0].is_significant);
        tried += 1;
    }
    assert!(
        significant <= 1,
        "{significant} of {tried}, seeds 1000..1008"
    );
}

#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn the_unknown_magnet_of_the_reference_bench_is_found_near_its_angle() {
    let bench = bench_files::Bench::load(&data("hidden/f-unknown-magnet")).expect("a bench");
    let problem = FitProblem::new(&bench).expect("records");
    let map = failure_map(&problem, &[EffectId::BodyCoulombFriction]);
    let top = &map.regions[0];
    let said = describe(&map);
    assert_eq!(
        (top.coordinate, top.channel),
        (Coordinate::Angle, "angle"),
        "{said}"
    );
    assert!(top.from < 0.15 && 0.15 < top.to, "{said}");
    assert!((0.5 * (top.from + top.to) - 0.15).abs() < 0.03, "{said}");
    assert!(top.to - top.from < 0.2, "{said}");
}
