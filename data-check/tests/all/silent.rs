//! Faults that leave every sample plausible by itself: only the motion as a whole, or another column, shows them.

use data_check::{Finding, FindingId, Severity, check, propose};
use plant::{Kind, State};

use crate::simulated::{Log, Numbers};

const SEEDS: std::ops::Range<u64> = 20..24;

/// The findings of a bench with this log alone.
fn found_in(numbers: &Numbers, log: &Log) -> Vec<Finding> {
    check(&numbers.bench(std::slice::from_ref(log)))
}

fn assert_has(found: &[Finding], id: FindingId, severity: Severity, words: &str) {
    let is_it = |finding: &Finding| {
        let text = format!("{} | {}", finding.sentence, finding.fix);
        finding.finding == id && finding.severity == severity && text.contains(words)
    };
    assert!(found.iter().any(is_it), "{id:?} {words}: {found:#?}");
}

fn without(log: &Log, column: &str) -> Log {
    let mut log = log.clone();
    log.columns.retain(|(name, _)| *name != column);
    log
}

/// A knock by hand in the middle of a swing makes it a tenth larger. Its angle or its rate alone shows that.
#[test]
fn a_knock_in_a_free_swing() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let good = numbers.logs().remove(0);
        let mut log = good.clone();
        let angle = log.column("angle_rad").clone();
        let crosses = |k: &usize| angle[*k] < 0.0 && angle[*k + 1] >= 0.0;
        let from = (1500..2900).find(crosses).expect("a crossing") + 1;
        for name in ["angle_rad", "rate_rad_s"] {
            log.column(name)[from..].iter_mut().for_each(|x| *x *= 1.1);
        }
        for log in [
            log.clone(),
            without(&log, "rate_rad_s"),
            without(&log, "angle_rad"),
        ] {
            let found = found_in(&numbers, &log);
            assert_has(&found, FindingId::Hand, Severity::Warn, "until = ");
        }
        for log in [without(&good, "rate_rad_s"), without(&good, "angle_rad")] {
            assert_eq!(found_in(&numbers, &log), [], "seed {seed}");
        }
    }
}

/// An angle with few digits has no noise that its standstill would lack; its rate goes on.
#[test]
fn an_angle_that_stands_still_while_the_body_turns_round() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let mut log = numbers.logs().remove(0);
        let speed = 12.0 + seed as f64 % 5.0;
        let rows = log.columns[0].1.len();
        for k in 0..rows {
            let time_s = 0.005 * k as f64;
            // Thrown over the top, and slowed down by its friction.
            let way = speed * (1.0 - (-0.1 * time_s).exp()) / 0.1;
            log.column("angle_rad")[k] = (way * 100.0).round() / 100.0;
            log.column("rate_rad_s")[k] = speed * (-0.1 * time_s).exp();
        }
        assert!(!has(&found_in(&numbers, &log), FindingId::Frozen));
        let value = log.column("angle_rad")[1000];
        log.column("angle_rad")[1000..1300].fill(value);
        let found = found_in(&numbers, &log);
        assert_has(&found, FindingId::Frozen, Severity::Refuse, "turns");
    }
}

fn has(found: &[Finding], id: FindingId) -> bool {
    found.iter().any(|finding| finding.finding == id)
}

/// A wheel that is not locked does not swing with the body. No column shows it, but the period does, where the inertias
/// are known.
#[test]
fn a_free_wheel_that_nobody_logged() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let known = format!(
            "total_inertia = {}\nwheel_inertia = {}",
            numbers.total_inertia, numbers.wheel_inertia
        );
        let good = numbers.logs().remove(0);
        let found = check(&numbers.bench_with(std::slice::from_ref(&good), &known));
        assert_eq!(found, [], "seed {seed}");
        let start = State {
            angle_rad: 0.6,
            ..State::rest()
        };
        let states = numbers.run(Kind::Driven, start, &vec![0.0; 3000], 0.005);
        let mut log = good.clone();
        for (k, state) in states.iter().enumerate() {
            let noise = 1e-4 * ((k * 7919 % 13) as f64 - 6.0);
            log.column("angle_rad")[k] = state.angle_rad + noise;
            log.column("rate_rad_s")[k] = state.rate_rad_s + noise;
        }
        let found = check(&numbers.bench_with(&[log], &known));
        assert_has(&found, FindingId::WheelTurns, Severity::Warn, "driven");
        assert_eq!(found.len(), 1, "seed {seed}: {found:#?}");
    }
}

/// Two logs in one file, with one time over both.
#[test]
fn two_logs_in_one_file() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let logs = numbers.logs();
        let mut log = logs[0].clone();
        for (name, column) in &mut log.columns {
            if *name != "time_s" {
                let mut second = logs[1].clone();
                let second = second.column(name)[..1500].to_vec();
                column.truncate(1503);
                column.extend(second);
            } else {
                *column = (0..3003).map(|k| 0.005 * f64::from(k)).collect();
            }
        }
        let found = found_in(&numbers, &log);
        let jumps = |log: &[f64]| (log[1503] - log[1502]).abs();
        // Where the angles happen to meet, the rates do not.
        let severity = if jumps(log.column("angle_rad")) > 0.15 {
            Severity::Refuse
        } else {
            Severity::Warn
        };
        assert_has(&found, FindingId::Jump, severity, "until = 7.5");
    }
}

/// The sensor of the current ends at half of what flows; the wheel shows that more flowed.
#[test]
fn a_current_beyond_its_sensor() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let mut log = numbers.logs().remove(7);
        let most = 2.0 * numbers.wheel_inertia / numbers.torque_constant * 100.0;
        let current: Vec<f64> = (0..2000)
            .map(|k| most * (4.0 * 0.005 * f64::from(k)).sin())
            .collect();
        let states = numbers.run(Kind::Driven, State::rest(), &current, 0.005);
        for (k, state) in states.iter().enumerate() {
            let noise = 1e-4 * ((k * 7919 % 13) as f64 - 6.0);
            log.column("angle_rad")[k] = state.angle_rad + noise;
            log.column("rate_rad_s")[k] = state.rate_rad_s + noise;
            log.column("wheel_speed_rad_s")[k] = state.wheel_speed_rad_s + 100.0 * noise;
        }
        *log.column("current_A") = current;
        assert_eq!(found_in(&numbers, &log), [], "seed {seed}");
        let limit = 0.6 * most;
        let current = log.column("current_A").iter_mut();
        current.for_each(|x| *x = x.clamp(-limit, limit));
        let found = found_in(&numbers, &log);
        assert_has(&found, FindingId::Clipped, Severity::Warn, "sensor ends");
    }
}

#[test]
fn a_rate_in_the_place_of_the_wheels_speed() {
    for seed in SEEDS {
        let numbers = Numbers::random(seed);
        let mut log = numbers.logs().remove(7);
        *log.column("wheel_speed_rad_s") = log.column("rate_rad_s").clone();
        let found = found_in(&numbers, &without(&log, "rate_rad_s"));
        assert_has(
            &found,
            FindingId::RateFactor,
            Severity::Refuse,
            "body's rate",
        );
    }
}

/// Without its angle, a log of balancing looks like one of hanging: the proposal asks.
#[test]
fn a_log_without_an_angle_may_hang_or_balance() {
    let numbers = Numbers::random(SEEDS.start);
    let log = without(&numbers.logs()[6], "angle_rad");
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("log.csv");
    std::fs::write(&file, log.text()).expect("a log");
    let proposal = propose(folder.path(), &[file]).expect("a proposal");
    let questions = &proposal.experiments[0].questions;
    assert!(
        questions.iter().any(|one| one.contains("balance upright")),
        "{questions:?}"
    );
}

/// What `new` makes of names that people write: a Greek letter with a dot, a name that says where an angle comes from, and
/// ticks that no name explains.
#[test]
fn names_of_columns_as_people_write_them() {
    let numbers = Numbers::random(SEEDS.start);
    let swing = numbers.logs().remove(0);
    for (names, parts) in [
        (
            ["Zeit (s)", "θ (rad)", "θ̇ (rad/s)"],
            &["kind = \"free-swing\"", "rate = \"θ̇ (rad/s)\""][..],
        ),
        (
            ["t [s]", "angle_rad_from_pot_scale", "gyro_rad_s"],
            &["angle = \"angle_rad_from_pot_scale\""],
        ),
        (
            ["t [s]", "ticks", "n"],
            &["TO DECIDE: no column is an angle", "2 pi / counts a turn"],
        ),
    ] {
        let mut log = swing.clone();
        for ((name, _), new) in log.columns.iter_mut().zip(names) {
            *name = new;
        }
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("log.csv");
        std::fs::write(&file, log.text()).expect("a log");
        let proposal = propose(folder.path(), &[file]).expect("a proposal");
        for part in parts {
            assert!(proposal.text.contains(part), "{part}: {}", proposal.text);
        }
    }
}

/// One wrong sign is mended by one sign.
#[test]
fn a_wheel_with_the_wrong_sign_is_turned_alone() {
    for seed in SEEDS {
        let mut log = Numbers::random(seed).logs().remove(7);
        log.scale("wheel_speed_rad_s", -1.0);
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("log.csv");
        std::fs::write(&file, log.text()).expect("a log");
        let proposal = propose(folder.path(), &[file]).expect("a proposal");
        assert!(
            proposal.text.contains("\nsign = { wheel_speed = -1 }\n"),
            "seed {seed}: {}",
            proposal.text
        );
    }
}

/// A rate that firmware took from neighbouring samples of an encoder is late by half an interval. A swing of a dozen
/// samples a period looks the same a whole period later, which is no delay.
#[test]
fn a_period_of_a_swing_is_no_delay() {
    let count = std::f64::consts::TAU / 2400.0;
    for tenths in 55..80 {
        let period_s = 0.01 * f64::from(tenths);
        let step_s = 0.05;
        let angle: Vec<f64> = (0..240)
            .map(|k| {
                let time_s = step_s * f64::from(k);
                let angle =
                    (-0.1 * time_s).exp() * (std::f64::consts::TAU * time_s / period_s).cos();
                (angle / count).round() * count
            })
            .collect();
        let rate = angle.windows(2).map(|pair| (pair[1] - pair[0]) / step_s);
        let log = Log {
            name: "swing",
            kind: Kind::FreeSwing,
            columns: vec![
                ("time_s", (1..240).map(|k| step_s * f64::from(k)).collect()),
                ("rate_rad_s", rate.collect()),
                ("angle_rad", angle[1..].to_vec()),
            ],
            more: String::new(),
        };
        let found = found_in(&Numbers::random(1), &log);
        let is_late = |finding: &Finding| finding.finding == FindingId::LateChannel;
        assert!(!found.iter().any(is_late), "{period_s} s: {found:#?}");
    }
}

/// A mark on the wheel, read every fourth turn: the column counts the turns, so that their sense is certain.
#[test]
fn a_count_of_turns_may_be_long_apart() {
    let time_s: Vec<f64> = (0..120)
        .map(f64::from)
        .map(|k| 1.7 * k + 0.01 * k * k)
        .collect();
    let log = Log {
        name: "coast",
        kind: Kind::SpinUp,
        columns: vec![
            ("time_s", time_s),
            (
                "wheel_angle_rad",
                (0..120)
                    .map(|k| 4.0 * std::f64::consts::TAU * f64::from(k))
                    .collect(),
            ),
            ("current_A", vec![0.0; 120]),
        ],
        more: String::new(),
    };
    let found = found_in(&Numbers::random(1), &log);
    let is_wrapped = |finding: &Finding| finding.finding == FindingId::Wrapped;
    assert!(!found.iter().any(is_wrapped), "{found:#?}");
}
