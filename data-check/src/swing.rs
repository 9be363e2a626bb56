//! A free swing compared with the motion of a pendulum: its period, the dependence of the period on the amplitude, and
//! whether the body swings freely from the first sample on.

use bench_files::{Channel, Note};
use identify::{AtAmplitude, Output, resolution};
use plant::Kind;

use crate::finding::{Finding, FindingId, Severity};
use crate::slips::{DEGREES, short};
use crate::units::Settled;
use crate::view::{PERIODS_S, View, largest, median, range, scaled_decay};

use std::f64::consts::{PI, TAU};

/// Relative change of the period over the log above which its cause is searched for. Presliding and springs
/// change it by up to 4 % (the thesis' own bench), a pendulum with an amplitude of 1 rad by 6.6 %.
const CHANGE: f64 = 0.05;
/// Share of that change that the right unit may leave.
const LEFT_OVER: f64 = 0.25;
/// Standard errors of the period by which the change must show.
const STANDARD_ERRORS: f64 = 8.0;
/// Number of periods averaged at each end of the compared range.
const AT_EITHER_END: usize = 5;
/// Smallest amplitude that is compared, as a share of the largest. The period of a pendulum changes with the square
/// of the amplitude, so eight ninths of the change lie above it. The last swings before dry friction stops the body
/// have periods of their own.
const LEAST_AMPLITUDE: f64 = 1.0 / 3.0;

pub(crate) fn check(view: &View, settled: &mut Settled, out: &mut Vec<Finding>) {
    if view.kind() != Kind::FreeSwing {
        return;
    }
    let decay = scaled_decay(view);
    let before = out.len();
    if let Some((decay, scale)) = &decay {
        let periods = decay.periods.iter().map(|period| period.value).collect();
        if let Some(period_s) = median(periods) {
            period(view, period_s, out);
        }
        // The integral of a rate is wrong where the time is.
        if out.len() == before || view.samples(Channel::Angle).is_some() {
            angle_unit(view, &decay.periods, *scale, settled, out);
        }
    }
    if decay.is_none() {
        goes_round(view, out);
    }
    by_itself(view, out);
}

/// Way between two turning points, in turns, that a body without a motor does not make: once it has turned back, its
/// energy is below that of the top, and so less than one turn lies between two turning points. A tenth is for the noise.
const LONGEST_SWING: f64 = 1.1;
/// Fewest such ways: a hand may have made the first.
const FEWEST_ROUNDS: usize = 3;
/// Way back, in rad, that shows a turning point.
const TURNS_BACK_RAD: f64 = 1.0;

/// Checks the range of an angle in which no swing can be seen.
fn goes_round(view: &View, out: &mut Vec<Finding>) {
    let Some(angle) = view.samples(Channel::Angle) else {
        return;
    };
    let ways = ways_between_turning_points(angle);
    let is_round = |way: &&f64| **way > LONGEST_SWING * TAU;
    if ways.iter().filter(is_round).count() < FEWEST_ROUNDS {
        return;
    }
    let longest = largest(&ways);
    out.push(
        Finding::refusal(
            FindingId::AngleFactor,
            format!(
                "the body would turn back and go round again, by up to {} turns, without a motor: the angle is in degrees",
                short(longest / TAU)
            ),
        )
        .in_experiment(view.name())
        .with_channel("angle")
        .with_factor(DEGREES)
        .with_fix("units = { angle = \"deg\" }"),
    );
}

/// The ways between neighbouring turning points, rad, without those before the first and after the last.
fn ways_between_turning_points(angle: &[f64]) -> Vec<f64> {
    let mut finite = angle.iter().copied().filter(|angle| angle.is_finite());
    let Some(first) = finite.next() else {
        return vec![];
    };
    let mut ways = vec![];
    let mut turned_at: Option<f64> = None;
    // The farthest points since the last turning point; the sense is 0 until the body has moved.
    let (mut low, mut high, mut sense) = (first, first, 0.0);
    for angle in finite {
        (low, high) = (low.min(angle), high.max(angle));
        let (turns, farthest) = if sense >= 0.0 && angle < high - TURNS_BACK_RAD {
            (true, high)
        } else if sense <= 0.0 && angle > low + TURNS_BACK_RAD {
            (true, low)
        } else {
            (false, angle)
        };
        if turns {
            if let Some(before) = turned_at
                && sense != 0.0
            {
                ways.push((farthest - before).abs());
            }
            // The way to the first reversal may be a throw.
            turned_at = (sense != 0.0).then_some(farthest);
            sense = if farthest == high { -1.0 } else { 1.0 };
            (low, high) = (angle, angle);
        }
    }
    ways
}

/// Units in which a time can be, as the factor by which it is then read too large, and how they are stated.
const TIMES: [(f64, &str); 7] = [
    (1e3, "units = { time = \"ms\" }"),
    (1e6, "units = { time = \"us\" }"),
    (1e9, "units = { time = \"ns\" }"),
    // Milliseconds are stated, and seconds are in the file.
    (1e-3, "units = { time = \"s\" }"),
    (
        1.0 / 60.0,
        "scale = { time = 60.0 } if the time is in minutes",
    ),
    (
        1.0 / 3600.0,
        "scale = { time = 3600.0 } if the time is in hours",
    ),
    // Spreadsheets count days.
    (
        1.0 / 86_400.0,
        "scale = { time = 86400.0 } if the time is in days",
    ),
];

/// Checks whether a pendulum on a bench can have this period.
pub(crate) fn period(view: &View, period_s: f64, out: &mut Vec<Finding>) {
    if PERIODS_S.contains(&period_s) {
        return;
    }
    let stated = format!(
        "a period is {} s, as of a pendulum of {} m",
        short(period_s),
        short(9.81 * (period_s / TAU).powi(2))
    );
    let finding = |sentence: String| {
        Finding::refusal(FindingId::TimeFactor, sentence)
            .in_experiment(view.name())
            .with_channel("time")
    };
    if view.counts_lines() && period_s > 1.0 {
        let sentence =
            format!("{stated}: the time counts the lines, or is in another unit than seconds");
        let fix = "time_step = … (seconds from line to line) in the place of the time's column";
        out.push(finding(sentence).with_fix(fix));
        return;
    }
    // The unit of time that gives a period nearest to one second.
    let off = |factor: f64| (period_s / factor).ln().abs();
    let nearest = TIMES.into_iter();
    let nearest = nearest.min_by(|a, b| off(a.0).total_cmp(&off(b.0)));
    let Some((factor, fix)) = nearest else { return };
    out.push(
        finding(format!(
            "{stated}: the time is {} times too large",
            short(factor)
        ))
        .with_factor(factor)
        .with_fix(fix),
    );
}

/// Arithmetic-geometric mean; the period of a pendulum is T₀/agm(1, cos(A/2)).
fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

/// Relative change of the period of small swings from the smallest amplitudes to the largest, if the
/// true angle is `scale` times that of the points; `None` if the body would go over the top.
fn change_of_period(periods: &[AtAmplitude], scale: f64) -> Option<f64> {
    let count = AT_EITHER_END.min(periods.len() / 2);
    let mean = |part: &[AtAmplitude]| -> Option<f64> {
        let small = part.iter().map(|point| {
            let amplitude = scale * point.amplitude_rad;
            (amplitude < 0.99 * PI).then(|| point.value * agm(1.0, (0.5 * amplitude).cos()))
        });
        Some(small.sum::<Option<f64>>()? / count as f64)
    };
    if count == 0 {
        return None;
    }
    Some((mean(&periods[..count])? / mean(&periods[periods.len() - count..])?).ln())
}

/// The largest amplitude, and the periods that are compared with each other.
fn large_swings(periods: &[AtAmplitude]) -> (f64, Vec<AtAmplitude>) {
    let largest = periods
        .iter()
        .fold(0.0, |most: f64, p| most.max(p.amplitude_rad));
    let large = periods.iter();
    let large = large.filter(|point| point.amplitude_rad >= LEAST_AMPLITUDE * largest);
    (largest, large.cloned().collect())
}

fn angle_unit(
    view: &View,
    periods: &[AtAmplitude],
    scale: f64,
    settled: &mut Settled,
    out: &mut Vec<Finding>,
) {
    // Of a rate alone, the amplitude is that of its integral.
    let (id, key, units) = if view.samples(Channel::Angle).is_some() {
        (FindingId::AngleFactor, "angle", ["rev", "deg", "mrad"])
    } else {
        (FindingId::RateFactor, "rate", ["rev/s", "deg/s", "mrad/s"])
    };
    let (largest, periods) = large_swings(periods);
    let amplitude = scale * largest;
    let periods = periods.as_slice();
    let as_mapped = change_of_period(periods, scale);
    // The other possible units of the column, and the change that each leaves.
    let others = [1.0 / TAU, DEGREES, 1e3];
    let left = others
        .into_iter()
        .filter_map(|factor| Some((factor, change_of_period(periods, scale / factor)?.abs())))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((factor, left)) = left else { return };
    let unit = units[others.iter().position(|one| *one == factor).unwrap_or(1)];
    let finding = |sentence: String| {
        Finding::refusal(id, sentence)
            .in_experiment(view.name())
            .with_channel(key)
            .with_factor(factor)
            .with_fix(format!("units = {{ {key} = \"{unit}\" }}"))
    };
    let Some(change) = as_mapped else {
        out.push(finding(format!(
            "the body would turn back {} rad from hanging, beyond the top: the {key} is {} times too large",
            short(amplitude),
            short(factor)
        )));
        return;
    };
    let std =
        periods.iter().map(|p| p.std / p.value).fold(0.0, f64::max) / (AT_EITHER_END as f64).sqrt();
    if change.abs() > CHANGE
        && change.abs() > STANDARD_ERRORS * std
        && left < LEFT_OVER * change.abs()
    {
        out.push(if factor > 1.0 {
            finding(format!(
                "the period does not depend on the amplitude, but that of a pendulum of {} rad would change by \
                 {} %: the {key} is {} times too large",
                short(amplitude),
                short(100.0 * change.abs()),
                short(factor)
            ))
        } else {
            // A spring at the pivot can do the same.
            Finding {
                severity: Severity::Warn,
                ..finding(format!(
                    "the period changes by {} % more than that of a pendulum of {} rad, as if the {key} were in turns",
                    short(100.0 * change.abs()),
                    short(amplitude)
                ))
            }
        });
    } else if left > CHANGE && left > STANDARD_ERRORS * std && change.abs() < LEFT_OVER * left {
        // In any other unit the period would depend on the amplitude in a way that no pendulum's does.
        settled.add(view, Channel::Angle);
        settled.add(view, Channel::Rate);
    }
}

/// Range within which a body counts as still, in standard deviations of the noise.
const STILL: f64 = 4.0;
/// Share of a period for which the body may stand still at its first turning point: a release by hand takes that long.
const RELEASE: f64 = 0.25;
/// Growth of the turning points on one side, relative to the amplitude, above which a hand moved the body.
const GAIN: f64 = 0.03;

/// Checks for a body that is held first, or that gains energy: neither swings freely.
fn by_itself(view: &View, out: &mut Vec<Finding>) {
    let Some(angle) = view.samples(Channel::Angle) else {
        return;
    };
    let time_s = &view.experiment.log.time_s;
    let Some((low, high)) = range(angle) else {
        return;
    };
    let half_range = 0.5 * (high - low);
    let resolution = resolution(angle);
    let still = (STILL * view.noise(Output::Angle))
        .max(2.0 * resolution)
        .max(0.02 * half_range);
    if still > 0.3 * half_range {
        return;
    }
    let (extremes, zero_rad) = turning_points(view, angle, still);
    let Some(period_s) = usual_period_s(&extremes) else {
        return;
    };
    let largest = extremes
        .iter()
        .max_by(|a, b| (a.1 - zero_rad).abs().total_cmp(&(b.1 - zero_rad).abs()));
    let Some(&(largest_s, _)) = largest else {
        return;
    };

    // The longest beginning during which the angle stays within a band.
    let mut bounds = (f64::INFINITY, f64::NEG_INFINITY);
    let held = angle
        .iter()
        .take_while(|x| {
            if x.is_finite() {
                bounds = (bounds.0.min(**x), bounds.1.max(**x));
            }
            bounds.1 - bounds.0 <= 2.0 * still || bounds.0 > bounds.1
        })
        .count();
    let held_s = time_s[held.min(time_s.len() - 1)] - time_s[0];
    let held_at = (0.5 * (bounds.0 + bounds.1) - zero_rad).abs();
    let near_turning_s = period_s / TAU * 2.0 * (1.0 - 2.0 * still / half_range).acos();
    if held < angle.len() && held_s > near_turning_s + RELEASE * period_s {
        // A body held away from the hanging position is released; one held in the hanging position is lifted first.
        let from_s = if held_at > 0.5 * half_range {
            time_s[held.saturating_sub(1)]
        } else {
            largest_s
        };
        let sentence = format!(
            "the body stands still for {} s before it swings: it was held, which is not part of the model",
            short(held_s)
        );
        let finding = if held_s > 0.5 * period_s {
            Finding::refusal(FindingId::HeldStart, sentence)
        } else {
            Finding::warning(FindingId::HeldStart, sentence)
        };
        out.push(
            finding
                .in_experiment(view.name())
                .with_channel("angle")
                .with_fix(format!("from = {}", rounded_up(from_s))),
        );
        return;
    }
    // What happened in a pause is unknown: the swing after it may be another one.
    let mut notes = view.experiment.report.notes.iter();
    if notes.any(|note| matches!(note, Note::Gap { .. })) {
        return;
    }
    // The first stretch can begin in the middle of a swing, and so has no turning point.
    let size = |point: &(f64, f64)| (point.1 - zero_rad).abs();
    let least_gain = (GAIN * half_range).max(1.5 * still);
    let gain = extremes
        .iter()
        .enumerate()
        .skip(1)
        .find_map(|(index, before)| {
            let later = extremes[index + 1..].iter();
            later
                .filter(|after| (before.1 - zero_rad) * (after.1 - zero_rad) > 0.0)
                .find(|after| size(after) > size(before) + least_gain)
        });
    if let Some(after) = gain {
        out.push(
            Finding::warning(
                FindingId::Hand,
                format!(
                    "the swing grows at {} s without a current: a hand, or something else that the model \
                     does not know, was on it",
                    short(after.0)
                ),
            )
            .in_experiment(view.name())
            .with_channel("angle")
            .with_fix(format!("from = {}", rounded_up(largest_s))),
        );
    }
}

/// A time rounded up to a few digits.
fn rounded_up(time_s: f64) -> f64 {
    (time_s * 1e3).ceil() / 1e3
}

/// The farthest point between every two crossings of the middle (time and angle), and the middle.
fn turning_points(view: &View, angle: &[f64], clear: f64) -> (Vec<(f64, f64)>, f64) {
    let time_s = &view.experiment.log.time_s;
    // Late in the log, the swing is small, so the median is the rest position.
    let zero = median(angle.to_vec()).unwrap_or(0.0);
    let mut points: Vec<(f64, f64)> = vec![];
    let mut side = 0.0;
    for (t, x) in time_s.iter().zip(angle) {
        let off = x - zero;
        if off.abs() <= clear || !x.is_finite() {
            continue;
        }
        if off.signum() != side {
            side = off.signum();
            points.push((*t, *x));
        } else if let Some(last) = points.last_mut()
            && off.abs() > (last.1 - zero).abs()
        {
            *last = (*t, *x);
        }
    }
    (points, zero)
}

fn usual_period_s(extremes: &[(f64, f64)]) -> Option<f64> {
    let halves: Vec<f64> = extremes
        .windows(2)
        .map(|pair| pair[1].0 - pair[0].0)
        .collect();
    (halves.len() >= 2).then(|| median(halves).map(|half| 2.0 * half))?
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that is thrown round three times and then swings has no way that a pendulum does not make; one that
    /// is read in degrees has many.
    #[test]
    fn a_throw_is_no_way_between_turning_points() {
        let time = (0..4000).map(|k| 0.01 * f64::from(k));
        let thrown: Vec<f64> = time
            .clone()
            .map(|t| 6.0 * PI * (1.0 - (-t).exp()) + 1.5 * (9.0 * t).sin() * (1.0 - (-t).exp()))
            .collect();
        let ways = ways_between_turning_points(&thrown);
        assert!(!ways.is_empty());
        assert!(largest(&ways) < TAU, "{ways:?}");
        let degrees: Vec<f64> = time.map(|t| 30.0 * (9.0 * t).cos()).collect();
        let ways = ways_between_turning_points(&degrees);
        assert!(
            ways.iter().all(|way| (way / 60.0 - 1.0).abs() < 0.02),
            "{ways:?}"
        );
        assert!(ways.len() > 100);
    }

    /// A swing from 0.9 rad that dry friction ends: its last periods are longer by what a pendulum of that
    /// amplitude would have too much. All of them together look like a period that knows no amplitude.
    #[test]
    fn the_last_swings_before_a_stop_do_not_count() {
        let periods: Vec<AtAmplitude> = (0..40)
            .map(|index| {
                let amplitude_rad = 0.9 - 0.022 * f64::from(index);
                let stops = if index >= 34 { 1.055 } else { 1.0 };
                AtAmplitude {
                    time_s: 0.6 * f64::from(index),
                    amplitude_rad,
                    value: 0.6 * stops / agm(1.0, (0.5 * amplitude_rad).cos()),
                    std: 1e-4,
                }
            })
            .collect();
        let all = change_of_period(&periods, 1.0).expect("below the top");
        assert!(all.abs() > CHANGE, "{all}");
        let (_, large) = large_swings(&periods);
        let large = change_of_period(&large, 1.0).expect("below the top");
        assert!(large.abs() < 1e-9, "{large}");
    }
}
