//! A free swing compared with the motion of a pendulum: its period, and the dependence of the period on the amplitude.

use bench_files::Channel;
use identify::AtAmplitude;
use plant::Kind;

use crate::finding::{Finding, FindingId, Severity};
use crate::slips::{DEGREES, short};
use crate::thresholds::bench::PERIODS_S;
use crate::thresholds::fit::STANDARD_ERRORS;
use crate::thresholds::swing::{
    AT_EITHER_END, CHANGE, FEWEST_ROUNDS, LEAST_AMPLITUDE, LEFT_OVER, LONGEST_SWING, TURNS_BACK_RAD,
};
use crate::units::Settled;
use crate::view::{View, agm, largest, median};

use std::f64::consts::{PI, TAU};

pub(crate) fn check(view: &View, settled: &mut Settled, out: &mut Vec<Finding>) {
    if view.kind() != Kind::FreeSwing {
        return;
    }
    let decay = view.scaled_decay();
    let before = out.len();
    if let Some((decay, scale)) = decay {
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
}

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
