//! Columns that are not what bench.toml takes them for: another quantity, another zero, another unit than their name
//! says.

use std::f64::consts::{PI, TAU};
use std::fs;

use data_check::{Finding, FindingId, Severity, check, propose};

use crate::simulated::{Log, Numbers};

/// The findings about the log with this index, after `spoil`, as refusals or warnings with their remedies.
fn found_in(seed: u64, index: usize, spoil: impl Fn(&mut Log)) -> Vec<Finding> {
    let numbers = Numbers::random(seed);
    let mut logs = numbers.logs();
    spoil(&mut logs[index]);
    let name = logs[index].name;
    let mut found = check(&numbers.bench(&logs));
    found.retain(|finding| finding.experiment.as_deref() == Some(name));
    found
}

fn assert_refused(found: &[Finding], id: FindingId, fix: &str) {
    let fits = |finding: &Finding| {
        finding.finding == id && finding.severity == Severity::Refuse && finding.fix.contains(fix)
    };
    assert!(found.iter().any(fits), "{id:?} {fix} not in {found:#?}");
}

#[test]
fn a_driven_angle_that_is_counted_from_upright() {
    for seed in 0..4 {
        let found = found_in(seed, 7, |log| {
            log.column("angle_rad").iter_mut().for_each(|x| *x -= PI);
        });
        assert_refused(
            &found,
            FindingId::AngleZero,
            "offset = { angle = 3.14159265 }",
        );
    }
}

#[test]
fn angle_and_rate_swapped() {
    for seed in 0..4 {
        for index in [0, 7] {
            let found = found_in(seed, index, |log| {
                let angle = log.column("angle_rad").clone();
                let rate = std::mem::replace(log.column("rate_rad_s"), angle);
                *log.column("angle_rad") = rate;
            });
            assert_refused(
                &found,
                FindingId::RateFactor,
                "each with the other's column",
            );
        }
    }
}

/// The wheel's angle within one turn, in the place of its speed, in three units of a turn.
#[test]
fn the_angle_of_the_wheel_in_the_place_of_its_speed() {
    for (turn, unit) in [
        (TAU, "wheel_angle"),
        (360.0, "units = { wheel_angle = \"deg\" }"),
        (4096.0, "1.533981e-3"),
    ] {
        let found = found_in(1, 3, |log| {
            let speed = log.column("wheel_speed_rad_s").clone();
            let mut angle = 0.0;
            let turned = speed.iter().map(|speed| {
                // Fewer turns a second than the wheel makes: the log of a wheel at 400 rad/s has 100 samples a second.
                angle += 0.01 * 0.2 * speed;
                (angle / TAU * turn).rem_euclid(turn)
            });
            *log.column("wheel_speed_rad_s") = turned.collect();
        });
        assert_refused(&found, FindingId::Wrapped, unit);
    }
}

#[test]
fn a_name_that_says_another_unit_and_one_that_says_none() {
    // The swing of 35 degrees tells its unit by its period; that of 15 degrees does not.
    let renamed = |log: &mut Log, name: &'static str| {
        log.columns.truncate(2);
        log.columns[1].0 = name;
        log.more = format!("columns = {{ angle = \"{name}\" }}");
    };
    let found = found_in(0, 1, |log| renamed(log, "pend_deg"));
    assert_refused(
        &found,
        FindingId::UnitUnstated,
        "units = { angle = \"deg\" }",
    );
    let found = found_in(0, 1, |log| renamed(log, "pend_rad"));
    assert_eq!(found, []);
    let found = found_in(0, 1, |log| renamed(log, "pend"));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (found[0].finding, found[0].severity),
        (FindingId::UnitUnstated, Severity::Warn)
    );
    let found = found_in(0, 1, |log| {
        renamed(log, "pend");
        log.more.push_str("\nunits = { angle = \"rad\" }");
    });
    assert_eq!(found, []);
}

/// A driven angle in degrees without the wheel's speed, as large as no pendulum of this kind turns.
#[test]
fn a_driven_angle_in_degrees_without_the_wheel() {
    for seed in 0..4 {
        let found = found_in(seed, 7, |log| {
            log.scale("angle_rad", 180.0 / PI);
            log.columns
                .retain(|(name, _)| ["time_s", "angle_rad", "current_A"].contains(name));
        });
        assert_refused(
            &found,
            FindingId::AngleFactor,
            "units = { angle = \"deg\" }",
        );
    }
    // No pendulum at all.
    for index in [0, 7] {
        let found = found_in(0, index, |log| {
            let time = log.column("time_s").clone();
            *log.column("angle_rad") = time.iter().map(|t| 200.0 * (3.0 * t).sin()).collect();
            log.columns
                .retain(|(name, _)| ["time_s", "angle_rad", "current_A"].contains(name));
        });
        assert!(
            found
                .iter()
                .any(|finding| finding.finding == FindingId::AngleFactor
                    && finding.severity == Severity::Refuse),
            "{found:#?}"
        );
    }
}

/// A command in the place of a current is asked about, and no current is made up.
#[test]
fn a_pulse_width_is_no_current() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    let mut text = "time_s,angle_rad,wheel_speed_rad_s,pwm\n".to_owned();
    for k in 0..2000 {
        let time = 0.005 * f64::from(k);
        let (angle, wheel) = (0.5 * (9.0 * time).sin(), 80.0 * (4.0 * time).cos());
        let pwm = if (4.0 * time).sin() > 0.0 { 120 } else { -120 };
        text.push_str(&format!("{time:.3},{angle:.5},{wheel:.3},{pwm}\n"));
    }
    fs::write(&file, text).expect("a log");
    let proposal = propose(folder.path(), &[file]).expect("a proposal");
    let questions = &proposal.experiments[0].questions;
    assert!(
        questions.iter().any(|one| one.contains("\"pwm\"")),
        "{questions:?}"
    );
    assert!(
        !proposal.text.contains("\nconstants = {"),
        "{}",
        proposal.text
    );
}

/// A command without unit may be as large as its converter counts: a duty of 255 is not a current in mA.
#[test]
fn a_duty_in_counts_is_not_too_large_a_current() {
    for seed in 0..4 {
        let mut numbers = Numbers::random(seed);
        let mut log = numbers.logs().remove(3);
        let most = log
            .column("current_A")
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let per_unit = 255.0 / most;
        log.column("current_A")
            .iter_mut()
            .for_each(|x| *x *= per_unit);
        numbers.torque_constant /= per_unit;
        log.more = "units = { current = \"1\" }".to_owned();
        let is_it = |one: &Finding| one.finding == FindingId::CurrentFactor;
        let found = check(&numbers.bench(std::slice::from_ref(&log)));
        assert!(!found.iter().any(is_it), "seed {seed}: {found:#?}");
        // The same numbers in ampere are too large.
        log.more = String::new();
        let found = check(&numbers.bench(&[log]));
        assert!(found.iter().any(is_it), "seed {seed}: {found:#?}");
    }
}
