//! The rate compared with the derivative of the angle. No torque enters, so an effect that a model lacks cannot look
//! like a wrong unit or sign here.

use bench_files::Channel;
use identify::Output;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::{DEGREES, RPM, short, slip};
use crate::thresholds::kinematics::{
    CLEAR, MOST_LATE, OVER_NOISE, SCALE_ERROR, SHORTFALL, UNRELATED, USUAL_DELAY,
};
use crate::units::Settled;
use crate::view::{View, largest, median, range};

/// The remedy where the body's rate was taken for the wheel's speed.
pub(crate) const IS_THE_RATE: &str = "columns = { rate = … } in the place of wheel_speed";

/// Checks whether the columns are those of their channels: no column twice, none in another's place. Returns whether a
/// finding says that they are not; then no other comparison means anything.
pub(crate) fn columns(view: &View, out: &mut Vec<Finding>) -> bool {
    if same_columns(view, out) {
        return true;
    }
    let (angle, rate) = (view.samples(Channel::Angle), view.samples(Channel::Rate));
    if let (Some(angle), None, Some(speed)) = (angle, rate, view.samples(Channel::WheelSpeed))
        && view.kind() != Kind::SpinUp
        && is_derivative(view, angle, speed)
    {
        // A motor turns body and wheel in opposite senses, and a wheel that no torque reaches turns against the body.
        out.push(
            Finding::refusal(
                FindingId::RateFactor,
                "the wheel's speed is the derivative of the body's angle: it is the body's rate",
            )
            .in_experiment(view.name())
            .with_channel("wheel_speed")
            .with_fix(IS_THE_RATE),
        );
        return true;
    }
    let (Some(angle), Some(rate)) = (angle, rate) else {
        return false;
    };
    if view.kind() == Kind::SpinUp || is_derivative(view, angle, rate) {
        return false;
    }
    let speed = view.samples(Channel::WheelSpeed);
    let (sentence, other) = if is_derivative(view, rate, angle) {
        (
            "the angle is the derivative of the rate: the two columns are swapped",
            "angle",
        )
    } else if speed.is_some_and(|speed| is_derivative(view, angle, speed)) {
        (
            "the wheel's speed is the derivative of the body's angle, and the rate is not: the two columns are swapped",
            "wheel_speed",
        )
    } else {
        return false;
    };
    out.push(
        Finding::refusal(FindingId::RateFactor, sentence)
            .in_experiment(view.name())
            .with_channel("rate")
            .with_fix(format!(
                "columns = {{ {other} = …, rate = … }}, each with the other's column"
            )),
    );
    true
}

/// Whether `samples` are the derivative of `of`, within the errors of a sensor.
fn is_derivative(view: &View, of: &[f64], samples: &[f64]) -> bool {
    view.ratio_to_derivative(of, samples)
        .is_some_and(|(found, _)| {
            found.correlation > CLEAR && (found.factor - 1.0).abs() < SCALE_ERROR
        })
}

/// All checks of angle and rate against each other, of a log whose columns are in their places.
pub(crate) fn check(view: &View, settled: &mut Settled, out: &mut Vec<Finding>) {
    let (Some(angle), Some(rate)) = (view.samples(Channel::Angle), view.samples(Channel::Rate))
    else {
        return;
    };
    if view.kind() == Kind::SpinUp {
        return;
    }
    let Some((found, length_s)) = view.ratio_to_derivative(angle, rate) else {
        return;
    };
    if late(view, angle, rate, (found.correlation, length_s), out) {
        return;
    }
    if found.correlation.abs() < UNRELATED {
        let moves = |output, samples| {
            range(samples).is_some_and(|(low, high)| high - low > OVER_NOISE * view.noise(output))
        };
        if view.kind() == Kind::FreeSwing
            && moves(Output::Angle, angle)
            && moves(Output::Rate, rate)
        {
            out.push(
                Finding::warning(
                    FindingId::RateFactor,
                    "the rate is not correlated with the derivative of the angle",
                )
                .in_experiment(view.name())
                .with_channel("rate")
                .with_fix("columns = { rate = … }: name the column of the body's rate, or none"),
            );
        }
        return;
    }
    if found.correlation.abs() < CLEAR {
        return;
    }
    let finding = |refused: bool, sentence: String| {
        let make = if refused {
            Finding::refusal
        } else {
            Finding::warning
        };
        make(FindingId::RateFactor, sentence)
            .in_experiment(view.name())
            .with_channel("rate")
    };
    let stated = format!(
        "the rate is {} times the derivative of the angle",
        short(found.factor)
    );
    match slip(found.factor) {
        _ if view.counts_lines() && found.factor > 1.0 + SCALE_ERROR => {
            let step = short(1.0 / found.factor);
            out.push(
                Finding::refusal(
                    FindingId::TimeFactor,
                    format!(
                        "{stated}: the time counts the lines, and {step} s lie between two of them"
                    ),
                )
                .in_experiment(view.name())
                .with_channel("time")
                .with_fix(format!(
                    "time_step = {step} in the place of the time's column"
                )),
            );
        }
        Some(factor) => {
            let (likely, fix) = reading(factor, angle);
            out.push(
                finding(true, format!("{stated}: {likely}"))
                    .with_factor(factor)
                    .with_fix(fix),
            );
        }
        None if (found.factor - 1.0).abs() > SCALE_ERROR => out.push(
            finding(false, format!("{stated}, and no unit explains that factor"))
                .with_factor(found.factor)
                .with_fix(format!(
                    "scale = {{ rate = {} }} if the sensor's scale is wrong",
                    short(1.0 / found.factor)
                )),
        ),
        // The two have one unit: what tells that of one tells that of the other.
        None => {
            let unstated = |channel: Channel| {
                let mut unstated = view.experiment.report.unstated.iter();
                unstated.any(|one| one.channel == channel)
            };
            let one = [Channel::Angle, Channel::Rate]
                .into_iter()
                .any(|channel| settled.has(view, channel) || !unstated(channel));
            if one {
                settled.add(view, Channel::Angle);
                settled.add(view, Channel::Rate);
            }
        }
    }
}

/// The cause of a factor between rate and derivative, and its remedy.
fn reading(factor: f64, angle: &[f64]) -> (String, String) {
    let near = |size: f64| (factor.abs() / size).ln().abs() < 0.01;
    let sign = if factor < 0.0 && factor != -1.0 {
        " (and sign = { rate = -1 })"
    } else {
        ""
    };
    let (likely, fix) = if factor == -1.0 {
        (
            "one of the two has the wrong sign",
            "sign = { rate = -1 } (or sign = { angle = -1 }, if the angle does not grow in the positive sense)",
        )
    } else if near(DEGREES) {
        (
            "the rate is in degrees a second",
            "units = { rate = \"deg/s\" }",
        )
    } else if near(1.0 / DEGREES) && largest(angle) > 1.0 {
        ("the angle is in degrees", "units = { angle = \"deg\" }")
    } else if near(1.0 / DEGREES) {
        (
            "one of the two is in degrees",
            "units = { angle = \"deg\" }, or take units = { rate = \"deg/s\" } out",
        )
    } else if near(RPM) {
        (
            "the rate is in revolutions a minute",
            "units = { rate = \"rpm\" }",
        )
    } else if near(1e3) {
        (
            "the time is in milliseconds, or the rate in mrad/s",
            "units = { time = \"ms\" } (or units = { rate = \"mrad/s\" })",
        )
    } else if near(1e-3) {
        (
            "the angle is in milliradians, or the time is in seconds where milliseconds are stated",
            "units = { angle = \"mrad\" }, or take units = { time = \"ms\" } out",
        )
    } else if near(1e6) {
        ("the time is in microseconds", "units = { time = \"us\" }")
    } else if near(1e9) {
        ("the time is in nanoseconds", "units = { time = \"ns\" }")
    } else {
        (
            "one of the two is in another unit",
            "units = { angle = …, rate = … }",
        )
    };
    (likely.to_owned(), format!("{fix}{sign}"))
}

/// Checks whether the rate is the derivative of the angle, but delayed or advanced.
fn late(
    view: &View,
    angle: &[f64],
    rate: &[f64],
    (at_once, length_s): (f64, f64),
    out: &mut Vec<Finding>,
) -> bool {
    // The rate is taken `shift` samples later or earlier.
    let correlation = |shift: isize| -> f64 {
        let at = |k: usize| k.checked_add_signed(shift).and_then(|k| rate.get(k));
        let moved = (0..rate.len()).map(|k| at(k).copied().unwrap_or(f64::NAN));
        let found = view.ratio_by_bumps(angle, &moved.collect::<Vec<f64>>(), length_s);
        found.map_or(0.0, |found| found.correlation)
    };
    // A swing repeats itself: a shift by a whole period more fits as well, and means nothing. Between two such shifts
    // the correlation is negative.
    let most = MOST_LATE.min(view.record.len() as isize / 20);
    let outwards = |sense: isize| {
        (1..=most)
            .map(move |size| sense * size)
            .map(|shift| (shift, correlation(shift)))
            .take_while(|(_, correlation)| *correlation > 0.0)
    };
    let Some((shift, best)) = outwards(1)
        .chain(outwards(-1))
        .max_by(|a, b| a.1.total_cmp(&b.1))
    else {
        return false;
    };
    let is_late = shift.unsigned_abs() > USUAL_DELAY
        && best > CLEAR
        && at_once > 0.0
        && 1.0 - best < (1.0 - at_once) * SHORTFALL;
    if is_late {
        let (late, early) = if shift > 0 {
            ("rate", "angle")
        } else {
            ("angle", "rate")
        };
        let delay_s = shift.unsigned_abs() as f64 * view.step_s;
        out.push(
            Finding::warning(
                FindingId::LateChannel,
                format!(
                    "the {late} is delayed by {} s against the {early}",
                    short(delay_s)
                ),
            )
            .in_experiment(view.name())
            .with_channel(late)
            .with_fix(match late {
                "rate" => {
                    "add the effect rate-delay to the model, or rate-lag where a filter makes the rate \
                     late; a diagnosis tells which"
                }
                _ => "add the effect angle-delay to the model",
            }),
        );
    }
    is_late
}

/// Checks whether two channels are the same series, perhaps in different units.
fn same_columns(view: &View, out: &mut Vec<Finding>) -> bool {
    let channels = [Channel::Angle, Channel::Rate, Channel::WheelSpeed];
    let mut found = false;
    for (index, &first) in channels.iter().enumerate() {
        for &second in &channels[index + 1..] {
            let (Some(a), Some(b)) = (view.samples(first), view.samples(second)) else {
                continue;
            };
            if !is_multiple(a, b) {
                continue;
            }
            found = true;
            out.push(
                Finding::refusal(
                    FindingId::SameColumn,
                    format!(
                        "{} and {} have the same samples: both come from one column",
                        first.key(),
                        second.key()
                    ),
                )
                .in_experiment(view.name())
                .with_channel(second.key())
                .with_fix(format!(
                    "columns = {{ {} = … }}: name the column of this channel",
                    second.key()
                )),
            );
        }
    }
    found
}

/// Whether b is a multiple of a, sample by sample, to the last digit. Two different sensors never are.
fn is_multiple(a: &[f64], b: &[f64]) -> bool {
    let middle = |values: &[f64]| median(values.to_vec()).unwrap_or(0.0);
    let (mid_a, mid_b) = (middle(a), middle(b));
    let pairs: Vec<(f64, f64)> = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - mid_a, b - mid_b))
        .filter(|(a, b)| a.is_finite() && b.is_finite())
        .collect();
    let mut distinct: Vec<f64> = pairs.iter().map(|(a, _)| *a).collect();
    distinct.sort_unstable_by(f64::total_cmp);
    distinct.dedup();
    let Some(largest) = pairs.iter().max_by(|p, q| p.0.abs().total_cmp(&q.0.abs())) else {
        return false;
    };
    let factor = largest.1 / largest.0;
    // At least twenty levels: a few equal values may be accidental, as where neither sensor moves.
    distinct.len() >= 20
        && factor.is_finite()
        && factor != 0.0
        && pairs
            .iter()
            .all(|(a, b)| (b - factor * a).abs() <= 1e-9 * largest.1.abs())
}
