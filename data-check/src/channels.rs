//! Checks of each channel alone (limits, standstills, jumps, levels, repeated samples), and of the time stamps.

use bench_files::{Channel, Note};
use identify::{noise_std, resolution};

use crate::finding::{Finding, FindingId};
use crate::sawtooth;
use crate::slips::short;
use crate::thresholds::channels::{
    AT_LIMIT, BEYOND_NOISE, BEYOND_STEPS, CLIPPED_SHARE, DOUBTFUL_SHARE, DOUBTFUL_TURN, FEW_LEVELS,
    FEWEST_LARGE, FROZEN, FROZEN_SHARE, JITTER, LARGE_STEP, LEAST_NOISE, NOISY_STEPS, OFF_REST,
    REPEATED, REPEATED_TIMES, STUCK,
};
use crate::view::{View, largest, median, range, spoken};

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    time_stamps(view, out);
    wheel_angle(view, out);
    for channel in [Channel::Angle, Channel::Rate, Channel::WheelSpeed] {
        let Some(samples) = view.samples(channel) else {
            continue;
        };
        let series = Series::new(samples);
        for finding in [
            series.clipped(channel),
            series.frozen(channel),
            sawtooth::check(channel, samples),
            series.quantised(channel),
            series.stale(channel),
        ]
        .into_iter()
        .flatten()
        {
            out.push(
                finding
                    .in_experiment(view.name())
                    .with_channel(channel.key()),
            );
        }
    }
}

const CUT_OUT: &str = "exclude that part with from and until, or check the bus of the sensor";

struct Series<'s> {
    samples: &'s [f64],
    noise: f64,
    step: f64,
    low: f64,
    high: f64,
}

/// A run of equal samples, `from..until`.
struct Run {
    from: usize,
    until: usize,
}

impl Run {
    fn span(&self) -> usize {
        ((self.until - self.from) / 2).clamp(3, 20)
    }
}

impl<'s> Series<'s> {
    fn new(samples: &'s [f64]) -> Series<'s> {
        let (low, high) = range(samples).unwrap_or((0.0, 0.0));
        Series {
            samples,
            noise: noise_std(samples),
            step: resolution(samples),
            low,
            high,
        }
    }

    fn runs(&self, fewest: usize) -> Vec<Run> {
        let mut runs = vec![];
        let mut from = 0;
        for k in 1..=self.samples.len() {
            if k < self.samples.len() && self.samples[k] == self.samples[from] {
                continue;
            }
            if k - from >= fewest {
                runs.push(Run { from, until: k });
            }
            from = k;
        }
        runs
    }

    /// Mean change per sample before a run (here) and after sample `k` (below). The span is half of the
    /// run: long enough to average the noise, and short against the motion.
    fn slope_before(&self, run: &Run) -> Option<f64> {
        let span = run.span();
        let first = run.from.checked_sub(span)?;
        Some((self.samples[run.from] - self.samples[first]) / span as f64)
    }

    fn slope_after(&self, k: usize, run: &Run) -> Option<f64> {
        let span = run.span();
        Some((self.samples.get(k + span)? - self.samples[k]) / span as f64)
    }

    fn visible(&self, size: f64) -> bool {
        size > BEYOND_NOISE * self.noise && size > BEYOND_STEPS * self.step
    }

    fn clipped(&self, channel: Channel) -> Option<Finding> {
        // A channel of few levels stands at each of them.
        if self.high - self.low < FEW_LEVELS * self.step {
            return None;
        }
        let mut at_limit = 0;
        for run in self.runs(AT_LIMIT) {
            let value = self.samples[run.from];
            let up = if value == self.high {
                1.0
            } else if value == self.low {
                -1.0
            } else {
                continue;
            };
            let (Some(before), Some(after)) = (
                self.slope_before(&run),
                self.slope_after(run.until - 1, &run),
            ) else {
                continue;
            };
            let (before, after) = (up * before, -up * after);
            // A parabola with these slopes at its ends rises by an eighth of the slopes' sum times its length.
            let beyond = 0.125 * (before + after) * (run.until - run.from) as f64;
            if before > 0.0 && after > 0.0 && self.visible(beyond) {
                at_limit += run.until - run.from;
            }
        }
        let last = self.stuck_at_the_end(channel);
        if at_limit + last == 0 {
            return None;
        }
        let share = (at_limit + last) as f64 / self.samples.len() as f64;
        let how = if at_limit > 0 {
            "but the motion goes beyond it"
        } else {
            "to the end of the log and without the noise that they had before"
        };
        let sentence = format!(
            "{} samples of the {} stand at its limit ({} to {}), {how}",
            at_limit + last,
            spoken(channel),
            short(self.low),
            short(self.high)
        );
        let finding = if share > CLIPPED_SHARE {
            Finding::refusal(FindingId::Clipped, sentence)
        } else {
            Finding::warning(FindingId::Clipped, sentence)
        };
        Some(
            finding.with_fix(
                "exclude that part with from and until, or use a larger range of the sensor",
            ),
        )
    }

    /// The equal samples at the end of a log of the wheel's speed that stopped rising at the limit of its sensor. A wheel
    /// that turns steadily shows the noise that it showed before; one at rest may show none, but is not at the limit.
    fn stuck_at_the_end(&self, channel: Channel) -> usize {
        let largest = self.low.abs().max(self.high.abs());
        let stuck = self
            .runs(STUCK)
            .pop()
            .filter(|run| run.until == self.samples.len())
            .filter(|run| {
                let value = self.samples[run.from];
                let before = &self.samples[..run.from];
                let rises = self
                    .slope_before(run)
                    .is_some_and(|slope| slope * value > 0.0);
                value.abs() == largest
                    && range(before).is_some_and(|(low, high)| low < high)
                    && rises
                    && noise_std(before) > NOISY_STEPS * resolution(before)
            });
        match stuck {
            Some(run) if channel == Channel::WheelSpeed => run.until - run.from,
            _ => 0,
        }
    }

    fn frozen(&self, channel: Channel) -> Option<Finding> {
        self.frozen_in_motion(channel)
            .or_else(|| self.frozen_without_noise(channel))
    }

    /// A stop in the middle of a channel's own noise: two steps of noise repeat a sample once in five times, so that
    /// [`STUCK`] samples in a row are chance in 10⁷ lines once in a million logs. A body or a wheel that stands still may
    /// show no noise, but it does not jump when it moves again, and it does not stand far from its usual place to the end.
    fn frozen_without_noise(&self, channel: Channel) -> Option<Finding> {
        let is_frozen = |run: &Run| {
            let value = self.samples[run.from];
            let (before, after) = (&self.samples[..run.from], &self.samples[run.until..]);
            let elsewhere = if before.len() > after.len() {
                before
            } else {
                after
            };
            let (Some((low, high)), Some(middle)) = (range(elsewhere), median(elsewhere.to_vec()))
            else {
                return false;
            };
            let (noise, step) = (noise_std(elsewhere), resolution(elsewhere));
            if elsewhere.len() < STUCK
                || noise <= (LEAST_NOISE * (high - low)).max(NOISY_STEPS * step)
            {
                return false;
            }
            let jumps = |beside: Option<&f64>| {
                beside.is_some_and(|beside| (beside - value).abs() > BEYOND_NOISE * noise)
            };
            // What is held at the beginning is told by the swing.
            if before.is_empty() || low == high {
                return false;
            }
            if after.is_empty() {
                return value != 0.0 && (value - middle).abs() > OFF_REST * 0.5 * (high - low);
            }
            // A wheel rests, and a motor can start it within one sample.
            let is_wheel = channel == Channel::WheelSpeed;
            if is_wheel && value.abs() < OFF_REST * 0.5 * (high - low) {
                return false;
            }
            // A sensor without power says 0; a body at rest has a rate of 0, and comes to it without a jump.
            let is_rest = value == 0.0 || is_wheel;
            jumps(after.first()) && (jumps(before.last()) || !is_rest)
        };
        let runs = self.runs(STUCK).into_iter();
        let is_at_limit = |run: &Run| [self.low, self.high].contains(&self.samples[run.from]);
        let frozen = runs.filter(|run| !is_at_limit(run) && is_frozen(run));
        let count: usize = frozen.map(|run| run.until - run.from).sum();
        if count == 0 {
            return None;
        }
        let make = if count as f64 > FROZEN_SHARE * self.samples.len() as f64 {
            Finding::refusal
        } else {
            Finding::warning
        };
        let sentence = format!(
            "the {} stands still for {count} samples without the noise that it has elsewhere",
            spoken(channel)
        );
        Some(make(FindingId::Frozen, sentence).with_fix(CUT_OUT))
    }

    fn frozen_in_motion(&self, channel: Channel) -> Option<Finding> {
        let run = self.runs(FROZEN).into_iter().find(|run| {
            let (Some(before), Some(after)) =
                (self.slope_before(run), self.slope_after(run.until, run))
            else {
                return false;
            };
            let length = (run.until - run.from) as f64;
            let missed = 0.5 * (before + after) * length;
            let jump = match self.samples.get(run.until) {
                Some(next) => next - self.samples[run.from],
                None => return false,
            };
            // The motion continued in the same direction, and the sensor then caught up in one step.
            before * after > 0.0
                && jump * missed > 0.0
                && jump.abs() > 0.5 * missed.abs()
                && self.visible(missed.abs())
                && before.abs().min(after.abs()) > 0.3 * before.abs().max(after.abs())
        })?;
        let sentence = format!(
            "the {} stands still for {} samples while the motion goes on, and then jumps",
            spoken(channel),
            run.until - run.from
        );
        Some(Finding::warning(FindingId::Frozen, sentence).with_fix(CUT_OUT))
    }

    fn quantised(&self, channel: Channel) -> Option<Finding> {
        let levels = (self.high - self.low) / self.step;
        if self.high <= self.low || levels >= FEW_LEVELS {
            return None;
        }
        Some(
            Finding::warning(
                FindingId::Quantised,
                format!(
                    "the {} has only {} levels, in steps of {}",
                    spoken(channel),
                    short(levels.round() + 1.0),
                    short(self.step)
                ),
            )
            .with_fix("log more digits"),
        )
    }

    fn stale(&self, channel: Channel) -> Option<Finding> {
        let steps: Vec<f64> = self
            .samples
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .collect();
        if self.high <= self.low {
            return None;
        }
        // With steps of many counts, equal neighbours come neither from rounding nor from rest.
        let is_large = |k: usize| {
            steps
                .get(k)
                .is_some_and(|step| *step >= LARGE_STEP * self.step)
        };
        let moved = (0..steps.len()).filter(|k| is_large(*k)).count();
        // At a limit the sensor repeats what it cannot exceed.
        let at_limit = |k: usize| [self.low, self.high].contains(&self.samples[k]);
        let repeats = (0..steps.len())
            .filter(|&k| {
                let beside = is_large(k + 1) || k > 0 && is_large(k - 1);
                steps[k] == 0.0 && beside && !at_limit(k)
            })
            .count();
        let repeated = repeats as f64 / (repeats + moved).max(1) as f64;
        if moved < FEWEST_LARGE || repeated < REPEATED {
            return None;
        }
        let every = 1.0 / (1.0 - repeated);
        Some(
            Finding::warning(
                FindingId::Stale,
                format!(
                    "the {} repeats its samples: it has a new value in every {} lines at most",
                    spoken(channel),
                    short(every)
                ),
            )
            .with_factor(every)
            .with_fix("log at the rate of the sensor: repeated samples come late"),
        )
    }
}

/// The longest step that the reader leaves in the reading of a sensor with a range of one turn, as a share of a turn, with
/// a hundredth for rounding.
const HALF_A_TURN: f64 = 0.51;

fn wheel_angle(view: &View, out: &mut Vec<Finding>) {
    let Some(angle) = view.samples(Channel::WheelAngle) else {
        return;
    };
    let steps: Vec<f64> = angle.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let most = largest(&steps) / std::f64::consts::TAU;
    let doubtful = steps
        .iter()
        .filter(|step| step.abs() > DOUBTFUL_TURN * std::f64::consts::TAU)
        .count();
    let mut say = |finding: Finding| {
        out.push(
            finding
                .in_experiment(view.name())
                .with_channel("wheel_angle"),
        );
    };
    // Of a sensor with a range of one turn, the reader takes the shorter way. A longer step comes from a column that
    // counts turns, whose direction is certain, if its unit is.
    let mut unstated = view.experiment.report.unstated.iter();
    let is_stated = !unstated.any(|one| one.channel == Channel::WheelAngle);
    let counts_turns = most > HALF_A_TURN && is_stated;
    if let Some(finding) = sawtooth::check(Channel::WheelAngle, angle) {
        say(finding);
    } else if doubtful > 0 && !counts_turns {
        let sentence = format!(
            "the wheel turns by {} of a turn from sample to sample, so its direction is uncertain",
            short(most)
        );
        let make = if doubtful as f64 > DOUBTFUL_SHARE * steps.len() as f64 {
            Finding::refusal
        } else {
            Finding::warning
        };
        say(make(FindingId::Wrapped, sentence).with_fix("log faster, or log the wheel's speed"));
    }
}

fn time_stamps(view: &View, out: &mut Vec<Finding>) {
    let mut say = |sentence: String, fix: &str| {
        out.push(
            Finding::warning(FindingId::TimeStamps, sentence)
                .in_experiment(view.name())
                .with_channel("time")
                .with_fix(fix),
        );
    };
    let rows = view.experiment.report.rows_in_file;
    let mut gaps = 0;
    for note in &view.experiment.report.notes {
        match note {
            Note::MergedRows { count } if *count as f64 > REPEATED_TIMES * rows as f64 => say(
                format!("{count} of {rows} lines repeat the time of the line before"),
                "log the time with more digits",
            ),
            Note::Gap { .. } => gaps += 1,
            _ => {}
        }
    }
    if gaps > 0 {
        let gaps = if gaps == 1 {
            "a gap".to_owned()
        } else {
            format!("{gaps} gaps")
        };
        say(
            format!(
                "the times have {gaps} of more than twenty usual intervals: the motion there is unknown, or the clock jumped"
            ),
            "keep one side of the gap with from and until",
        );
    }
    if view.counts_lines() {
        say(
            "the times are consecutive whole numbers: does the column count the lines?".to_owned(),
            "time_step = … (seconds from line to line) in the place of the time's column, if it does",
        );
    }
    if let Some(jitter_s) = view.record.clock_jitter_s {
        say(
            format!(
                "the noise grows with the slope of the signals, as if the clock jittered: the samples are then off by {} ms at random (one standard deviation)",
                short(1e3 * jitter_s)
            ),
            "log the time at which the sample was taken, and take the samples in a timer's interrupt; the fit goes on with the noise as it is",
        );
    }
    if let Some(times) = view.record.step_times {
        say(
            format!(
                "the command changed between the rows: {} ms before the row that shows it on average over {} steps, with a scatter of {} ms",
                short(1e3 * times.earlier_s),
                times.steps,
                short(1e3 * times.scatter_s)
            ),
            "write a row in every cycle in which the command changes; the fit goes on with each instant as an unknown",
        );
    }
    let mut steps: Vec<f64> = view
        .experiment
        .log
        .time_s
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .collect();
    if steps.len() < 40 {
        return;
    }
    steps.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| steps[((steps.len() - 1) as f64 * share) as usize];
    if at(0.95) - at(0.05) > JITTER * at(0.5) {
        say(
            format!(
                "the time from line to line varies between {} and {} s",
                short(at(0.05)),
                short(at(0.95))
            ),
            "log the time at which the sample was taken, not written; or use time_step if the samples are evenly spaced",
        );
    }
}
