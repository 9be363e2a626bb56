//! A cure that is done is the end of the matter: it names what stands in bench.toml, every log that needs it, and one
//! cause for one slip. Obeyed, it leaves no finding.

use std::f64::consts::PI;

use data_check::{Finding, FindingId, Severity, check};

use crate::simulated::{Log, Numbers};

const RPM: f64 = 30.0 / PI;
const SEEDS: std::ops::Range<u64> = 0..4;

fn found(seed: u64, known: &str, change: impl Fn(&mut Vec<Log>)) -> Vec<Finding> {
    let numbers = Numbers::random(seed);
    let mut logs = numbers.logs();
    change(&mut logs);
    check(&numbers.bench_with(&logs, known))
}

fn refused(found: &[Finding]) -> Vec<&Finding> {
    let refused = found.iter();
    refused
        .filter(|finding| finding.severity == Severity::Refuse)
        .collect()
}

/// A key that the user wrote and that makes just the factor found is to be taken out, not set.
#[test]
fn a_key_that_stands_there_is_to_be_taken_out() {
    for seed in SEEDS {
        for (log, key) in [
            (3, "sign = { current = -1 }"),
            (3, "sign = { wheel_speed = -1 }"),
            (3, "units = { wheel_speed = \"rpm\" }"),
            (3, "units = { current = \"mA\" }"),
            (0, "units = { angle = \"deg\" }"),
            (0, "units = { rate = \"deg/s\" }"),
            (0, "sign = { angle = -1 }"),
            (6, "sign = { wheel_speed = -1 }"),
            (6, "sign = { current = -1 }"),
            (7, "units = { angle = \"deg\" }"),
        ] {
            let found = found(seed, "", |logs| logs[log].more = key.to_owned());
            let refused = refused(&found);
            assert!(!refused.is_empty(), "seed {seed}, {key}");
            for finding in refused {
                assert!(
                    finding.fix.starts_with(&format!("take {key} out")),
                    "seed {seed}, {key}: {finding:#?}"
                );
            }
        }
    }
}

/// The sign of one column of a balance log contradicts the gains and the wheel's answer: one refusal, one cure.
#[test]
fn one_wrong_sign_in_a_balance_log_has_one_cure() {
    let spoil = |log: &mut Log, columns: &[&str]| {
        for column in columns {
            match *column {
                // The angle is counted from hanging: upright remains π.
                "angle_rad" => {
                    let angle = log.column(column);
                    angle.iter_mut().for_each(|x| *x = 2.0 * PI - *x);
                }
                _ => log.scale(column, -1.0),
            }
        }
    };
    for seed in SEEDS {
        for (columns, cure) in [
            (&["wheel_speed_rad_s"][..], "sign = { wheel_speed = -1 }"),
            (&["current_A"], "sign = { current = -1 }"),
            (
                &["angle_rad", "rate_rad_s"],
                "sign = { wheel_speed = -1, current = -1 }; or sign = { angle = -1, rate = -1 }",
            ),
        ] {
            let spoilt = found(seed, "", |logs| spoil(&mut logs[6], columns));
            let refused = refused(&spoilt);
            assert_eq!(refused.len(), 1, "seed {seed}, {columns:?}: {refused:#?}");
            assert_eq!(refused[0].fix, cure, "seed {seed}: {:#?}", refused[0]);
            assert_eq!(refused[0].factor, Some(-1.0));
            // Each of the cures is enough.
            for cure in cure.split("; or ") {
                let mended = found(seed, "", |logs| {
                    spoil(&mut logs[6], columns);
                    logs[6].more = cure.to_owned();
                });
                assert_eq!(mended, [], "seed {seed}, {cure}");
            }
        }
    }
}

/// Gains of the other sign are no fault of a column: the wheel follows the current as it should.
#[test]
fn the_gain_is_named_where_the_columns_agree() {
    for seed in SEEDS {
        let mut numbers = Numbers::random(seed);
        let logs = numbers.logs();
        numbers.gains = numbers.gains.map(|gain| -gain);
        let found = check(&numbers.bench(&logs));
        let refused = refused(&found);
        assert_eq!(refused.len(), 1, "seed {seed}: {refused:#?}");
        assert!(
            refused[0].fix.starts_with("every gain with the other sign"),
            "seed {seed}: {:#?}",
            refused[0]
        );
    }
}

/// All logs of the wheel in rpm: the cure is for all of them, and half of it done says what is lacking.
#[test]
fn a_slip_that_all_logs_share_has_one_cure_for_all() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let known = format!("wheel_inertia = {}", numbers.wheel_inertia);
        let wheel = |logs: &mut Vec<Log>, mended: &[usize]| {
            logs.truncate(6);
            for (index, log) in logs.iter_mut().enumerate().skip(2) {
                log.scale("wheel_speed_rad_s", RPM);
                if mended.contains(&index) {
                    log.more = "units = { wheel_speed = \"rpm\" }".to_owned();
                }
            }
        };
        for known in ["", known.as_str()] {
            let all = found(seed, known, |logs| wheel(logs, &[]));
            let of_speed = |found: &[Finding]| {
                let mut found = found.iter();
                let found = found.find(|one| one.finding == FindingId::WheelSpeedFactor);
                found.map(|one| one.fix.clone()).unwrap_or_default()
            };
            let fix = of_speed(&all);
            for log in ["spin a", "spin b", "spin c", "coast"] {
                let in_place = all.iter().any(|one| one.experiment.as_deref() == Some(log));
                assert!(fix.contains(log) || in_place, "seed {seed}: {fix}");
            }
            let half = of_speed(&found(seed, known, |logs| wheel(logs, &[3])));
            assert!(
                half.contains("if it is right, state it in the other logs"),
                "seed {seed}: {half}"
            );
            assert!(
                half.contains("spin a, spin c, coast"),
                "seed {seed}: {half}"
            );
            let done = found(seed, known, |logs| wheel(logs, &[2, 3, 4, 5]));
            assert_eq!(done, [], "seed {seed}");
        }
    }
}

/// A torque constant with a slipped digit and a speed in rpm differ by less than an inertia is certain.
#[test]
fn a_torque_constant_ten_times_too_large_is_named() {
    for seed in SEEDS {
        let mut numbers = Numbers::random(seed);
        let logs = numbers.logs();
        let known = format!("wheel_inertia = {}", numbers.wheel_inertia);
        numbers.torque_constant *= 10.0;
        for known in ["", known.as_str()] {
            let found = check(&numbers.bench_with(&logs[..6], known));
            let names = found
                .iter()
                .any(|finding| finding.fix.contains("torque_constant"));
            assert!(names, "seed {seed}: {found:#?}");
        }
    }
}

/// A driven run with `current = 0.0`: the wheel cannot gain speed so.
#[test]
fn a_wheel_that_gains_speed_without_a_current_is_named() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let mut logs = numbers.logs();
        // Driven for the whole log, and driven for its first second before it coasts.
        logs[2].column("current_A").fill(0.0);
        let speed = logs[5].column("wheel_speed_rad_s");
        for (k, x) in speed.iter_mut().enumerate().take(100) {
            *x *= k as f64 / 100.0;
        }
        let found = check(&numbers.bench(&logs));
        let fix = |log: &str| {
            let mut found = found.iter();
            let of_log = found.find(|one| {
                one.experiment.as_deref() == Some(log) && one.finding == FindingId::Hand
            });
            of_log.map(|one| one.fix.clone()).unwrap_or_default()
        };
        assert!(
            fix("spin a").contains("constants = { current"),
            "seed {seed}: {found:#?}"
        );
        let from = fix("coast");
        let from = from.trim_start_matches("from = ");
        let from: f64 = from[..from.find(';').unwrap_or(0)].parse().unwrap_or(0.0);
        assert!((0.99..1.2).contains(&from), "seed {seed}: {found:#?}");
    }
}
