//! The spin-ups of one wheel compared with each other, and all of them with what a bench can be.

use bench_files::{Bench, Channel};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::{DEGREES, RPM, short, slip};
use crate::thresholds::bench::SHARE_OF_INERTIA;
use crate::thresholds::slips::NEAR;
use crate::thresholds::wheel::{
    ALIKE, FASTEST_RAD_S, NO_EFFECT, SAFE_VOLTAGE_V, USUAL_SHARE, USUAL_VOLTAGE_V,
};
use crate::view::{Facts, View, largest, median};

/// Checks that all spin-ups of one wheel have the same acceleration per ampere.
pub(crate) fn odd_one_out(spin_ups: &[(&View, f64)], out: &mut Vec<Finding>) {
    if spin_ups.len() < 2 {
        return;
    }
    let Some(usual) = median(spin_ups.iter().map(|(_, answer)| *answer).collect()) else {
        return;
    };
    let agree = |answer: f64| (answer / usual).ln().abs() < ALIKE;
    let agreeing = spin_ups.iter().filter(|(_, answer)| agree(*answer)).count();
    for (view, answer) in spin_ups.iter().filter(|(_, answer)| !agree(*answer)) {
        let whom = if agreeing > 1 {
            "the other spin-ups"
        } else {
            "another spin-up"
        };
        let stated = format!(
            "the wheel accelerates {} times as much per ampere as in {whom}",
            short(answer / usual)
        );
        if view.counts_lines() {
            out.push(
                Finding::refusal(
                    FindingId::TimeFactor,
                    format!(
                        "{stated}: the time counts the lines, or is in another unit than seconds"
                    ),
                )
                .in_experiment(view.name())
                .with_channel("time")
                .with_fix(
                    "time_step = … (seconds from line to line) in the place of the time's column",
                ),
            );
            continue;
        }
        let Some(factor) = slip(answer / usual) else {
            if (answer / usual).ln().abs() > NO_EFFECT.ln() {
                out.push(
                    Finding::warning(
                        FindingId::WheelSpeedFactor,
                        format!("{stated}, and no unit explains that factor"),
                    )
                    .in_experiment(view.name())
                    .with_channel("wheel_speed")
                    .with_fix("compare time, wheel_speed and current of this file with those of the others"),
                );
            }
            continue;
        };
        let (channel, likely, fix) = reading(factor);
        out.push(
            Finding::refusal(FindingId::WheelSpeedFactor, format!("{stated}: {likely}"))
                .in_experiment(view.name())
                .with_channel(channel)
                .with_factor(too_large(channel, factor))
                .with_fix(fix),
        );
    }
}

/// The factor by which the samples of the channel are too large if the acceleration per ampere is too large by `factor`.
fn too_large(channel: &str, factor: f64) -> f64 {
    if channel == "current" {
        1.0 / factor
    } else {
        factor
    }
}

/// The cause of a factor of the acceleration per ampere: channel, sentence, remedy.
fn reading(factor: f64) -> (&'static str, String, String) {
    let near = |size: f64| (factor / size).ln().abs() < 0.01;
    if near(RPM) {
        (
            "wheel_speed",
            format!("the speed is in rpm ({} times too large)", short(factor)),
            "units = { wheel_speed = \"rpm\" }".to_owned(),
        )
    } else if near(DEGREES) {
        (
            "wheel_speed",
            format!("the speed is in deg/s ({} times too large)", short(factor)),
            "units = { wheel_speed = \"deg/s\" }".to_owned(),
        )
    } else if near(1e-3) {
        (
            "current",
            "the current is in mA, or the time in ms (1000 times too large)".to_owned(),
            "units = { current = \"mA\" } or units = { time = \"ms\" }".to_owned(),
        )
    } else if near(1e3) {
        (
            "current",
            "the current is in A where mA are stated, or the speed in mrad/s".to_owned(),
            "units = { current = \"A\" } or units = { wheel_speed = \"mrad/s\" }".to_owned(),
        )
    } else {
        (
            "wheel_speed",
            format!("it has another unit (factor {})", short(factor)),
            "units = { wheel_speed = … }".to_owned(),
        )
    }
}

/// The cure of a slip that all spin-ups share, for each of them; `found_in` is the log of the finding.
fn in_all(fix: &str, logs: &[&str], found_in: Option<&str>) -> String {
    let others: Vec<&str> = logs
        .iter()
        .copied()
        .filter(|log| Some(*log) != found_in)
        .collect();
    // A log with another motion than the spin-ups may be the only one with the slip.
    let is_one_of_them = found_in.is_none_or(|found_in| logs.contains(&found_in));
    match (others.as_slice(), found_in) {
        ([], _) => fix.to_owned(),
        _ if !is_one_of_them => fix.to_owned(),
        (others, None) => format!("{fix} in each log of the wheel: {}", others.join(", ")),
        (others, Some(_)) => {
            format!(
                "{fix} in this and in every other log of the wheel: {}",
                others.join(", ")
            )
        }
    }
}

/// What else a factor of about ten between the inertia of the spin-ups and that of the bench can be: revolutions a
/// minute in rad/s are 9.55, and a measured inertia is not certain to the twentieth that lies between.
pub(crate) fn ten_times(factor: f64, torque_constant: Option<f64>) -> (String, String) {
    let (Some(constant), Some(ten)) = (
        torque_constant,
        [10.0, 0.1]
            .into_iter()
            .find(|ten: &f64| (factor / ten).ln().abs() < NEAR),
    ) else {
        return (String::new(), String::new());
    };
    let how = if ten > 1.0 { "small" } else { "large" };
    (
        format!(", or torque_constant is ten times too {how}"),
        format!(
            "; or torque_constant = {}, if that is right",
            short(constant * ten)
        ),
    )
}

/// Checks the wheel inertia from all spin-ups against its possible range.
pub(crate) fn all_together(
    bench: &Bench,
    views: &[&View],
    spin_ups: &[(&View, f64)],
    facts: &Facts,
    out: &mut Vec<Finding>,
) {
    let logs: Vec<&str> = views
        .iter()
        .filter(|view| view.kind() == Kind::SpinUp && view.samples(Channel::WheelSpeed).is_some())
        .map(|view| view.name())
        .collect();
    let about_wheel = |finding: Finding, factor: f64| {
        let (channel, _, fix) = reading(factor);
        let fix = in_all(&fix, &logs, finding.experiment.as_deref());
        finding
            .with_channel(channel)
            .with_factor(too_large(channel, factor))
            .with_fix(fix)
    };
    let usual = median(spin_ups.iter().map(|(_, answer)| *answer).collect());
    let inertia = match (facts.torque_constant, usual) {
        (Some(torque_constant), Some(usual)) => Some(torque_constant / usual),
        _ => None,
    };
    if let (Some(found), Some(known)) = (inertia, bench.known.wheel_inertia)
        && let Some(factor) = slip(known / found)
    {
        let (_, likely, _) = reading(factor);
        let stated = format!(
            "the spin-ups give a wheel inertia of {} kg m2, [known] says {}: {likely}",
            short(found),
            short(known)
        );
        let (or_constant, or_mend) = ten_times(known / found, facts.torque_constant);
        let finding = about_wheel(
            Finding::refusal(
                FindingId::WheelSpeedFactor,
                format!("{stated}{or_constant}"),
            ),
            factor,
        );
        out.push(Finding {
            fix: finding.fix.clone() + &or_mend,
            ..finding
        });
        return;
    }
    let fastest_of = |is_meant: &dyn Fn(&View) -> bool| {
        let meant = views.iter().copied().filter(|view| is_meant(view));
        meant
            .filter_map(|view| Some((view, largest(view.samples(Channel::WheelSpeed)?))))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let is_unsafe = |(_, speed): &(&View, f64)| {
        facts
            .torque_constant
            .is_some_and(|torque_constant| torque_constant * speed > SAFE_VOLTAGE_V)
    };
    // What the spin-ups show, all of them share.
    let fastest = fastest_of(&|view| view.kind() == Kind::SpinUp)
        .filter(is_unsafe)
        .or_else(|| fastest_of(&|_| true));
    let share = inertia.and_then(|inertia| Some(inertia / facts.total_inertia()?));
    // The wheel has less than half of the inertia that masses and lengths leave for body and wheel.
    let room = match (facts.total_inertia(), facts.steiner_kg_m2) {
        (Some(total), Some(steiner)) if total > steiner => Some(total - steiner),
        (total, _) => total,
    };
    // The unit of the speed with which the wheel has a typical share.
    let by_share = |readings: [f64; 2]| match share {
        Some(share) => readings
            .into_iter()
            .min_by(|a, b| {
                let off = |factor: &f64| (share * factor / USUAL_SHARE).ln().abs();
                off(a).total_cmp(&off(b))
            })
            .unwrap_or(readings[0]),
        None => readings[0],
    };
    if let (Some((view, speed)), Some(torque_constant)) = (fastest, facts.torque_constant)
        && torque_constant * speed > SAFE_VOLTAGE_V
    {
        let factor = by_share([RPM, DEGREES]);
        let (_, likely, _) = reading(factor);
        let stated = format!(
            "at {} rad/s the motor would generate {} V, more than any bench supplies",
            short(speed),
            short(torque_constant * speed)
        );
        // Another constant changes the inertia that the spin-ups give as another unit does.
        let fits =
            |factor: f64| share.is_none_or(|share| SHARE_OF_INERTIA.contains(&(share * factor)));
        let constant = short(torque_constant / 10.0);
        let finding = match (fits(factor), fits(0.1)) {
            (false, true) => Finding::refusal(
                FindingId::KnownRange,
                format!("{stated}: torque_constant is ten times too large"),
            )
            .with_channel("torque_constant")
            .with_fix(format!("torque_constant = {constant}, if that is right")),
            (is_speed, is_constant) => {
                let finding =
                    Finding::refusal(FindingId::WheelSpeedFactor, format!("{stated}: {likely}"));
                let finding = about_wheel(finding.in_experiment(view.name()), factor);
                match is_speed && !is_constant {
                    true => finding,
                    false => Finding {
                        sentence: format!("{}, or torque_constant is too large", finding.sentence),
                        fix: format!(
                            "{}; or torque_constant (ten times smaller: {constant})",
                            finding.fix
                        ),
                        ..finding
                    },
                }
            }
        };
        out.push(finding);
        return;
    }
    if let (Some(inertia), Some(room)) = (inertia, room)
        && inertia > room
    {
        let sentence = format!(
            "the spin-ups give a wheel inertia of {} kg m2, but the swings leave {} for it",
            short(inertia),
            short(room)
        );
        // No part can have more inertia than the whole; the inertia of the other parts is less certain.
        let make = if share.is_some_and(|share| share > 1.0) {
            Finding::refusal
        } else {
            Finding::warning
        };
        out.push(if by_share([1.0 / RPM, 1e-3]) == 1e-3 {
            let likely = "the current is in mA, or the time of the spin-ups in ms";
            make(FindingId::CurrentFactor, format!("{sentence}: {likely}"))
                .with_channel("current")
                .with_factor(1e3)
                .with_fix("units = { current = \"mA\" } or units = { time = \"ms\" }")
        } else {
            let likely =
                "is the speed in rad/s where rpm are stated, or torque_constant too large?";
            make(FindingId::WheelSpeedFactor, format!("{sentence}: {likely}"))
                .with_channel("wheel_speed")
                .with_factor(1.0 / RPM)
                .with_fix("units = { wheel_speed = \"rad/s\" }")
        });
        return;
    }
    if let (Some(share), Some(inertia)) = (share, inertia)
        && !SHARE_OF_INERTIA.contains(&share)
    {
        let factor = if share < SHARE_OF_INERTIA.start {
            by_share([RPM, DEGREES])
        } else {
            1.0 / RPM
        };
        out.push(about_wheel(
            Finding::warning(
                FindingId::WheelSpeedFactor,
                format!(
                    "the spin-ups say a wheel inertia of {} kg m2, {} % of the whole pendulum's: that is no \
                     reaction wheel; is the speed in another unit?",
                    short(inertia),
                    short(100.0 * share)
                ),
            ),
            factor,
        ));
        return;
    }
    let Some((view, speed)) = fastest else { return };
    let voltage = facts
        .torque_constant
        .map_or(0.0, |constant| constant * speed);
    if speed > FASTEST_RAD_S || voltage > USUAL_VOLTAGE_V {
        let generated = match voltage > 0.0 {
            true => format!(" and generates {} V", short(voltage)),
            false => String::new(),
        };
        out.push(
            about_wheel(
                Finding::warning(
                    FindingId::WheelSpeedFactor,
                    format!(
                        "the wheel turns at {} rad/s ({} rpm){generated}, more than usual motors do: is the \
                         speed in rpm?",
                        short(speed),
                        short(speed * RPM)
                    ),
                )
                .in_experiment(view.name()),
                RPM,
            ),
        );
    }
}
