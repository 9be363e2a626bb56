//! A log as the fit uses it: its channels with their noise, its current, and the length of the windows in which it is
//! simulated.

use std::sync::OnceLock;

use bench_files::{CurrentMeaning, Experiment, Note};
pub use plant::Output;
use plant::{Hold, Input, Kind};

use super::averages::{blocks, means, middles};
use super::noise::{
    least_noise_std, noise_by_differences, resolution, steps_of_command, without_floor,
};

/// One measured channel.
#[derive(Clone, Debug)]
pub struct RecordedChannel {
    /// Which output of the model it measures.
    pub output: Output,
    /// The samples in SI units; NaN where a sample is missing.
    pub samples: Vec<f64>,
    /// Standard deviation of the sensor's noise, in the unit of the output.
    pub noise_std: f64,
    /// The quantisation step in the unit of the output, if rounding makes up most of the noise; otherwise `None`.
    pub quantum: Option<f64>,
}

impl RecordedChannel {
    /// A channel with this noise; `noise_std` is raised to the noise of the channel's own rounding if it is below.
    fn new(output: Output, samples: Vec<f64>, noise_std: f64) -> RecordedChannel {
        let mut channel = RecordedChannel {
            output,
            samples,
            noise_std,
            quantum: None,
        };
        channel.set_noise(noise_std);
        channel
    }

    /// Replaces the standard deviation of the noise.
    pub(crate) fn set_noise(&mut self, noise_std: f64) {
        let step = resolution(&self.samples);
        let rounding_std = step / 12f64.sqrt();
        let finite = self.samples.iter().copied().filter(|one| one.is_finite());
        let finite: Vec<f64> = finite.collect();
        self.noise_std = noise_std.max(least_noise_std(&finite));
        let is_quantised = rounding_std >= QUANTISED_SHARE * self.noise_std;
        self.quantum = is_quantised.then_some(step);
    }
}

/// The samples at which the motion has a kink because the current steps. Empty for a balance log: there the current
/// changes with every sample.
fn kinks(kind: Kind, current_a: &[f64]) -> Vec<usize> {
    match kind {
        Kind::SpinUp | Kind::Driven => steps_of_command(current_a),
        Kind::FreeSwing | Kind::Balance => vec![],
    }
}

/// Length of the windows of a balance log in s, and of any other log whose free run diverges.
pub const BALANCE_WINDOW_S: f64 = 0.25;

/// Time in s over which the rate is averaged before the body's travel is integrated from it. A balanced body moves over
/// tenths of a second; the noise of single samples would add to the length of its path.
const TRAVEL_AVERAGE_S: f64 = 0.02;

/// A channel counts as quantised if rounding (q/√12) makes up at least this share of its noise.
const QUANTISED_SHARE: f64 = 0.5;

/// The current of a log.
#[derive(Clone, Debug)]
pub enum RecordedCurrent {
    /// Recorded: the command, or the measured current.
    Known(Input),
    /// Constant, at a value that nobody recorded.
    Unknown,
}

/// What the samples say about the time before a window. It is computed once; a clone of a record computes its own,
/// because its samples may be changed.
#[derive(Debug, Default)]
struct Past {
    wheel_angle_rad: OnceLock<Vec<f64>>,
    /// The cache of [`Record::body_travel_before`], over the whole log.
    travel_rad: OnceLock<Travel>,
}

impl Clone for Past {
    fn clone(&self) -> Past {
        Past::default()
    }
}

/// The movement of the body from each sample to the next, as measured.
#[derive(Debug)]
struct Travel {
    /// From the rate if there is one, otherwise from the angle, rad.
    step_rad: Vec<f64>,
    /// Accumulated disagreement between angle and rate up to each sample, rad; empty unless both are measured.
    disagreement_rad: Vec<f64>,
}

/// The teeth of a motor, as logs show them without a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ToothStart {
    /// Number of teeth in one turn.
    pub(crate) order: f64,
    /// Torque over the wheel's inertia, rad/s².
    pub(crate) per_inertia: f64,
    /// Phase where the corrected wheel angle is zero, rad.
    pub(crate) phase_rad: f64,
    /// Gain in χ² that they promise.
    pub(crate) gain: f64,
}

/// One experiment, ready for simulation and fit.
#[derive(Clone, Debug)]
pub struct Record {
    /// The experiment's name in bench.toml.
    pub name: String,
    /// Its kind.
    pub kind: Kind,
    /// Sample times in s, increasing.
    pub time_s: Vec<f64>,
    /// The measured channels that this kind of experiment uses, at least one.
    pub channels: Vec<RecordedChannel>,
    /// The motor current.
    pub current: RecordedCurrent,
    /// The samples of the current in A, as recorded; empty if it was not recorded.
    pub current_a: Vec<f64>,
    /// Whether the current was measured; otherwise it is the command.
    pub current_is_measured: bool,
    /// Weight of each sample in the fit: 1, or 0 to leave it out (an unrecorded push acted).
    pub weight: Vec<f64>,
    /// Longest stretch in s that is simulated in one piece, with its own start: the whole log (infinite), or
    /// [`BALANCE_WINDOW_S`] if the free run diverges.
    pub window_s: f64,
    /// Whether the measured angle leaves ±π.
    pub passes_over_the_top: bool,
    /// Standard deviation in s by which the times of the samples are off at random, if that makes a part of their noise.
    pub clock_jitter_s: Option<f64>,
    /// How many samples of the recorded log each sample here is the average of; 1 for a log as recorded.
    pub averaged_over: usize,
    /// The wheel angles of [`Record::wheel_angles`], if they were measured, or if more samples were available than this
    /// record has.
    turned_rad: Option<Vec<f64>>,
    /// The noise of the measured wheel angle, rad; `None` if it was not measured.
    turned_noise_rad: Option<f64>,
    /// The teeth by which the wheel's angle was corrected; `None` if it was not.
    pub(crate) teeth: Option<ToothStart>,
    past: Past,
}

/// The mean of the finite samples; NaN if there is none.
fn mean(samples: &[f64]) -> f64 {
    let finite = samples.iter().filter(|sample| sample.is_finite());
    finite.clone().sum::<f64>() / finite.count() as f64
}

impl Record {
    /// Prepares a record from samples in SI units. `angle`, `rate` and `wheel_speed` may be missing; those that this kind
    /// of experiment holds still are ignored. Where the clock jitters, the noise contains what that makes of the motion.
    pub fn new(
        name: &str,
        kind: Kind,
        time_s: Vec<f64>,
        outputs: [Option<Vec<f64>>; 3],
        current_a: Option<Vec<f64>>,
        current_is_measured: bool,
    ) -> Record {
        let mut record =
            Record::of_samples(name, kind, time_s, outputs, current_a, current_is_measured);
        record.find_jitter();
        record
    }

    /// As [`Record::new`], for samples of a clock that is known or not asked about.
    fn of_samples(
        name: &str,
        kind: Kind,
        time_s: Vec<f64>,
        outputs: [Option<Vec<f64>>; 3],
        current_a: Option<Vec<f64>>,
        current_is_measured: bool,
    ) -> Record {
        let kinks = kinks(kind, current_a.as_deref().unwrap_or(&[]));
        let channels: Vec<RecordedChannel> = Output::ALL
            .into_iter()
            .zip(outputs)
            .filter(|(output, _)| match kind {
                Kind::FreeSwing => *output != Output::WheelSpeed,
                Kind::SpinUp => *output == Output::WheelSpeed,
                Kind::Balance | Kind::Driven => true,
            })
            .filter_map(|(output, samples)| {
                let samples = samples?;
                let noise_std = noise_by_differences(&samples, &kinks).std;
                Some(RecordedChannel::new(output, samples, noise_std))
            })
            .collect();
        let passes_over_the_top = channels.iter().any(|channel: &RecordedChannel| {
            let beyond = |angle: &f64| angle.abs() > std::f64::consts::PI;
            channel.output == Output::Angle && channel.samples.iter().any(beyond)
        });
        let hold = if current_is_measured {
            Hold::Linear
        } else {
            Hold::Zero
        };
        let current = match (&current_a, kind) {
            (_, Kind::FreeSwing) => {
                RecordedCurrent::Known(Input::new(&time_s, &vec![0.0; time_s.len()], hold))
            }
            (Some(current_a), _) => RecordedCurrent::Known(Input::new(&time_s, current_a, hold)),
            (None, _) => RecordedCurrent::Unknown,
        };
        Record {
            name: name.to_owned(),
            kind,
            weight: vec![1.0; time_s.len()],
            time_s,
            channels,
            current,
            current_a: current_a.unwrap_or_default(),
            current_is_measured,
            window_s: match kind {
                Kind::Balance => BALANCE_WINDOW_S,
                // While the body passes over the top, the smallest difference grows, as it does near the upright position.
                Kind::Driven if passes_over_the_top => BALANCE_WINDOW_S,
                Kind::FreeSwing | Kind::SpinUp | Kind::Driven => f64::INFINITY,
            },
            passes_over_the_top,
            clock_jitter_s: None,
            averaged_over: 1,
            turned_rad: None,
            turned_noise_rad: None,
            teeth: None,
            past: Past::default(),
        }
    }

    /// Prepares an experiment that was loaded from disk.
    pub fn from_experiment(experiment: &Experiment) -> Record {
        let log = &experiment.log;
        let mut record = Record::new(
            &experiment.name,
            experiment.kind,
            log.time_s.clone(),
            [
                log.angle_rad.clone(),
                log.rate_rad_s.clone(),
                log.wheel_speed_rad_s.clone(),
            ],
            log.current_a.clone(),
            experiment.current_meaning == CurrentMeaning::Measured,
        );
        if let Some(angle_rad) = &log.wheel_angle_rad {
            record.set_wheel_angles(angle_rad);
        }
        if experiment.report.notes.contains(&Note::SpeedFromAngle) {
            record.speed_is_of_angle();
        }
        record
    }

    /// Gives a wheel speed that was computed from the wheel's angle the noise that this makes of the angle's: a difference
    /// of two samples over the time between them. Such noise is correlated, and looks smaller in differences of the speed.
    fn speed_is_of_angle(&mut self) {
        let (Some(noise_rad), [first, .., last]) = (self.turned_noise_rad, &self.time_s[..]) else {
            return;
        };
        let step_s = (last - first) / (self.time_s.len() - 1) as f64;
        let speed = self
            .channels
            .iter_mut()
            .find(|channel| channel.output == Output::WheelSpeed);
        if let Some(speed) = speed {
            speed.set_noise(
                speed
                    .noise_std
                    .max(noise_rad * 2f64.sqrt() / (2.0 * step_s)),
            );
        }
    }

    /// States the wheel's angle in rad as measured at every sample, unwrapped. Missing samples lie on the straight line
    /// between their neighbours. Nothing changes where none was measured.
    pub fn set_wheel_angles(&mut self, measured_rad: &[f64]) {
        let at: Vec<usize> = (0..measured_rad.len())
            .filter(|&k| measured_rad[k].is_finite())
            .collect();
        if at.len() < 2 || measured_rad.len() != self.len() {
            return;
        }
        let between = |k: usize| {
            let after = at.partition_point(|&known| known < k);
            match (after.checked_sub(1).map(|before| at[before]), at.get(after)) {
                (_, Some(&after)) if after == k => measured_rad[k],
                (Some(before), Some(&after)) => {
                    let share = (self.time_s[k] - self.time_s[before])
                        / (self.time_s[after] - self.time_s[before]);
                    measured_rad[before] + share * (measured_rad[after] - measured_rad[before])
                }
                (Some(before), None) => measured_rad[before],
                (None, after) => after.map_or(0.0, |&after| measured_rad[after]),
            }
        };
        let angles: Vec<f64> = (0..self.len()).map(between).collect();
        let noise_rad = without_floor(&angles, &self.kinks()).map_or(0.0, |noise| noise.std);
        self.turned_noise_rad = Some(noise_rad.max(resolution(&angles) / 12f64.sqrt()));
        self.turned_rad = Some(angles);
    }

    /// States the wheel's angle in rad at every sample, corrected by the teeth of its motor, with its standard deviation.
    pub(crate) fn set_corrected_wheel_angles(&mut self, angle_rad: Vec<f64>, std_rad: f64) {
        self.turned_rad = Some(angle_rad);
        self.turned_noise_rad = Some(std_rad);
        self.past = Past::default();
    }

    /// Standard deviation of the noise of the measured wheel angle, rad; `None` where it is the integral of the speed.
    pub fn wheel_angle_noise_rad(&self) -> Option<f64> {
        self.turned_noise_rad
    }

    /// A part of the record, as if it had been recorded on its own. The noise is that of the whole record.
    pub fn slice(&self, samples: std::ops::Range<usize>) -> Record {
        self.part(&samples.collect::<Vec<_>>())
    }

    /// Every `step`-th sample of the record, as if the samples between had not been recorded.
    pub fn every(&self, step: usize) -> Record {
        self.part(&(0..self.len()).step_by(step).collect::<Vec<_>>())
    }

    /// Every `step`-th sample of the log. The current and the wheel's angle still use all samples.
    pub fn thinned(&self, step: usize) -> Record {
        let mut thin = self.every(step);
        let kept = (0..self.len()).step_by(step);
        if self.channel(Output::WheelSpeed).is_some() {
            let whole = self.wheel_angles();
            thin.past.wheel_angle_rad = OnceLock::from(kept.map(|k| whole[k]).collect::<Vec<_>>());
        }
        if let RecordedCurrent::Known(input) = &self.current {
            if !self.current_a.is_empty() {
                let means = self.current_a.chunks(step);
                thin.current_a = means.map(mean).collect();
            }
            thin.current = RecordedCurrent::Known(input.clone());
        }
        thin
    }

    /// The log as averages over `block` samples, each corrected to the value in the middle of its block
    /// (see [`super::averages`]), with the noise of such values. The current and the wheel's angle still use all samples.
    pub fn averaged(&self, block: usize) -> Record {
        let blocks = blocks(self.len(), block);
        let kinks = self.kinks();
        let outputs = Output::ALL.map(|output| {
            let channel = self.channel(output)?;
            Some(middles(&channel.samples, &blocks, &kinks))
        });
        let current_a = (!self.current_a.is_empty()).then(|| means(&self.current_a, &blocks));
        let mut averaged = Record::of_samples(
            &self.name,
            self.kind,
            means(&self.time_s, &blocks),
            outputs,
            current_a,
            self.current_is_measured,
        );
        if let (RecordedCurrent::Known(input), false) = (&self.current, self.current_a.is_empty()) {
            averaged.current = RecordedCurrent::Known(input.clone());
        }
        if self.channel(Output::WheelSpeed).is_some() {
            averaged.turned_rad = Some(means(self.wheel_angles(), &blocks));
        }
        averaged.turned_noise_rad = self.turned_noise_rad;
        averaged.window_s = self.window_s;
        averaged.passes_over_the_top = self.passes_over_the_top;
        averaged.averaged_over = block * self.averaged_over;
        averaged
    }

    fn part(&self, samples: &[usize]) -> Record {
        let pick = |series: &[f64]| samples.iter().map(|&k| series[k]).collect::<Vec<f64>>();
        let outputs =
            Output::ALL.map(|output| self.channel(output).map(|channel| pick(&channel.samples)));
        let current_a = (!self.current_a.is_empty()).then(|| pick(&self.current_a));
        let mut part = Record::of_samples(
            &self.name,
            self.kind,
            pick(&self.time_s),
            outputs,
            current_a,
            self.current_is_measured,
        );
        for channel in &mut part.channels {
            if let Some(whole) = self.channel(channel.output) {
                channel.noise_std = whole.noise_std;
                channel.quantum = whole.quantum;
            }
        }
        part.weight = pick(&self.weight);
        part.window_s = self.window_s;
        part.turned_rad = self.turned_rad.as_deref().map(pick);
        part.turned_noise_rad = self.turned_noise_rad;
        part.teeth = self.teeth;
        part.averaged_over = self.averaged_over;
        part.clock_jitter_s = self.clock_jitter_s;
        part
    }

    /// The samples at which the motion has a kink because the current steps.
    pub(crate) fn kinks(&self) -> Vec<usize> {
        kinks(self.kind, &self.current_a)
    }

    /// The channel that measures `output`, if there is one.
    pub fn channel(&self, output: Output) -> Option<&RecordedChannel> {
        self.channels
            .iter()
            .find(|channel| channel.output == output)
    }

    /// The wheel's angle in rad at every sample, as measured; if only its speed was, the angle by which it has turned since
    /// the log began, the integral of the measured speed (trapezoidal rule; a missing sample repeats the one before). Zeros
    /// if neither was measured.
    pub fn wheel_angles(&self) -> &[f64] {
        if let Some(turned_rad) = &self.turned_rad {
            return turned_rad;
        }
        self.past.wheel_angle_rad.get_or_init(|| {
            let Some(channel) = self.channel(Output::WheelSpeed) else {
                return vec![0.0; self.len()];
            };
            let mut last = 0.0;
            let mut angle = 0.0;
            (0..self.len())
                .map(|k| {
                    let speed = if channel.samples[k].is_finite() {
                        channel.samples[k]
                    } else {
                        last
                    };
                    if k > 0 {
                        angle += 0.5 * (last + speed) * (self.time_s[k] - self.time_s[k - 1]);
                    }
                    last = speed;
                    angle
                })
                .collect()
        })
    }

    /// That angle at one sample; 0 beyond the end of the log.
    pub fn wheel_angle_before(&self, sample: usize) -> f64 {
        self.wheel_angles().get(sample).copied().unwrap_or(0.0)
    }

    /// Angles in rad by which the body moves from each sample before `end` to the next, as measured, backwards from `end`.
    /// They are the rate times the interval; the rate is averaged over [`TRAVEL_AVERAGE_S`], and its mean offset against
    /// the angle is subtracted. Without a rate, they are differences of the angle averaged over nine samples.
    pub fn body_travel_before(&self, end: usize) -> impl Iterator<Item = f64> {
        let travel = self.past.travel_rad.get_or_init(|| self.travel());
        let end = end.min(travel.step_rad.len());
        let offset = travel.disagreement_rad.get(end).copied().unwrap_or(0.0) / end.max(1) as f64;
        travel.step_rad[..end]
            .iter()
            .rev()
            .map(move |step| step + offset)
    }

    fn travel(&self) -> Travel {
        const HALF_AVERAGE: usize = 4;
        let last = self.len().saturating_sub(1);
        let by_angle: Option<Vec<f64>> = self.channel(Output::Angle).map(|channel| {
            let near = |k: usize| {
                let span = k.saturating_sub(HALF_AVERAGE)..(k + HALF_AVERAGE + 1).min(last + 1);
                let finite = channel.samples[span]
                    .iter()
                    .filter(|value| value.is_finite());
                finite.clone().sum::<f64>() / finite.count().max(1) as f64
            };
            (0..last).map(|k| near(k + 1) - near(k)).collect()
        });
        let by_rate: Option<Vec<f64>> = self.channel(Output::Rate).map(|channel| {
            let ends = self.time_s.first().zip(self.time_s.last());
            let span_s = ends.map_or(0.0, |(first, last)| last - first);
            let half =
                (0.5 * TRAVEL_AVERAGE_S * last as f64 / span_s.max(TRAVEL_AVERAGE_S)) as usize;
            let step = |k: usize| {
                let around = k.saturating_sub(half)..(k + 2 + half).min(last + 1);
                let rate = mean(&channel.samples[around]);
                if rate.is_finite() {
                    rate * (self.time_s[k + 1] - self.time_s[k])
                } else {
                    0.0
                }
            };
            (0..last).map(step).collect()
        });
        let mut disagreement_rad = vec![];
        if let (Some(by_angle), Some(by_rate)) = (&by_angle, &by_rate) {
            let mut sum = 0.0;
            disagreement_rad.push(sum);
            for (by_angle, by_rate) in by_angle.iter().zip(by_rate) {
                sum += by_angle - by_rate;
                disagreement_rad.push(sum);
            }
        }
        Travel {
            step_rad: by_rate.or(by_angle).unwrap_or_default(),
            disagreement_rad,
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Number of finite samples with weight, over all channels.
    pub fn observations(&self) -> usize {
        self.channels
            .iter()
            .map(|channel| {
                channel
                    .samples
                    .iter()
                    .zip(&self.weight)
                    .filter(|(sample, weight)| sample.is_finite() && **weight > 0.0)
                    .count()
            })
            .sum()
    }

    /// Divides the samples into windows of `window_s` seconds. The last window may be shorter; if it has fewer than
    /// 8 samples, it is joined to the one before.
    pub fn windows(&self, window_s: f64) -> Vec<std::ops::Range<usize>> {
        let mut windows: Vec<std::ops::Range<usize>> = vec![];
        let mut start = 0;
        while start < self.len() {
            let limit = self.time_s[start] + window_s * (1.0 + 1e-9);
            let end = self.time_s.partition_point(|&time| time < limit);
            let end = end.max(start + 8).min(self.len());
            match windows.last_mut() {
                Some(last) if end - start < 8 => last.end = end,
                _ => windows.push(start..end),
            }
            start = end;
        }
        windows
    }
}
