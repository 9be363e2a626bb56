//! A log as the fit uses it: its channels with their noise, its current, and the length of the windows in which it is
//! simulated.

use bench_files::{CurrentMeaning, Experiment, Note};
pub use plant::Output;
use plant::{Hold, Input, Kind};

use super::early_steps::{Instant, StepTimes, UnknownStep};
use super::noise::{NoiseFloor, noise_above, steps_of_command};
use super::past::Past;

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
    /// A channel with the noise that its differences show between these kinks.
    fn new(output: Output, samples: Vec<f64>, kinks: &[usize]) -> RecordedChannel {
        let floor = NoiseFloor::of(&samples);
        let noise_std = noise_above(&floor, &samples, kinks).std;
        let mut channel = RecordedChannel {
            output,
            samples,
            noise_std,
            quantum: None,
        };
        channel.set_noise_above(&floor, noise_std);
        channel
    }

    /// Replaces the standard deviation of the noise.
    pub(crate) fn set_noise(&mut self, noise_std: f64) {
        self.set_noise_above(&NoiseFloor::of(&self.samples), noise_std);
    }

    /// As [`RecordedChannel::set_noise`], with the lower limit of these samples.
    fn set_noise_above(&mut self, floor: &NoiseFloor, noise_std: f64) {
        let rounding_std = floor.resolution / 12f64.sqrt();
        self.noise_std = noise_std.max(floor.std);
        let is_quantised = rounding_std >= QUANTISED_SHARE * self.noise_std;
        self.quantum = is_quantised.then_some(floor.resolution);
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
    /// What the motion says about the instants at which the commands changed, where they lie between the samples.
    pub step_times: Option<StepTimes>,
    /// The steps of the command whose instants are unknowns of the fit, in the order of time.
    pub unknown_steps: Vec<UnknownStep>,
    /// When the steps came, where the motion shows it.
    pub(super) instants: Vec<Instant>,
    /// How many samples of the recorded log each sample here is the average of; 1 for a log as recorded.
    pub averaged_over: usize,
    /// The wheel angles of [`Record::wheel_angles`], if they were measured, or if more samples were available than this
    /// record has.
    pub(super) turned_rad: Option<Vec<f64>>,
    /// The noise of the measured wheel angle, rad; `None` if it was not measured.
    pub(super) turned_noise_rad: Option<f64>,
    /// The teeth by which the wheel's angle was corrected; `None` if it was not.
    pub(crate) teeth: Option<ToothStart>,
    pub(super) past: Past,
}

/// The mean of the finite samples; NaN if there is none.
pub(super) fn mean(samples: &[f64]) -> f64 {
    let finite = samples.iter().filter(|sample| sample.is_finite());
    finite.clone().sum::<f64>() / finite.count() as f64
}

impl Record {
    /// Prepares a record from samples in SI units. `angle`, `rate` and `wheel_speed` may be missing; those that this kind
    /// of experiment holds still are ignored. Where the clock jitters, the noise contains what that makes of the motion. Where
    /// the commands changed between samples, their instants become unknowns.
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
        record.find_early_steps();
        record
    }

    /// As [`Record::new`], for samples of a clock that is known or not asked about.
    pub(super) fn of_samples(
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
                Some(RecordedChannel::new(output, samples, &kinks))
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
            step_times: None,
            unknown_steps: vec![],
            instants: vec![],
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
