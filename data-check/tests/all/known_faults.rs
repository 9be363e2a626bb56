//! One fault at a time on benches without any other: the check names the fault with its factor. A bench without a fault
//! has no finding.

use std::f64::consts::PI;

use data_check::{Finding, FindingId, Severity, check};
use plant::Kind;

use crate::simulated::{Log, Numbers};

const DEGREES: f64 = 180.0 / PI;
const RPM: f64 = 30.0 / PI;

fn spoilt(seed: u64, spoil: impl Fn(&mut Vec<Log>)) -> Vec<Finding> {
    let numbers = Numbers::random(seed);
    let mut logs = numbers.logs();
    spoil(&mut logs);
    check(&numbers.bench(&logs))
}

fn assert_found(
    seed: u64,
    found: &[Finding],
    id: FindingId,
    factor: Option<f64>,
    severity: Severity,
) {
    let fits = |finding: &Finding| {
        finding.finding == id
            && finding.severity == severity
            && match (factor, finding.factor) {
                (None, _) => true,
                (Some(expected), Some(found)) => (found / expected - 1.0).abs() < 0.01,
                (Some(_), None) => false,
            }
    };
    assert!(
        found.iter().any(fits),
        "seed {seed}: {id:?} {factor:?} not in {found:#?}"
    );
}

const SEEDS: std::ops::Range<u64> = 0..8;

#[test]
fn a_good_bench_has_no_finding() {
    for seed in 0..24 {
        assert_eq!(spoilt(seed, |_| {}), [], "seed {seed}");
    }
}

#[test]
fn the_rate_in_other_units_or_signs() {
    for seed in SEEDS {
        for (factor, found_as) in [
            (DEGREES, DEGREES),
            (-1.0, -1.0),
            (RPM, RPM),
            (1e3, 1e3),
            (-DEGREES, -DEGREES),
        ] {
            for log in [0, 1, 6] {
                let found = spoilt(seed, |logs| logs[log].scale("rate_rad_s", factor));
                assert_found(
                    seed,
                    &found,
                    FindingId::RateFactor,
                    Some(found_as),
                    Severity::Refuse,
                );
            }
        }
    }
}

#[test]
fn the_time_in_milliseconds() {
    for seed in SEEDS {
        let found = spoilt(seed, |logs| logs[0].scale("time_s", 1e3));
        assert_found(
            seed,
            &found,
            FindingId::TimeFactor,
            Some(1e3),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[6].scale("time_s", 1e3));
        assert_found(
            seed,
            &found,
            FindingId::TimeFactor,
            Some(1e3),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[2].scale("time_s", 1e3));
        assert_found(
            seed,
            &found,
            FindingId::WheelSpeedFactor,
            Some(1e3),
            Severity::Refuse,
        );
    }
}

#[test]
fn the_angle_in_degrees_with_and_without_a_rate() {
    for seed in SEEDS {
        for log in [0, 1] {
            let found = spoilt(seed, |logs| {
                logs[log].scale("angle_rad", DEGREES);
                logs[log].columns.truncate(2);
            });
            assert_found(
                seed,
                &found,
                FindingId::AngleFactor,
                Some(DEGREES),
                Severity::Refuse,
            );
            let found = spoilt(seed, |logs| logs[log].scale("angle_rad", DEGREES));
            assert_found(
                seed,
                &found,
                FindingId::RateFactor,
                Some(1.0 / DEGREES),
                Severity::Refuse,
            );
            // Both in degrees: the rate agrees with the angle, but no pendulum swings with this period and amplitude.
            let found = spoilt(seed, |logs| {
                logs[log].scale("angle_rad", DEGREES);
                logs[log].scale("rate_rad_s", DEGREES);
            });
            assert_found(
                seed,
                &found,
                FindingId::AngleFactor,
                Some(DEGREES),
                Severity::Refuse,
            );
        }
        // Two degrees that are read as two radians: only the period shows the fault.
        let found = spoilt(seed, |logs| {
            logs[1].scale("angle_rad", 2.0 / 15.0 * DEGREES);
            logs[1].columns.truncate(2);
        });
        let unit = found
            .iter()
            .find(|finding| finding.finding == FindingId::AngleFactor);
        assert!(unit.is_some(), "seed {seed}: {found:?}");
    }
}

#[test]
fn the_wheel_in_rpm_in_one_log_in_a_balance_log_and_everywhere() {
    for seed in SEEDS {
        let found = spoilt(seed, |logs| logs[3].scale("wheel_speed_rad_s", RPM));
        assert_found(
            seed,
            &found,
            FindingId::WheelSpeedFactor,
            Some(RPM),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[6].scale("wheel_speed_rad_s", RPM));
        assert_found(seed, &found, FindingId::Gains, Some(RPM), Severity::Refuse);
        // In all logs: the wheel inertia or the voltage that follows is impossible.
        let found = spoilt(seed, |logs| {
            logs.truncate(6);
            logs[2..]
                .iter_mut()
                .for_each(|log| log.scale("wheel_speed_rad_s", RPM));
        });
        assert!(
            found
                .iter()
                .any(|f| f.finding == FindingId::WheelSpeedFactor && f.factor == Some(RPM)),
            "seed {seed}: {found:?}"
        );
        // With the wheel's inertia known there is no doubt.
        let numbers = Numbers::random(seed);
        let mut logs = numbers.logs();
        logs.truncate(6);
        logs[2..]
            .iter_mut()
            .for_each(|log| log.scale("wheel_speed_rad_s", RPM));
        let known = format!("wheel_inertia = {}", numbers.wheel_inertia);
        let found = check(&numbers.bench_with(&logs, &known));
        assert_found(
            seed,
            &found,
            FindingId::WheelSpeedFactor,
            Some(RPM),
            Severity::Refuse,
        );
    }
}

#[test]
fn the_current_with_the_wrong_sign_or_in_milliamperes() {
    for seed in SEEDS {
        for log in [2, 3, 4] {
            let found = spoilt(seed, |logs| logs[log].scale("current_A", -1.0));
            assert_found(
                seed,
                &found,
                FindingId::CurrentSign,
                Some(-1.0),
                Severity::Refuse,
            );
        }
        let found = spoilt(seed, |logs| logs[6].scale("current_A", -1.0));
        assert_found(seed, &found, FindingId::Gains, Some(-1.0), Severity::Refuse);
        let found = spoilt(seed, |logs| {
            logs[2..6]
                .iter_mut()
                .for_each(|log| log.scale("current_A", 1e3));
        });
        assert_found(
            seed,
            &found,
            FindingId::CurrentFactor,
            Some(1e3),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[6].scale("current_A", 1e3));
        assert_found(
            seed,
            &found,
            FindingId::CurrentFactor,
            Some(1e3),
            Severity::Refuse,
        );
        // The wheel against body and current.
        let found = spoilt(seed, |logs| logs[6].scale("wheel_speed_rad_s", -1.0));
        assert_found(seed, &found, FindingId::Gains, Some(-1.0), Severity::Refuse);
    }
}

#[test]
fn gains_that_are_not_those_of_the_log() {
    for seed in SEEDS {
        let mut numbers = Numbers::random(seed);
        let logs = numbers.logs();
        numbers.gains[0] /= DEGREES;
        let found = check(&numbers.bench(&logs));
        assert_found(
            seed,
            &found,
            FindingId::Gains,
            Some(1.0 / DEGREES),
            Severity::Refuse,
        );
    }
}

#[test]
fn one_column_for_two_channels() {
    for seed in SEEDS {
        let found = spoilt(seed, |logs| {
            let angle = logs[0].column("angle_rad").clone();
            *logs[0].column("rate_rad_s") = angle;
        });
        assert_found(seed, &found, FindingId::SameColumn, None, Severity::Refuse);
    }
}

#[test]
fn what_should_stand_still() {
    for seed in SEEDS {
        // A wheel without friction stays where it is while the body swings.
        let found = spoilt(seed, |logs| {
            let wheel = logs[0]
                .column("rate_rad_s")
                .iter()
                .map(|rate| -0.9 * rate)
                .collect();
            logs[0].columns.push(("wheel_speed_rad_s", wheel));
        });
        assert_found(seed, &found, FindingId::WheelTurns, None, Severity::Refuse);
        let found = spoilt(seed, |logs| {
            let still = logs[0]
                .column("rate_rad_s")
                .iter()
                .map(|rate| 1e-3 * rate)
                .collect();
            logs[0].columns.push(("wheel_speed_rad_s", still));
        });
        assert_eq!(found, [], "seed {seed}");
        // A body that swings while the wheel spins up.
        let moving = |size: f64| {
            spoilt(seed, |logs| {
                let angle = logs[3]
                    .column("time_s")
                    .iter()
                    .map(|t| size * (9.0 * t).sin())
                    .collect();
                logs[3].columns.push(("angle_rad", angle));
            })
        };
        assert_found(
            seed,
            &moving(0.4),
            FindingId::BodyMoves,
            None,
            Severity::Refuse,
        );
        assert_eq!(moving(1e-3), [], "seed {seed}");
    }
}

#[test]
fn a_body_that_is_held_or_pushed() {
    for seed in SEEDS {
        for held_s in [0.5, 2.0] {
            let samples = (held_s / 0.005) as usize;
            let found = spoilt(seed, |logs| {
                for (column, values) in &mut logs[0].columns {
                    let first = values[0];
                    let noise: Vec<f64> = (0..samples)
                        .map(|k| values[2000 + k] - values[2000 + k + 1])
                        .collect();
                    let before: Vec<f64> = match *column {
                        "time_s" => (0..samples)
                            .map(|k| first - held_s + 0.005 * k as f64)
                            .collect(),
                        "angle_rad" => noise.iter().map(|x| first + 0.01 * x).collect(),
                        _ => noise.iter().map(|x| 0.01 * x).collect(),
                    };
                    values.splice(0..0, before);
                }
            });
            let held = found.iter().find(|f| f.finding == FindingId::HeldStart);
            let held = held.unwrap_or_else(|| panic!("seed {seed}: {found:?}"));
            let from: f64 = held.fix["from = ".len()..].parse().expect("a number");
            assert!(from.abs() < 0.05, "seed {seed}: {held:?}");
        }
        // Run backwards in time, a swing gains energy.
        let found = spoilt(seed, |logs| {
            logs[0].column("angle_rad").reverse();
            logs[0].columns.truncate(2);
        });
        assert_found(seed, &found, FindingId::Hand, None, Severity::Warn);
    }
}

#[test]
fn copies_and_channels_that_lie() {
    for seed in SEEDS {
        let found = spoilt(seed, |logs| {
            let mut copy = logs[0].clone();
            copy.name = "copy";
            logs.push(copy);
        });
        assert_found(seed, &found, FindingId::SameData, None, Severity::Warn);
        // A copy that went through another program, which wrote degrees with four digits.
        let found = spoilt(seed, |logs| {
            let mut copy = logs[0].clone();
            copy.name = "copy";
            for column in ["angle_rad", "rate_rad_s"] {
                let rounded = |x: &mut f64| *x = (*x * DEGREES * 1e4).round() / (DEGREES * 1e4);
                copy.column(column).iter_mut().for_each(rounded);
            }
            logs.push(copy);
        });
        assert_found(seed, &found, FindingId::SameData, None, Severity::Warn);
        // A spin-up that leaves the range of its sensor, and stays beyond it.
        let found = spoilt(seed, |logs| {
            let speed = logs[3].column("wheel_speed_rad_s");
            let largest = speed.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            speed
                .iter_mut()
                .for_each(|x| *x = x.clamp(-0.5 * largest, 0.5 * largest));
        });
        assert_found(seed, &found, FindingId::Clipped, None, Severity::Refuse);
        let stale = |finding: &Finding| finding.finding == FindingId::Stale;
        assert!(!found.iter().any(stale), "seed {seed}: {found:#?}");
        let found = spoilt(seed, |logs| {
            let limit = 0.6
                * logs[0]
                    .column("rate_rad_s")
                    .iter()
                    .fold(0.0, |m: f64, x| m.max(x.abs()));
            logs[0]
                .column("rate_rad_s")
                .iter_mut()
                .for_each(|x| *x = x.clamp(-limit, limit));
        });
        assert_found(seed, &found, FindingId::Clipped, None, Severity::Refuse);
        let found = spoilt(seed, |logs| {
            let speed = logs[3].column("wheel_speed_rad_s");
            let value = speed[100];
            speed[100..140].fill(value);
        });
        assert_found(seed, &found, FindingId::Frozen, None, Severity::Warn);
        let found = spoilt(seed, |logs| {
            for k in 0..3000 {
                logs[0].column("rate_rad_s")[k] = logs[0].column("rate_rad_s")[k - k % 4];
            }
        });
        assert_found(seed, &found, FindingId::Stale, None, Severity::Warn);
        let found = spoilt(seed, |logs| logs[0].column("rate_rad_s").rotate_right(12));
        assert_found(seed, &found, FindingId::LateChannel, None, Severity::Warn);
    }
}

#[test]
fn known_values_that_no_bench_has() {
    let numbers = Numbers::random(1);
    let logs = numbers.logs();
    let found = check(&numbers.bench_with(&logs[..2], "body_mass = 180.0"));
    assert_found(
        1,
        &found,
        FindingId::KnownRange,
        Some(1e3),
        Severity::Refuse,
    );
    assert_eq!(found[0].fix, "body_mass = 0.18");
}

#[test]
fn what_is_accepted_is_no_refusal() {
    let numbers = Numbers::random(2);
    let mut logs = numbers.logs();
    logs[0].scale("rate_rad_s", DEGREES);
    logs[0].more = "accept = [\"rate-factor\"]".to_owned();
    let found = check(&numbers.bench(&logs));
    assert!(
        found
            .iter()
            .all(|finding| finding.severity == Severity::Warn),
        "{found:?}"
    );
    logs[0].more = "accept = [\"rate-facto\"]".to_owned();
    let found = check(&numbers.bench(&logs));
    assert_found(2, &found, FindingId::UnknownFinding, None, Severity::Refuse);
    assert!(
        found
            .iter()
            .any(|finding| finding.fix == "accept = [\"rate-factor\"]"),
        "{found:?}"
    );
}

#[test]
fn a_driven_log_against_the_motion_of_its_body() {
    for seed in SEEDS {
        // All of the body's columns in degrees: they agree with each other.
        for keep in [5, 2] {
            let found = spoilt(seed, |logs| {
                logs[7].scale("angle_rad", DEGREES);
                logs[7].scale("rate_rad_s", DEGREES);
                if keep == 2 {
                    logs[7].columns.remove(2);
                }
            });
            assert_found(
                seed,
                &found,
                FindingId::AngleFactor,
                Some(DEGREES),
                Severity::Refuse,
            );
        }
        let found = spoilt(seed, |logs| {
            logs[7].scale("wheel_speed_rad_s", -1.0);
            logs[7].scale("current_A", -1.0);
        });
        assert_found(
            seed,
            &found,
            FindingId::WheelSign,
            Some(-1.0),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[7].scale("rate_rad_s", DEGREES));
        assert_found(
            seed,
            &found,
            FindingId::RateFactor,
            Some(DEGREES),
            Severity::Refuse,
        );
        let found = spoilt(seed, |logs| logs[7].scale("current_A", -1.0));
        assert_found(
            seed,
            &found,
            FindingId::CurrentSign,
            Some(-1.0),
            Severity::Refuse,
        );
    }
}

/// Free swings alone give no finding about the wheel.
#[test]
fn swings_alone_have_no_finding() {
    for seed in SEEDS {
        let found = spoilt(seed, |logs| logs.retain(|log| log.kind == Kind::FreeSwing));
        assert_eq!(found, [], "seed {seed}");
    }
}
