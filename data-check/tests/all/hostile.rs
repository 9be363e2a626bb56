//! Faults of files that people have: each is named, with its own cause and no other.

use std::f64::consts::PI;

use data_check::{Finding, FindingId, Severity, check, propose};
use plant::Kind;

use crate::simulated::{Log, Numbers};

/// The findings about the log with this index, after `spoil`.
fn found_in(seed: u64, index: usize, spoil: impl Fn(&mut Log)) -> Vec<Finding> {
    let numbers = Numbers::random(seed);
    let mut logs = numbers.logs();
    spoil(&mut logs[index]);
    let name = logs[index].name;
    let mut found = check(&numbers.bench(&logs));
    found.retain(|finding| finding.experiment.as_deref() == Some(name));
    found
}

/// Requires that all findings are this one, with these words in its sentence or its remedy.
fn assert_only(found: &[Finding], id: FindingId, severity: Severity, words: &str) {
    assert!(!found.is_empty(), "nothing found: {id:?} {words}");
    for finding in found {
        let text = format!("{} | {}", finding.sentence, finding.fix);
        assert!(
            finding.finding == id && finding.severity == severity && text.contains(words),
            "{id:?} {words} expected: {found:#?}"
        );
    }
}

#[test]
fn columns_in_the_place_of_others_are_named_and_nothing_else() {
    for seed in 0..3 {
        let swap = |log: &mut Log, first: &str, second: &str| {
            let samples = log.column(second).clone();
            let other = std::mem::replace(log.column(first), samples);
            *log.column(second) = other;
        };
        for (index, first, second) in [
            (0, "angle_rad", "rate_rad_s"),
            (7, "angle_rad", "rate_rad_s"),
            (7, "rate_rad_s", "wheel_speed_rad_s"),
        ] {
            let found = found_in(seed, index, |log| swap(log, first, second));
            assert_only(&found, FindingId::RateFactor, Severity::Refuse, "swapped");
        }
        let found = found_in(seed, 3, |log| swap(log, "wheel_speed_rad_s", "current_A"));
        let is_named = |finding: &Finding| {
            finding.severity == Severity::Refuse && finding.sentence.contains("swapped")
        };
        assert!(found.iter().any(is_named), "{found:#?}");
    }
}

#[test]
fn a_time_that_counts_lines_needs_its_step() {
    for seed in 0..3 {
        let count = |log: &mut Log| {
            let time = log.column("time_s").iter_mut().enumerate();
            time.for_each(|(k, t)| *t = k as f64);
        };
        for index in [0, 3] {
            let found = found_in(seed, index, count);
            let refused: Vec<&Finding> = found
                .iter()
                .filter(|finding| finding.severity == Severity::Refuse)
                .collect();
            assert!(!refused.is_empty(), "{found:#?}");
            for finding in refused {
                assert!(finding.fix.contains("time_step"), "{found:#?}");
            }
        }
    }
}

/// The sign of the angle alone: gravity would seem to push the body up.
#[test]
fn an_angle_against_its_rate_has_the_wrong_sign_and_the_right_zero() {
    for seed in 0..3 {
        let found = found_in(seed, 7, |log| log.scale("angle_rad", -1.0));
        assert_only(
            &found,
            FindingId::RateFactor,
            Severity::Refuse,
            "wrong sign",
        );
    }
}

/// A hanging body with an angle that is counted from upright, taken for one that balances.
#[test]
fn a_hanging_body_that_is_said_to_balance() {
    for seed in 0..3 {
        let found = found_in(seed, 7, |log| {
            log.column("angle_rad").iter_mut().for_each(|x| *x -= PI);
            // About upright throughout, as a balanced body is.
            for (_, column) in &mut log.columns {
                column.truncate(300);
            }
            log.kind = Kind::Balance;
        });
        let is_named = |finding: &Finding| {
            finding.severity == Severity::Refuse && finding.fix.contains("kind = \"driven\"")
        };
        assert!(found.iter().any(is_named), "seed {seed}: {found:#?}");
    }
}

/// A wheel that no motor turns tells nothing, but gravity still says where the body hangs.
#[test]
fn a_free_wheel_and_a_zero_that_is_upright() {
    for seed in 0..3 {
        let spoil = |offset: f64| {
            move |log: &mut Log| {
                log.scale("current_A", 0.0);
                let rows = log.columns[0].1.len();
                for k in 0..rows {
                    // A swing of 0.2 rad at 9 rad/s, and the wheel against it.
                    let (phase, size) = (0.045 * k as f64, 0.2);
                    let wave = |x: f64| size * (x.sin() + size * size / 192.0 * (3.0 * x).sin());
                    let rate = size * 9.0 * phase.cos();
                    let noise = 1e-4 * ((k * 7919 % 13) as f64 - 6.0);
                    log.column("angle_rad")[k] = wave(phase) + offset + noise;
                    log.column("rate_rad_s")[k] = rate + noise;
                    log.column("wheel_speed_rad_s")[k] = 20.0 - rate + 10.0 * noise;
                }
            }
        };
        let found = found_in(seed, 7, spoil(0.0));
        assert_eq!(found, [], "seed {seed}");
        let found = found_in(seed, 7, spoil(-PI));
        assert_only(&found, FindingId::AngleZero, Severity::Refuse, "offset");
    }
}

/// A spreadsheet's time in days, as its users export it.
#[test]
fn a_time_in_days() {
    let found = found_in(0, 0, |log| log.scale("time_s", 1.0 / 86_400.0));
    let days = |finding: &&Finding| finding.finding == FindingId::TimeFactor;
    let finding = found.iter().find(days).expect("a time factor");
    assert!(finding.fix.contains("86400"), "{found:#?}");
}

#[test]
fn a_frozen_channel_is_named_wherever_it_stops() {
    for seed in 0..3 {
        for (index, column) in [(0, "angle_rad"), (0, "rate_rad_s"), (1, "angle_rad")] {
            // For a part of a swing, from a place off the middle; and from there to the end.
            for to_the_end in [false, true] {
                let found = found_in(seed, index, |log| {
                    let samples = log.column(column);
                    let largest = |most: f64, x: &f64| most.max(x.abs());
                    let most = samples[400..800].iter().fold(0.0, largest);
                    let from = (400..800).find(|k| samples[*k].abs() > 0.5 * most);
                    let from = from.expect("a peak");
                    let value = samples[from];
                    // The motion has gone on when the sensor comes back.
                    let mut later = from + 60..samples.len();
                    let is_elsewhere = |k: &usize| (samples[*k] - value).abs() > 0.3 * most;
                    let until = match to_the_end {
                        true => samples.len(),
                        false => later.find(is_elsewhere).expect("a swing"),
                    };
                    samples[from..until].iter_mut().for_each(|x| *x = value);
                });
                assert!(
                    found
                        .iter()
                        .any(|finding| finding.finding == FindingId::Frozen),
                    "{seed} {column} {to_the_end}: {found:#?}"
                );
            }
        }
    }
}

#[test]
fn a_channel_that_never_changes() {
    for (index, column, severity) in [
        (0, "angle_rad", Severity::Refuse),
        (0, "rate_rad_s", Severity::Refuse),
        (7, "rate_rad_s", Severity::Refuse),
        (3, "wheel_speed_rad_s", Severity::Warn),
    ] {
        let found = found_in(1, index, |log| log.scale(column, 0.0));
        let is_named = |finding: &Finding| {
            finding.finding == FindingId::Frozen && finding.severity == severity
        };
        assert!(found.iter().any(is_named), "{column}: {found:#?}");
    }
}

/// After a pause the swing may be larger: nobody knows what happened in it.
#[test]
fn a_pause_is_no_hand() {
    let found = found_in(0, 0, |log| {
        for (_, column) in &mut log.columns {
            column.drain(300..500);
        }
    });
    assert_only(
        &found,
        FindingId::TimeStamps,
        Severity::Warn,
        "a gap of more than twenty",
    );
}

/// A torque constant in mN m/A makes every inertia wrong, and is then no measure for the wheel's speed.
#[test]
fn a_known_value_out_of_scale_is_the_only_finding() {
    let mut numbers = Numbers::random(2);
    let logs = numbers.logs();
    numbers.torque_constant *= 1e3;
    let found = check(&numbers.bench(&logs));
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(found[0].finding, FindingId::KnownRange);
}

/// An angle from 0 to 360 degrees, read in radians about hanging: its jumps say the unit.
#[test]
fn a_swing_in_degrees_within_a_turn() {
    let found = found_in(0, 0, |log| {
        log.scale("angle_rad", 180.0 / std::f64::consts::PI);
        let angle = log.column("angle_rad").iter_mut();
        angle.for_each(|x| *x = x.rem_euclid(360.0));
        log.columns.retain(|(name, _)| *name != "rate_rad_s");
    });
    let is_named = |finding: &Finding| {
        finding.severity == Severity::Refuse && finding.fix.contains("units = { angle = \"deg\" }")
    };
    assert!(found.iter().any(is_named), "{found:#?}");
}

/// Where a wheel is driven and no name says by which column, nothing is made up.
#[test]
fn a_current_without_a_name_is_asked_for() {
    let numbers = Numbers::random(3);
    let mut log = numbers.logs().remove(7);
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    let current = log
        .columns
        .iter_mut()
        .find(|(name, _)| *name == "current_A");
    current.expect("a current").0 = "x3";
    std::fs::write(&file, log.text()).expect("a log");
    let proposal = propose(folder.path(), &[file]).expect("a proposal");
    let questions = &proposal.experiments[0].questions;
    assert!(
        questions.iter().any(|one| one.contains("\"x3\"")),
        "{questions:?}"
    );
    assert!(
        !proposal.text.contains("\nconstants = {"),
        "{}",
        proposal.text
    );
}
