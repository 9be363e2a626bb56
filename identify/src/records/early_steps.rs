//! Commands that changed between two samples of the log.
//!
//! A log of every n-th cycle of a controller, or of a host that sends commands when it likes, shows a new command with
//! the first sample after the change. The motion shows when it changed: a step of the command bends the wheel's speed,
//! and the lines before and after the bend meet at the instant of the change, also behind a lag. If these instants lie
//! before their samples, or scatter, by more than their standard errors allow, the log does not know when its commands
//! changed, and the fit treats each instant as an unknown within one interval ([`crate::Nuisance::EarlyStep`]). An unknown
//! of 2 ms makes a wheel of the thesis' bench, at a step of 1 A, faster by 0.5 rad/s from then on.
//!
//! Instants that all lie equally late are left to the effects that say so: delay and lag of the motor.

use nalgebra::{SMatrix, SVector};
use plant::Kind;

use super::jitter::step_s;
use super::noise::resolution;
use super::record::{Output, Record, RecordedCurrent};
use super::statistics::median;

/// A step of the command whose instant the log does not know.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownStep {
    /// Time in s of the first sample with the new command.
    pub sample_s: f64,
    /// New command minus old command, A.
    pub change_a: f64,
    /// Time from the sample before to this sample, s: the command changed within this interval.
    pub interval_s: f64,
    /// By how much the times of both samples may be off, s: the interval reaches so much further to both sides.
    pub margin_s: f64,
    /// Where the bend of the wheel's speed puts it: the share of that interval that lies after the instant; the middle where
    /// the bend does not show.
    pub guess: f64,
}

/// What the bends of a log say about the instants of its steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTimes {
    /// Mean time in s from the instant of a step to the sample that shows it; negative where the motion answers late.
    pub earlier_s: f64,
    /// Standard deviation of that time from step to step, s.
    pub scatter_s: f64,
    /// Number of steps that show their instant.
    pub steps: usize,
}

/// When one step came, as the bend of the wheel's speed shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instant {
    /// Index of that sample.
    sample: usize,
    /// Time in s after its sample.
    late_s: f64,
    /// Standard error, s.
    std_s: f64,
}

/// Numbers of samples to each side that a bend is computed from. The largest is taken over which the motion still is that of
/// [`Bend`]: the instant is then known best.
const SAMPLES: [usize; 4] = [16, 32, 64, 128];
/// The lag is found from this many samples to each side, or as many as there are.
const SAMPLES_OF_LAG: usize = 32;
/// Lags and delays of the wheel's speed that are tried, in intervals between samples. What lies between them, the bends
/// take as their own.
const LAGS: [f64; 9] = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 13.0];
const DELAYS: [f64; 9] = [0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0];
/// A lag or a delay is taken where it lowers χ² by this much: five standard deviations.
const PLAINLY_LATE: f64 = 25.0;
/// A longer stretch is refused if its samples scatter more than those of a shorter one, by so many standard errors of the
/// scatter: something else moves the wheel there.
const SCATTERS_MORE: f64 = 2.0;
/// Fewest samples to either side of a bend: seven terms take as many, and the rest must tell the noise.
const FEWEST_SAMPLES: usize = 8;
/// A step says something about its instant if its standard error is below this share of the interval; instants that are
/// spread evenly over it have 0.29.
const SHOWS: f64 = 0.5;
/// A stretch whose samples scatter about the bend by more than this multiple of the channel's noise has another
/// motion in it: teeth, a reversal of dry friction.
const CALM: f64 = 1.5;
/// Error of an instant that stays where the motion is not that of [`Bend`], as a share of the interval.
const MODEL_ERROR: f64 = 0.05;
/// Standard deviations of a clock's jitter that count as its largest error.
const JITTERS: f64 = 2.0;
/// What is plain, in standard deviations of a Gaussian: chance reaches it in one log of 300,000. A false alarm is not free:
/// instants that all lie at their samples look like ones half an interval earlier behind a lag of the motor.
const PLAIN: f64 = 4.5;
/// The unknown instants of a log are one parameter each, and each costs a twelfth of a simulation with derivatives. A
/// log with more steps keeps them as recorded.
const MOST_STEPS: usize = 48;

impl Record {
    /// Finds out whether the commands of this log changed between its samples.
    pub(super) fn find_early_steps(&mut self) {
        self.instants = self.instants_of_steps();
        self.step_times = step_times(&self.instants, step_s(&self.time_s));
        if self.step_times.is_some() {
            self.take_instants_as_unknown();
        }
    }

    fn instants_of_steps(&self) -> Vec<Instant> {
        if !self.follows_commands() {
            return vec![];
        }
        let kinks = self.kinks();
        let answer = self.answer_of_steps(&kinks);
        (0..kinks.len())
            .filter_map(|at| self.instant(&kinks, at, answer))
            .collect()
    }

    /// Whether recorded commands move the wheel, and no controller gives them.
    fn follows_commands(&self) -> bool {
        let is_commanded = matches!(self.current, RecordedCurrent::Known(_));
        let is_driven = matches!(self.kind, Kind::SpinUp | Kind::Driven);
        is_driven && is_commanded && !self.current_is_measured
    }

    fn take_instants_as_unknown(&mut self) {
        let kinks = self.kinks();
        if kinks.len() > MOST_STEPS || self.window_s.is_finite() {
            return;
        }
        let margin_s = self.time_error_s();
        let common_s = mean_s(&self.instants).max(0.0);
        let guess = |k: usize, span_s: f64| {
            let own = self.instants.iter().find(|instant| instant.sample == k);
            own.map_or(0.5, |own| (common_s - own.late_s + margin_s) / span_s)
                .clamp(0.1, 0.9)
        };
        self.unknown_steps = kinks
            .iter()
            .map(|&k| UnknownStep {
                sample_s: self.time_s[k],
                change_a: self.current_a[k] - self.current_a[k - 1],
                interval_s: self.time_s[k] - self.time_s[k - 1],
                margin_s,
                guess: guess(k, self.time_s[k] - self.time_s[k - 1] + 2.0 * margin_s),
            })
            .collect();
    }

    /// By how much a time of this log may be off, s: half of its last digit, and the jitter of its clock.
    fn time_error_s(&self) -> f64 {
        let intervals = self.time_s.windows(2).map(|pair| pair[1] - pair[0]);
        let usual_s = median(intervals.clone()).unwrap_or(0.0);
        // What intervals have in common is no digit.
        let differences: Vec<f64> = intervals.map(|interval_s| interval_s - usual_s).collect();
        let digit_s = resolution(&differences).min(step_s(&self.time_s));
        0.5 * digit_s + JITTERS * self.clock_jitter_s.unwrap_or(0.0)
    }

    /// The instant of the step at `kinks[at]`, for this answer of the wheel's speed; `None` where the wheel's speed does not show it.
    fn instant(&self, kinks: &[usize], at: usize, answer: Answer) -> Option<Instant> {
        let noise = self.channel(Output::WheelSpeed)?.noise_std;
        let mut best: Option<Bend> = None;
        let mut disagreement_s = 0.0f64;
        let mut used = 0;
        for most in SAMPLES {
            let points = self.around(kinks, at, most);
            if points.len() == used {
                break;
            }
            used = points.len();
            let Some(bend) = Bend::through(&points, answer) else {
                continue;
            };
            let least = best.as_ref().map_or(CALM * noise, |best| {
                best.scatter * (1.0 + SCATTERS_MORE / (2.0 * used as f64).sqrt())
            });
            if bend.scatter > least.min(CALM * noise) {
                break;
            }
            // What a longer stretch says differently may be its own error.
            disagreement_s = best.map_or(0.0, |best| (bend.earlier_s - best.earlier_s).abs());
            best = Some(bend);
        }
        let bend = best?;
        let k = kinks[at];
        let interval_s = self.time_s[k] - self.time_s[k - 1];
        let std_s = (bend.std_s * (noise / bend.scatter).max(1.0)).max(disagreement_s);
        (std_s < SHOWS * interval_s).then_some(Instant {
            sample: k,
            // Delay and lag look alike where they are short, and only all together are known well.
            late_s: answer.delay_s + answer.lag_s - bend.earlier_s,
            std_s: std_s.hypot(MODEL_ERROR * interval_s),
        })
    }

    /// Time in s relative to the step at `kinks[at]` and wheel speed of at most `most` samples to each side of it, which
    /// contain no other step.
    fn around(&self, kinks: &[usize], at: usize, most: usize) -> Vec<(f64, f64)> {
        let Some(channel) = self.channel(Output::WheelSpeed) else {
            return vec![];
        };
        let k = kinks[at];
        let first = at.checked_sub(1).map_or(0, |before| kinks[before]);
        let last = kinks.get(at + 1).copied().unwrap_or(self.len());
        (k.saturating_sub(most).max(first)..(k + most).min(last))
            .map(|sample| {
                (
                    self.time_s[sample] - self.time_s[k],
                    channel.samples[sample],
                )
            })
            .filter(|(_, value)| value.is_finite())
            .collect()
    }

    /// How late the wheel's speed shows all steps of the log.
    fn answer_of_steps(&self, kinks: &[usize]) -> Answer {
        let Some(channel) = self.channel(Output::WheelSpeed) else {
            return Answer::AT_ONCE;
        };
        let interval_s = step_s(&self.time_s);
        let around: Vec<_> = (0..kinks.len())
            .map(|at| self.around(kinks, at, SAMPLES_OF_LAG))
            .collect();
        let misfit = |answer: Answer| -> f64 {
            let bends = around
                .iter()
                .filter_map(|points| Bend::through(points, answer));
            bends.map(|bend| bend.squares).sum::<f64>() / channel.noise_std.powi(2)
        };
        let mut best = (misfit(Answer::AT_ONCE) - PLAINLY_LATE, Answer::AT_ONCE);
        for delay in DELAYS {
            for lag in LAGS {
                let answer = Answer {
                    delay_s: delay * interval_s,
                    lag_s: lag * interval_s,
                };
                let misfit = misfit(answer);
                if misfit < best.0 {
                    best = (misfit, answer);
                }
            }
        }
        best.1
    }
}

/// How late the wheel's speed shows the steps of a log, which is common to all of them: motor or sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    delay_s: f64,
    lag_s: f64,
}

impl Answer {
    const AT_ONCE: Answer = Answer {
        delay_s: 0.0,
        lag_s: 0.0,
    };
}

/// Where the logs of a bench say together that commands changed between samples, takes the instants of all their steps
/// as unknown: one logger wrote them. A log in which something else than the interval moves the instants says nothing.
pub(crate) fn join_early_steps(records: &mut [Record]) {
    let shown = records
        .iter()
        .filter(|record| lie_in_an_interval(&record.instants, step_s(&record.time_s)));
    let n: usize = shown.clone().map(|record| record.instants.len()).sum();
    let square: f64 = shown.map(|record| about_common(&record.instants)).sum();
    if n == 0 || !plainly_above(square, n as f64) {
        return;
    }
    for record in records {
        if record.follows_commands() && record.unknown_steps.is_empty() {
            record.take_instants_as_unknown();
        }
    }
}

/// The weighted mean of the instants, s.
fn mean_s(found: &[Instant]) -> f64 {
    let weight: f64 = found.iter().map(|one| one.std_s.powi(-2)).sum();
    let sum: f64 = found
        .iter()
        .map(|one| one.late_s * one.std_s.powi(-2))
        .sum();
    sum / weight
}

/// χ² of the instants about what a delay or a lag of the motor explains: all late alike.
fn about_common(found: &[Instant]) -> f64 {
    let common_s = mean_s(found).max(0.0);
    let squares = found
        .iter()
        .map(|one| ((one.late_s - common_s) / one.std_s).powi(2));
    squares.sum()
}

/// Standard deviation of the instants, s.
fn scatter_s(found: &[Instant]) -> f64 {
    let mean_s = mean_s(found);
    let squares = found.iter().map(|one| (one.late_s - mean_s).powi(2));
    (squares.sum::<f64>() / found.len() as f64).sqrt()
}

/// Whether the instants scatter by less than an interval, and do not lie far before their samples; else it is not the
/// interval that hides them.
fn lie_in_an_interval(found: &[Instant], interval_s: f64) -> bool {
    scatter_s(found) < interval_s && mean_s(found) > -1.5 * interval_s
}

/// What the instants of a log say, where they plainly lie before their samples or scatter.
fn step_times(found: &[Instant], interval_s: f64) -> Option<StepTimes> {
    let is_plain = lie_in_an_interval(found, interval_s)
        && plainly_above(about_common(found), found.len() as f64);
    is_plain.then(|| StepTimes {
        earlier_s: -mean_s(found),
        scatter_s: scatter_s(found),
        steps: found.len(),
    })
}

/// Whether a sum of squares of `n` standard normal values is larger than chance makes it, by [`PLAIN`] standard deviations:
/// the cube root of χ²/n is nearly Gaussian, with mean 1 − 2/(9n) and variance 2/(9n) (Wilson & Hilferty 1931).
fn plainly_above(square: f64, n: f64) -> bool {
    let variance = 2.0 / (9.0 * n);
    ((square / n).cbrt() - (1.0 - variance)) / variance.sqrt() > PLAIN
}

/// The wheel's speed about a step of the command at time 0 that came earlier by e, behind a delay d and a lag T: a cubic,
/// whose slope changes by b and whose curvature changes too. With t counted from d and s(t) = t − T (1 − exp(−t/T)) after
/// that and 0 before it, the speed has the terms b s(t) and, to first order, b e s′(t).
struct Bend {
    /// e, s.
    earlier_s: f64,
    /// Its standard error for the scatter of these samples, s.
    std_s: f64,
    /// Standard deviation of the samples about the bend.
    scatter: f64,
    /// Sum of their squares.
    squares: f64,
}

impl Bend {
    /// Terms: a cubic, the changes of curvature and of slope, the shift.
    const TERMS: usize = 7;

    /// Least squares over samples, as (time in s, speed). `None` with too few to either side.
    fn through(points: &[(f64, f64)], answer: Answer) -> Option<Bend> {
        let before = points
            .iter()
            .filter(|(time_s, _)| *time_s < answer.delay_s)
            .count();
        if before.min(points.len() - before) < FEWEST_SAMPLES {
            return None;
        }
        // In units of the stretch, so that the powers are comparable.
        let unit_s = points
            .iter()
            .map(|(time, _)| time.abs())
            .fold(0.0, f64::max);
        let row = |time_s: f64| {
            let t = time_s / unit_s;
            let since = t - answer.delay_s / unit_s;
            let lag = answer.lag_s / unit_s;
            let (mut shift, mut slope) = (0.0, 0.0);
            // Half of a rounding error is no time.
            if since > -1e-9 {
                let left = if lag > 0.0 { (-since / lag).exp() } else { 0.0 };
                shift = 1.0 - left;
                slope = since - lag * shift;
            }
            SVector::from([1.0, t, t * t, t * t * t, slope * slope, slope, shift])
        };
        let mut matrix = SMatrix::<f64, { Bend::TERMS }, { Bend::TERMS }>::zeros();
        let mut right = SVector::<f64, { Bend::TERMS }>::zeros();
        for &(time_s, value) in points {
            let row = row(time_s);
            matrix += row * row.transpose();
            right += row * value;
        }
        let inverse = matrix.try_inverse()?;
        let found = inverse * right;
        let squares: f64 = points
            .iter()
            .map(|&(time_s, value)| (value - row(time_s).dot(&found)).powi(2))
            .sum();
        let scatter = (squares / (points.len() - Bend::TERMS) as f64).sqrt();
        let (slope, shift) = (found[5], found[6]);
        let earlier = shift / slope;
        let variance =
            inverse[(6, 6)] - 2.0 * earlier * inverse[(5, 6)] + earlier * earlier * inverse[(5, 5)];
        Some(Bend {
            earlier_s: earlier * unit_s,
            std_s: scatter * variance.max(0.0).sqrt() / slope.abs() * unit_s,
            scatter,
            squares,
        })
    }
}
