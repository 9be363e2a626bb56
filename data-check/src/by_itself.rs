//! Whether the body of a free swing swings by itself from the first sample to the last: it is not held, and no hand gives
//! it energy.

use std::f64::consts::{PI, TAU};

use bench_files::{Channel, Note};
use identify::{held_start, noise_std, resolution};

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::swing::{
    GAIN_NOISE, GAIN_OF_SWING, GAIN_SHARE, GAIN_STEPS, LONG_HOLD, RELEASE, SETTING_GOING, STILL,
    STILL_SHARE, STILL_STEPS, TOO_WIDE,
};
use crate::view::{View, median, range, spoken};

/// The oscillation of one channel about its middle.
struct Swing<'v> {
    view: &'v View<'v>,
    channel: Channel,
    samples: &'v [f64],
    noise: f64,
    step: f64,
    half_range: f64,
    /// The farthest point between every two crossings of the middle: time and distance from the middle.
    turns: Vec<(f64, f64)>,
    middle: f64,
    period_s: f64,
}

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    if let Some(swing) = Swing::of(view, Channel::Angle) {
        if !swing.held_first(out) {
            held_for_a_moment(view, out);
            swing.gains_energy(out);
        }
    } else if view.samples(Channel::Angle).is_none()
        && let Some(swing) = Swing::of(view, Channel::Rate)
    {
        held_for_a_moment(view, out);
        // Where the rate is largest, the body passes the middle with all its energy.
        swing.gains_energy(out);
    }
}

/// Says which rows of the beginning no fit uses, because the body was held.
fn held_for_a_moment(view: &View, out: &mut Vec<Finding>) {
    let Some(held) = held_start(&view.record) else {
        return;
    };
    out.push(
        Finding::warning(
            FindingId::HeldStart,
            format!(
                "the body stands still for {} s before it swings: it was held, and no fit uses the {} rows before its release",
                short(held.held_s),
                held.rows
            ),
        )
        .in_experiment(view.name())
        .with_fix(format!("from = {}", rounded_up(held.from_s))),
    );
}

impl<'v> Swing<'v> {
    /// `None` where no swing can be seen.
    fn of(view: &'v View<'v>, channel: Channel) -> Option<Swing<'v>> {
        let samples = view.samples(channel)?;
        let (low, high) = range(samples)?;
        let mut swing = Swing {
            view,
            channel,
            samples,
            noise: noise_std(samples),
            step: resolution(samples),
            half_range: 0.5 * (high - low),
            turns: vec![],
            // Late in the log, the swing is small, so the median is the rest position.
            middle: median(samples.to_vec())?,
            period_s: 0.0,
        };
        if swing.still() > TOO_WIDE * swing.half_range {
            return None;
        }
        swing.turns = swing.turning_points();
        let halves: Vec<f64> = swing
            .turns
            .windows(2)
            .map(|pair| pair[1].0 - pair[0].0)
            .collect();
        if halves.len() < 2 {
            return None;
        }
        swing.period_s = 2.0 * median(halves)?;
        Some(swing)
    }

    /// Half of the band within which a body counts as still.
    fn still(&self) -> f64 {
        (STILL * self.noise)
            .max(STILL_STEPS * self.step)
            .max(STILL_SHARE * self.half_range)
    }

    fn turning_points(&self) -> Vec<(f64, f64)> {
        let time_s = &self.view.experiment.log.time_s;
        let clear = self.still();
        let mut points: Vec<(f64, f64)> = vec![];
        let mut side = 0.0;
        for (t, x) in time_s.iter().zip(self.samples) {
            let off = x - self.middle;
            if off.abs() <= clear || !x.is_finite() {
                continue;
            }
            if off.signum() != side {
                side = off.signum();
                points.push((*t, off));
            } else if let Some(last) = points.last_mut()
                && off.abs() > last.1.abs()
            {
                *last = (*t, off);
            }
        }
        points
    }

    fn largest_s(&self) -> f64 {
        let largest = self.turns.iter();
        let largest = largest.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        largest.map_or(0.0, |point| point.0)
    }

    /// Whether the body is held before it swings, which is reported; a short hold that fits leave out is not reported here.
    fn held_first(&self, out: &mut Vec<Finding>) -> bool {
        let time_s = &self.view.experiment.log.time_s;
        let (still, half_range) = (self.still(), self.half_range);
        // The longest beginning during which the angle stays within a band.
        let mut bounds = (f64::INFINITY, f64::NEG_INFINITY);
        let held = self
            .samples
            .iter()
            .take_while(|x| {
                if x.is_finite() {
                    bounds = (bounds.0.min(**x), bounds.1.max(**x));
                }
                bounds.1 - bounds.0 <= 2.0 * still || bounds.0 > bounds.1
            })
            .count();
        let held_s = time_s[held.min(time_s.len() - 1)] - time_s[0];
        let held_at = (0.5 * (bounds.0 + bounds.1) - self.middle).abs();
        let near_turning_s = self.period_s / TAU * 2.0 * (1.0 - 2.0 * still / half_range).acos();
        if held == self.samples.len() || held_s <= near_turning_s + RELEASE * self.period_s {
            return false;
        }
        let is_long = held_s > LONG_HOLD * self.period_s;
        if !is_long && held_start(&self.view.record).is_some() {
            return false;
        }
        // A body held away from the hanging position is released; one held in the hanging position is lifted first.
        let from_s = if held_at > 0.5 * half_range {
            time_s[held.saturating_sub(1)]
        } else {
            self.largest_s()
        };
        let sentence = format!(
            "the body stands still for {} s before it swings: it was held, which is not part of the model",
            short(held_s)
        );
        let make = if is_long {
            Finding::refusal
        } else {
            Finding::warning
        };
        out.push(
            make(FindingId::HeldStart, sentence)
                .in_experiment(self.view.name())
                .with_channel(self.channel.key())
                .with_fix(format!("from = {}", rounded_up(from_s))),
        );
        true
    }

    /// Reports the first turning point that is farther out than an earlier one on the same side: without a torque, a
    /// pendulum loses energy only.
    fn gains_energy(&self, out: &mut Vec<Finding>) {
        // What happened in a pause is unknown: the swing after it may be another one.
        let mut notes = self.view.experiment.report.notes.iter();
        if notes.any(|note| matches!(note, Note::Gap { .. })) {
            return;
        }
        let visible = (GAIN_NOISE * self.noise).max(GAIN_STEPS * self.step);
        let least = |size: f64| {
            let share = (GAIN_SHARE * self.half_range).min(GAIN_OF_SWING * size.abs());
            visible.max(share) + self.hidden(size)
        };
        // The first stretch can begin in the middle of a swing, and so has no turning point.
        let grows = |index: usize, later: usize| -> bool {
            let (before, after) = (self.turns[index].1, self.turns[later].1);
            before * after > 0.0 && after.abs() > before.abs() + least(before)
        };
        let count = self.turns.len();
        // From one swing to the next, as a push does; else over several swings.
        let next = (1..count.saturating_sub(2)).map(|index| (index, index + 2));
        let any = (1..count).flat_map(|index| (index + 1..count).map(move |later| (index, later)));
        let gain = next
            .chain(any)
            .find(|(index, later)| grows(*index, *later))
            .map(|(index, later)| (index, &self.turns[index], &self.turns[later]));
        let Some((index, before, after)) = gain else {
            return;
        };
        // In the first swings, a hand sets the body going until its largest swing; later, it pushed once.
        let largest_s = self.largest_s();
        let fix = if largest_s > before.0 && index <= SETTING_GOING {
            format!("from = {}", rounded_up(largest_s))
        } else {
            format!(
                "until = {} keeps the swing before, from = {} the one after",
                rounded_down(before.0),
                rounded_up(after.0)
            )
        };
        out.push(
            Finding::warning(
                FindingId::Hand,
                format!(
                    "the swing grows at {} s without a current, from {} to {} of the {}: a hand, or something else \
                     that the model does not know, was on it",
                    short(after.0),
                    short(before.1.abs()),
                    short(after.1.abs()),
                    spoken(self.channel)
                ),
            )
            .in_experiment(self.view.name())
            .with_channel(self.channel.key())
            .with_fix(fix),
        );
    }

    /// What the time between two samples hides of a turning point at most: half an interval from it, a cosine is lower by
    /// half the square of that phase.
    fn hidden(&self, size: f64) -> f64 {
        let phase = (PI * self.view.step_s / self.period_s).min(1.0);
        0.5 * phase * phase * size.abs()
    }
}

/// A time rounded up to a few digits.
fn rounded_up(time_s: f64) -> f64 {
    (time_s * 1e3).ceil() / 1e3
}

/// As [`rounded_up`], down.
fn rounded_down(time_s: f64) -> f64 {
    (time_s * 1e3).floor() / 1e3
}
