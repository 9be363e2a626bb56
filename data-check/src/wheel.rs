//! The wheel compared with its current, with the body, and with what a wheel and a motor can do.

use bench_files::{Bench, Channel};
use identify::{Output, bumps};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::regression::{LeastSquares, least_squares};
use crate::slips::{DEGREES, RPM, short, slip};
use crate::thresholds::bench::SHARE_OF_INERTIA;
use crate::thresholds::fit::{EXPLAINED, STANDARD_ERRORS};
use crate::thresholds::wheel::{
    ALIKE, BELOW_ZERO, BENCH_CURRENT_A, BENCH_POWER_W, FASTEST_RAD_S, NO_EFFECT, OVER_LIMIT,
    SAFE_VOLTAGE_V, USUAL_SHARE, USUAL_VOLTAGE_V,
};
use crate::view::{Facts, View, largest, median, range};

/// The response of a wheel to its current.
pub(crate) struct Answer {
    /// Acceleration per ampere, 1/s² A⁻¹.
    pub per_ampere: f64,
}

/// The responses in all logs that show one, with their fits.
pub(crate) type Answers<'v> = Vec<(&'v View<'v>, Answer, LeastSquares)>;

/// The response in one log; `None` if the log does not show it.
fn answer(view: &View) -> Option<(Answer, LeastSquares)> {
    if view.kind() == Kind::FreeSwing {
        return None;
    }
    let speed = view.samples(Channel::WheelSpeed)?;
    let current = view.samples(Channel::Current)?;
    if largest(current) == 0.0 {
        return None;
    }
    let found = view.bump_lengths_s().filter_map(|length_s| {
        let mut rows = vec![];
        bumps(&view.record, length_s, |integral| {
            let row = [integral(&|k| current[k], 0), -integral(&|k| speed[k], 0)];
            rows.push((row, -integral(&|k| speed[k], 1)));
        });
        // Neighbouring bumps overlap by half.
        least_squares(&rows, 2.0)
    });
    let sharpness = |fit: &LeastSquares| (fit.coefficients[0] / fit.std[0]).abs();
    let best = found.max_by(|a, b| sharpness(a).total_cmp(&sharpness(b)))?;
    (sharpness(&best) > STANDARD_ERRORS).then(|| {
        let answer = Answer {
            per_ampere: best.coefficients[0],
        };
        (answer, best)
    })
}

pub(crate) fn answers<'v>(views: &[&'v View<'v>]) -> Answers<'v> {
    let found = views.iter().copied();
    found
        .filter_map(|view| answer(view).map(|(answer, fit)| (view, answer, fit)))
        .collect()
}

pub(crate) fn check(
    bench: &Bench,
    views: &[&View],
    answers: &Answers,
    facts: &Facts,
    out: &mut Vec<Finding>,
) {
    // A sensor without a sign is wrong only where the current is negative.
    let mut against = answers
        .iter()
        .filter(|(_, answer, _)| answer.per_ampere < 0.0);
    let is_unsigned = against.all(|(view, _, _)| is_backwards(view) && is_never_negative(view));
    for (view, answer, fit) in answers {
        sign(view, answer, fit, is_unsigned, out);
    }
    // Only spin-ups are free of the body's motion.
    let spin_ups: Vec<(&View, f64)> = answers
        .iter()
        .filter(|(view, _, _)| view.kind() == Kind::SpinUp)
        .map(|(view, answer, _)| (*view, answer.per_ampere.abs()))
        .collect();
    let before = out.len();
    odd_one_out(&spin_ups, out);
    if out.len() == before {
        all_together(bench, views, &spin_ups, facts, out);
    }
    for view in views {
        size_of_current(bench, view, facts, out);
    }
}

/// Checks the sign: a driven wheel accelerates in the direction of its current. Otherwise friction would drive it.
fn sign(
    view: &View,
    answer: &Answer,
    fit: &LeastSquares,
    is_unsigned: bool,
    out: &mut Vec<Finding>,
) {
    if answer.per_ampere >= 0.0 || fit.explained < EXPLAINED {
        return;
    }
    // A tachometer that counts pulses does not know the direction.
    let unsigned = if is_unsigned {
        ". If the sensor of the wheel never shows a minus, the cure is instead sign = { wheel_speed = -1 } for this log \
         alone"
    } else {
        ""
    };
    out.push(
        Finding::refusal(
            FindingId::CurrentSign,
            "the wheel speeds up against its current: one of the two has the wrong sign (factor -1)",
        )
        .in_experiment(view.name())
        .with_channel("current")
        .with_factor(-1.0)
        .with_fix(format!(
            "sign = {{ current = -1 }} (or sign = {{ wheel_speed = -1 }}, if the wheel's speed is not \
             positive in the sense of the positive angle){unsigned}"
        )),
    );
}

/// Whether the usual current of a log is negative.
fn is_backwards(view: &View) -> bool {
    let current = view.samples(Channel::Current).unwrap_or_default();
    median(current.to_vec()).is_some_and(|usual| usual < 0.0)
}

/// Whether the wheel's speed never falls below 0 by more than its noise.
fn is_never_negative(view: &View) -> bool {
    let speed = view.samples(Channel::WheelSpeed).unwrap_or_default();
    range(speed).is_some_and(|(low, _)| low >= -BELOW_ZERO * view.noise(Output::WheelSpeed))
}

/// Checks that all spin-ups of one wheel have the same acceleration per ampere.
fn odd_one_out(spin_ups: &[(&View, f64)], out: &mut Vec<Finding>) {
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

/// Checks the wheel inertia from all spin-ups against its possible range.
fn all_together(
    bench: &Bench,
    views: &[&View],
    spin_ups: &[(&View, f64)],
    facts: &Facts,
    out: &mut Vec<Finding>,
) {
    let about_wheel = |finding: Finding, factor: f64| {
        let (channel, _, fix) = reading(factor);
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
        out.push(about_wheel(
            Finding::refusal(
                FindingId::WheelSpeedFactor,
                format!(
                    "the spin-ups give a wheel inertia of {} kg m2, [known] says {}: {likely}",
                    short(found),
                    short(known)
                ),
            ),
            factor,
        ));
        return;
    }
    let fastest = views
        .iter()
        .copied()
        .filter_map(|view| Some((view, largest(view.samples(Channel::WheelSpeed)?))))
        .max_by(|a, b| a.1.total_cmp(&b.1));
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
        out.push(
            about_wheel(
                Finding::refusal(
                    FindingId::WheelSpeedFactor,
                    format!(
                        "at {} rad/s the motor would generate {} V, more than any bench supplies: {likely}",
                        short(speed),
                        short(torque_constant * speed)
                    ),
                ),
                factor,
            )
            .in_experiment(view.name()),
        );
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
                ),
                RPM,
            )
            .in_experiment(view.name()),
        );
    }
}

/// Checks for a current that no bench motor takes.
fn size_of_current(bench: &Bench, view: &View, facts: &Facts, out: &mut Vec<Finding>) {
    let Some(current) = view.samples(Channel::Current) else {
        return;
    };
    let most = largest(current);
    let milliamperes = |finding: Finding| {
        finding
            .in_experiment(view.name())
            .with_channel("current")
            .with_factor(1e3)
            .with_fix("units = { current = \"mA\" }")
    };
    let limit = bench
        .controller
        .map(|controller| controller.current_limit_a);
    if let (Kind::Balance, Some(limit)) = (view.kind(), limit)
        && most > BENCH_CURRENT_A.min(OVER_LIMIT * limit)
    {
        out.push(milliamperes(Finding::refusal(
            FindingId::CurrentFactor,
            format!(
                "the current goes up to {} A, {} times current_limit: it is in mA",
                short(most),
                short(most / limit)
            ),
        )));
        return;
    }
    let power = match (facts.torque_constant, view.samples(Channel::WheelSpeed)) {
        (Some(torque_constant), Some(speed)) => {
            let products = speed.iter().zip(current);
            products
                .map(|(speed, current)| torque_constant * (speed * current).abs())
                .filter(|power| power.is_finite())
                .fold(0.0, f64::max)
        }
        _ => 0.0,
    };
    if most > BENCH_CURRENT_A && power > BENCH_POWER_W {
        out.push(milliamperes(Finding::refusal(
            FindingId::CurrentFactor,
            format!(
                "with {} A the motor would give {} W: the current is in mA",
                short(most),
                short(power)
            ),
        )));
    } else if most > BENCH_CURRENT_A {
        out.push(milliamperes(Finding::warning(
            FindingId::CurrentFactor,
            format!("the current goes up to {} A: is it in mA?", short(most)),
        )));
    }
}
