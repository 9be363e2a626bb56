//! Every channel in every usual wrong unit or sign, in every kind of experiment: with the rest of the bench, and as the
//! bench's only log. The names of the columns state no unit. The test prints what is found in each case.

use std::f64::consts::{PI, TAU};

use data_check::{Finding, FindingId, Severity, check};

use crate::simulated::{Log, Numbers};

const DEGREES: f64 = 180.0 / PI;
const RPM: f64 = 30.0 / PI;

/// The logs of `Numbers::logs` that are spoilt, with the word for each.
const LOGS: [(usize, &str); 4] = [
    (0, "free-swing"),
    (3, "spin-up"),
    (6, "balance"),
    (7, "driven"),
];

/// A slip: name, column, factor.
const SLIPS: [(&str, &str, f64); 14] = [
    ("angle in deg", "angle_rad", DEGREES),
    ("angle in mrad", "angle_rad", 1e3),
    ("angle in turns", "angle_rad", 1.0 / TAU),
    ("angle reversed", "angle_rad", -1.0),
    ("rate in deg/s", "rate_rad_s", DEGREES),
    ("rate in rpm", "rate_rad_s", RPM),
    ("rate reversed", "rate_rad_s", -1.0),
    ("wheel in rpm", "wheel_speed_rad_s", RPM),
    ("wheel in deg/s", "wheel_speed_rad_s", DEGREES),
    ("wheel in rev/s", "wheel_speed_rad_s", 1.0 / TAU),
    ("wheel reversed", "wheel_speed_rad_s", -1.0),
    ("current in mA", "current_A", 1e3),
    ("current reversed", "current_A", -1.0),
    ("time in ms", "time_s", 1e3),
];

/// Which of the body's columns a log has.
const SHAPES: [(&str, &[&str]); 3] = [
    ("", &[]),
    (", no rate", &["rate_rad_s"]),
    (", no angle", &["angle_rad"]),
];

/// Names of columns that state no unit.
const PLAIN_NAMES: [(&str, &str, &str); 4] = [
    ("angle_rad", "pend", "angle"),
    ("rate_rad_s", "gyro", "rate"),
    ("wheel_speed_rad_s", "wheel", "wheel_speed"),
    ("current_A", "cur", "current"),
];

/// The log with columns of which no name states a unit.
fn with_plain_names(mut log: Log) -> Log {
    let mut mapped = vec![];
    for (column, _) in &mut log.columns {
        if let Some((_, plain, key)) = PLAIN_NAMES.iter().find(|(name, _, _)| *name == *column) {
            *column = plain;
            mapped.push(format!("{key} = \"{plain}\""));
        }
    }
    log.more = format!("columns = {{ {} }}", mapped.join(", "));
    log
}

/// The findings about a log that refuse it, name a factor, or say that the unit of this column is unstated.
fn about(log: &Log, column: &str, found: &[Finding]) -> Vec<(FindingId, Option<f64>)> {
    let key = PLAIN_NAMES.iter().find(|(name, _, _)| *name == column);
    let key = key.map(|(_, _, key)| *key);
    let names_it = |finding: &&Finding| {
        finding.factor.is_some()
            || finding.severity == Severity::Refuse
            || finding.finding == FindingId::UnitUnstated && finding.channel.as_deref() == key
    };
    found
        .iter()
        .filter(|finding| {
            finding
                .experiment
                .as_deref()
                .is_none_or(|name| name == log.name)
        })
        .filter(names_it)
        .map(|finding| (finding.finding, finding.factor))
        .collect()
}

/// Why nothing can be said about a slip, where that is so.
fn cannot_be_told(kind: &str, shape: &str, slip: &str, alone: bool) -> Option<&'static str> {
    let is_reversed = slip.ends_with("reversed");
    match kind {
        "free-swing" if is_reversed && !shape.is_empty() => {
            Some("a swing reversed is a swing from the other side")
        }
        // With the thesis' noise, wheel and gravity explain 70 % of such a body's acceleration.
        "balance" if is_reversed && !shape.is_empty() => Some(
            "without angle or rate, the motion of a balanced body does not stand out of the noise",
        ),
        "spin-up" if slip == "time in ms" && alone => {
            Some("one spin-up has no measure of time: neither a period nor a controller")
        }
        "driven" | "balance" if slip == "current reversed" && alone && !shape.is_empty() => Some(
            "one current has no measure but the wheel, which may be hidden by the body's motion",
        ),
        _ => None,
    }
}

#[test]
fn no_slip_passes_without_a_word() {
    let mut silent = vec![];
    for seed in 0..2 {
        let numbers = Numbers::random(seed);
        let good = numbers.logs();
        for (index, kind) in LOGS {
            for (shape, without) in SHAPES {
                for (slip, column, factor) in SLIPS {
                    for alone in [false, true] {
                        let mut logs = good.clone();
                        let spoilt = &mut logs[index];
                        let names: Vec<&str> =
                            spoilt.columns.iter().map(|(name, _)| *name).collect();
                        let has_all = without
                            .iter()
                            .chain([&column])
                            .all(|name| names.contains(name));
                        if !has_all || without.contains(&column) {
                            continue;
                        }
                        spoilt.columns.retain(|(name, _)| !without.contains(name));
                        spoilt.scale(column, factor);
                        let spoilt = with_plain_names(spoilt.clone());
                        if alone {
                            logs = vec![spoilt.clone()];
                        } else {
                            logs[index] = spoilt.clone();
                        }
                        let bench = match numbers.try_bench_with(&logs, "") {
                            Ok(bench) => bench,
                            Err(error) => {
                                println!("{seed} {kind}{shape} | {slip} | refused: {error}");
                                continue;
                            }
                        };
                        let found = about(&spoilt, column, &check(&bench));
                        let told = cannot_be_told(kind, shape, slip, alone);
                        let bench = if alone { "alone" } else { "whole" };
                        println!("{seed} {kind}{shape} {bench} | {slip} | {found:?} {told:?}");
                        if found.is_empty() && told.is_none() {
                            silent.push(format!("{seed} {kind}{shape} {bench} | {slip}"));
                        }
                    }
                }
            }
        }
    }
    assert!(
        silent.is_empty(),
        "{} are silent:\n{}",
        silent.len(),
        silent.join("\n")
    );
}
