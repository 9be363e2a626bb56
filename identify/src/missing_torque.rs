//! The torque that a model lacks, from the measurements and without simulating them.
//!
//! What the model says of the accelerations, (α̈_m, φ̈_m) in the measured state, is compared with the
//! accelerations themselves. Weighted with the inertias, the difference is the torque that the model
//! lacks:
//!
//! - on the body: f_b = Θ (α̈ − α̈_m) + j_w (φ̈ − φ̈_m), which knows no motor; Θ (α̈ − α̈_m) where the wheel
//!   is locked,
//! - on the wheel: f_w = j_w (α̈ − α̈_m + φ̈ − φ̈_m), motor and wheel friction together,
//! - on the body by the command: f_b − f_w = (Θ − j_w)(α̈ − α̈_m), which needs no wheel speed and has the
//!   lowest noise, but in which an error of the motor's model looks like a torque on the body.
//!
//! All are evaluated in the weak form (Shinbrot, Trans. ASME 79 (1957)): multiplied by a short bump
//! ψ = (t − a)² (b − t)² and integrated by parts, ∫ψ α̈ = −∫ψ̇ α̇ = ∫ψ̈ α, so that no measurement is
//! differentiated. The result is the torque smoothed by the bump; its integral is that of the torque.
//! Unlike the residual of a free run it has no memory: it says where the model fails now.

use plant::{Current, Kind, Model, Plant, State, TOTAL_INERTIA, WHEEL_INERTIA, period_s};

use crate::record::{Output, Record, RecordedCurrent};
use crate::sensitivity::{Local, Window, simulate};
use crate::start::angle_samples;

/// Fewest samples on either side of a bump's centre.
const FEWEST_HALF_SAMPLES: usize = 4;
/// Half of a bump's width, in periods of the pendulum: well inside the time in which a swing
/// passes anything.
const HALF_BUMP_PERIODS: f64 = 1.0 / 16.0;
/// Half of a bump's width in a spin-up, in lengths of the log: the motion has no period, and what
/// happens within a hundredth of the log is one event.
const HALF_BUMP_LOGS: f64 = 1.0 / 100.0;
/// Length over which the drift of an integrated rate is averaged, in periods of the pendulum.
const DRIFT_PERIODS: f64 = 4.0;
/// Half of the span over which a measured speed is averaged before friction is computed from it, in
/// half-widths of the bump: dry friction of a speed with noise is less than dry friction of the speed.
const SPEED_MEAN: f64 = 0.25;
/// A simulated speed agrees with a measured one within this many standard deviations of its noise: a
/// Gaussian leaves them once in 16,000 times.
const AGREEMENT: f64 = 4.0;
/// Number of bumps from which the noise is computed.
const NOISE_PROBES: usize = 32;

/// Which torque it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TorqueOn {
    /// On the body, by the momentum of body and wheel.
    Body,
    /// On the wheel: friction and motor.
    Wheel,
    /// On the body, with the motor's torque taken from the command.
    BodyByCommand,
}

impl TorqueOn {
    /// The channel to which the torque belongs, as in "experiment/channel".
    pub fn channel(self) -> &'static str {
        match self {
            TorqueOn::Body | TorqueOn::BodyByCommand => Output::Angle.name(),
            TorqueOn::Wheel => Output::WheelSpeed.name(),
        }
    }

    /// Weights of α̈ − α̈_m and φ̈ − φ̈_m in kg m²; `None` where the kind of experiment holds still what
    /// the torque would move.
    fn inertias(self, kind: Kind, values: &[f64]) -> Option<(f64, f64)> {
        let (total, wheel) = (values[TOTAL_INERTIA], values[WHEEL_INERTIA]);
        match (self, kind) {
            (TorqueOn::Body, Kind::FreeSwing) => Some((total, 0.0)),
            (TorqueOn::Body, Kind::Balance | Kind::Driven) => Some((total, wheel)),
            (TorqueOn::Wheel, Kind::SpinUp) => Some((0.0, wheel)),
            (TorqueOn::Wheel, Kind::Balance | Kind::Driven) => Some((wheel, wheel)),
            (TorqueOn::BodyByCommand, Kind::Balance | Kind::Driven) => Some((total - wheel, 0.0)),
            _ => None,
        }
    }
}

/// The torque that a model lacks in one record.
#[derive(Clone, Debug)]
pub struct MissingTorque {
    /// Which torque.
    pub on: TorqueOn,
    /// The sample at the centre of each bump, increasing by [`MissingTorque::stride`] but for gaps.
    pub centres: Vec<usize>,
    /// The torque in N m (per kg m² where the scale of the torques is not known), positive in the
    /// direction of positive speed.
    pub torque_nm: Vec<f64>,
    /// Standard deviation of each value from the noise of the sensors, same unit: the root mean
    /// square over the log.
    pub noise_std_nm: f64,
    /// Correlation of the noise of two bumps that are 0, 1, 2, … strides apart, up to where the
    /// bumps no longer overlap.
    pub noise_correlation: Vec<f64>,
    /// A bump reaches this many samples to either side.
    pub half: usize,
    /// Samples from one bump to the next.
    pub stride: usize,
}

impl MissingTorque {
    /// The weights with which the value at `centre` averages over the intervals from
    /// `centre − half` to `centre + half` of its record; they sum to 1.
    pub fn weights(&self, record: &Record, centre: usize) -> Vec<f64> {
        Bump::around(&record.time_s, centre, self.half).intervals
    }
}

/// The measured motion, the sensor effects of the model undone, at the middle of every interval
/// between two samples.
pub struct MeasuredMotion {
    /// Middle of the interval, s.
    pub time_s: Vec<f64>,
    /// Length of the interval, s.
    pub step_s: Vec<f64>,
    /// State in the middle; NaN where a sample is missing. The wheel angle counts from the start of
    /// the log.
    pub state: Vec<State<f64>>,
    /// Change of the angle over the interval by its length, rad/s.
    pub angle_slope: Vec<f64>,
    /// Change of the measured rate over the interval by its length, rad/s²; empty if not measured.
    pub rate_slope: Vec<f64>,
    /// Change of the wheel speed over the interval by its length, rad/s²; empty if not measured.
    pub wheel_speed_slope: Vec<f64>,
    /// Whether speeds that agree with the fit's free run within their noise are those of the free run.
    pub speeds_are_simulated: bool,
    /// Whether the rate was measured; else it is that of the smoothed angle and serves the friction
    /// terms only.
    pub rate_measured: bool,
    /// Whether the wheel speed was measured; else it is that of the fit's free run (`driven`) or 0.
    pub wheel_speed_measured: bool,
    /// Standard deviations of the noise of angle, rate and wheel speed in the true unit, 0 where not
    /// measured.
    pub noise_std: [f64; 3],
}

/// The weights of a bump over the intervals from `centre − half` to `centre + half`, and over the
/// samples between them; each sums to 1.
///
/// With v linear between samples, ∫ψ̇ v = −Σ (Δv/Δt) ∫ψ: the integration by parts is exact on the
/// samples themselves, so that a constant acceleration comes out exactly, however few there are.
struct Bump {
    intervals: Vec<f64>,
    samples: Vec<f64>,
}

impl Bump {
    fn around(time_s: &[f64], centre: usize, half: usize) -> Bump {
        let (a, b) = (time_s[centre - half], time_s[centre + half]);
        let bump = |t: f64| ((t - a) * (b - t)).powi(2);
        let span = centre - half..centre + half;
        let mut intervals: Vec<f64> = span
            .clone()
            .map(|k| bump(0.5 * (time_s[k] + time_s[k + 1])) * (time_s[k + 1] - time_s[k]))
            .collect();
        let mut samples: Vec<f64> = span
            .skip(1)
            .map(|k| bump(time_s[k]) * 0.5 * (time_s[k + 1] - time_s[k - 1]))
            .collect();
        for weights in [&mut intervals, &mut samples] {
            let area: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= area);
        }
        Bump { intervals, samples }
    }
}

fn dot(weights: &[f64], values: impl Iterator<Item = f64>) -> f64 {
    weights.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// The width of a bump for this record: half of it, in samples.
pub fn half_bump(record: &Record, values: &[f64]) -> usize {
    let n = record.len();
    let span_s = record.time_s[n - 1] - record.time_s[0];
    let half_s = match record.kind {
        Kind::SpinUp => HALF_BUMP_LOGS * span_s,
        _ => HALF_BUMP_PERIODS * period_s(values),
    };
    half_samples(record, half_s)
}

/// A half-width in samples, at least [`FEWEST_HALF_SAMPLES`].
pub(crate) fn half_samples(record: &Record, half_s: f64) -> usize {
    let n = record.len();
    let mean_step_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1).max(1) as f64;
    ((half_s / mean_step_s).round() as usize).clamp(FEWEST_HALF_SAMPLES, n)
}

impl MeasuredMotion {
    /// The motion of a record as the model's sensors would have seen it. `windows` may be empty;
    /// else their own unknowns (the zero of a quantised angle) are undone as well. `half` is the
    /// width over which a missing rate is taken from the angle.
    pub fn new(
        record: &Record,
        windows: &[Window],
        model: &Model,
        values: &[f64],
        half: usize,
    ) -> Option<MeasuredMotion> {
        let n = record.len();
        if n < 2 * half + 2 {
            return None;
        }
        let plant = Plant::new(model, values, record.kind);
        // Every sensor effect is affine in its own channel: two readings give scale and bias.
        let at = |value: f64| {
            plant.read(&State {
                angle_rad: value,
                rate_rad_s: value,
                wheel_speed_rad_s: value,
                ..State::rest()
            })
        };
        let (zero, one) = (at(0.0), at(1.0));
        let undo = |output: Output, samples: &[f64]| -> (Vec<f64>, f64) {
            let (bias, scale) = (output.of(&zero), output.of(&one) - output.of(&zero));
            let undone = samples.iter().map(|sample| (sample - bias) / scale);
            (undone.collect(), scale.abs())
        };
        let moves_body = record.kind != Kind::SpinUp;
        let mut noise_std = [0.0; 3];
        let mut measured = |output: Output| -> Option<Vec<f64>> {
            let channel = record.channel(output)?;
            let (samples, scale) = undo(output, &channel.samples);
            noise_std[output as usize] = channel.noise_std / scale;
            Some(samples)
        };
        let angle = measured(Output::Angle);
        let rate = measured(Output::Rate);
        let speed = measured(Output::WheelSpeed);
        let mut angle = match angle {
            Some(angle) => angle,
            None if moves_body => {
                let mut angle = angle_samples(record)?;
                remove_drift(&mut angle, record, values);
                angle
            }
            None => vec![0.0; n],
        };
        let locals = Local::of(record);
        if let Some(index) = locals.iter().position(|local| *local == Local::AngleZero) {
            for window in windows {
                for value in &mut angle[window.samples.clone()] {
                    *value -= window.locals[index];
                }
            }
        }
        let time_s = &record.time_s;
        let mid = |series: &[f64], k: usize| 0.5 * (series[k] + series[k + 1]);
        let slope =
            |series: &[f64], k: usize| (series[k + 1] - series[k]) / (time_s[k + 1] - time_s[k]);
        let slopes =
            |series: &[f64]| -> Vec<f64> { (0..n - 1).map(|k| slope(series, k)).collect() };
        let smooth = |k: usize, derivative: bool| -> f64 {
            let centre = k.clamp(half, n - 1 - half);
            let bump = Bump::around(time_s, centre, half);
            let span = centre - half..centre + half;
            if derivative {
                dot(&bump.intervals, span.map(|k| slope(&angle, k)))
            } else {
                dot(&bump.intervals, span.map(|k| mid(&angle, k)))
            }
        };
        let simulated = simulated_speeds(record, windows, model, values);
        let short = (half as f64 * SPEED_MEAN) as usize;
        let mut state = vec![State::rest(); n - 1];
        let mut wheel_angle = 0.0;
        let mut last_speed = 0.0;
        let memory = model.find(|info| info.memory.is_some()).is_some() && moves_body;
        let mut smoothed_before = memory.then(|| smooth(0, false));
        let mut friction = 0.0;
        for (k, state) in state.iter_mut().enumerate() {
            let step = time_s[k + 1] - time_s[k];
            state.angle_rad = mid(&angle, k);
            state.rate_rad_s = match &rate {
                Some(rate) => short_mean(rate, k, short),
                None if moves_body => smooth(k, true),
                None => 0.0,
            };
            if rate.is_some()
                && let Some(simulated) = &simulated
            {
                let std = noise_std[Output::Rate as usize] / ((2 * short + 2) as f64).sqrt();
                state.rate_rad_s = agreeing(state.rate_rad_s, mid(&simulated.0, k), std);
            }
            if let Some(speed) = &speed {
                state.wheel_speed_rad_s = short_mean(speed, k, short);
                if let Some(simulated) = &simulated {
                    let std = noise_std[Output::WheelSpeed as usize];
                    let std = std / ((2 * short + 2) as f64).sqrt();
                    state.wheel_speed_rad_s =
                        agreeing(state.wheel_speed_rad_s, mid(&simulated.1, k), std);
                }
            } else if record.kind == Kind::Driven
                && let Some(simulated) = &simulated
            {
                // Where nobody measured the wheel speed, that of the fit's free run has to do.
                state.wheel_speed_rad_s = mid(&simulated.1, k);
            }
            if state.wheel_speed_rad_s.is_finite() {
                last_speed = state.wheel_speed_rad_s;
            }
            state.wheel_angle_rad = wheel_angle + 0.5 * step * last_speed;
            wheel_angle += step * last_speed;
            if let Some(before) = smoothed_before {
                // The path itself, not its noise: noise would work the contact to and fro.
                let now = smooth(k, false);
                if now.is_finite() && before.is_finite() {
                    friction = plant.remember(friction, now - before);
                }
                smoothed_before = Some(if now.is_finite() { now } else { before });
                state.friction_torque = friction;
            }
        }
        add_current(record, windows, &locals, &plant, &mut state);
        Some(MeasuredMotion {
            time_s: (0..n - 1).map(|k| mid(time_s, k)).collect(),
            step_s: (0..n - 1).map(|k| time_s[k + 1] - time_s[k]).collect(),
            state,
            angle_slope: slopes(&angle),
            rate_slope: rate.as_deref().map(slopes).unwrap_or_default(),
            wheel_speed_slope: speed.as_deref().map(slopes).unwrap_or_default(),
            speeds_are_simulated: simulated.is_some(),
            rate_measured: rate.is_some(),
            wheel_speed_measured: speed.is_some(),
            noise_std,
        })
    }
}

/// Takes the slow drift out of an angle that was integrated from the rate: its mean over
/// [`DRIFT_PERIODS`] periods, weighted by a raised cosine, in which the swing itself averages out
/// (but not a jump of its phase: next to a push the angle is wrong).
fn remove_drift(angle: &mut [f64], record: &Record, values: &[f64]) {
    let half = half_samples(record, 0.5 * DRIFT_PERIODS * period_s(values));
    let n = angle.len();
    // Upright the body does not swing, and its slow motion is motion.
    if n < 4 * half || record.kind == Kind::Balance {
        return;
    }
    let weight: Vec<f64> = (0..2 * half)
        .map(|k| {
            (std::f64::consts::PI * (k as f64 + 0.5) / (2 * half) as f64)
                .sin()
                .powi(2)
        })
        .collect();
    let total: f64 = weight.iter().sum();
    let drift: Vec<f64> = (half..n - half)
        .map(|k| dot(&weight, angle[k - half..k + half].iter().copied()) / total)
        .collect();
    for (k, value) in angle.iter_mut().enumerate() {
        *value -= drift[k.clamp(half, n - half - 1) - half];
    }
}

impl MeasuredMotion {
    /// All torques that this motion shows to be missing, by bumps of half-width `half` samples.
    pub fn missing_torques(
        &self,
        record: &Record,
        model: &Model,
        values: &[f64],
        half: usize,
    ) -> Vec<MissingTorque> {
        [TorqueOn::Body, TorqueOn::Wheel, TorqueOn::BodyByCommand]
            .into_iter()
            .filter(|on| match (on, record.kind) {
                (TorqueOn::Body, Kind::FreeSwing) => true,
                (TorqueOn::Body | TorqueOn::Wheel, _) => self.wheel_speed_measured,
                // Body and wheel say the same and more.
                (TorqueOn::BodyByCommand, _) => !self.wheel_speed_measured,
            })
            .filter_map(|on| {
                let shape = (half, half / 2);
                missing_torque(record, &record.weight, self, model, values, on, shape)
            })
            .collect()
    }
}

impl MeasuredMotion {
    /// For each value of a missing torque its derivative with respect to each parameter, in the
    /// order of the parameter vector: what the torque would be if only the parameter were wrong.
    pub fn parameter_slopes(
        &self,
        record: &Record,
        model: &Model,
        values: &[f64],
        missing: &MissingTorque,
    ) -> Vec<Vec<f64>> {
        let mut slopes = vec![vec![0.0; values.len()]; missing.centres.len()];
        let Some((of_body, of_wheel)) = missing.on.inertias(record.kind, values) else {
            return slopes;
        };
        let modelled = |values: &[f64]| -> Vec<f64> {
            let plant = Plant::new(model, values, record.kind);
            self.state
                .iter()
                .map(|state| {
                    let (body, wheel) = plant.derivative(state, state.current_a, 0.0);
                    of_body * body + of_wheel * wheel
                })
                .collect()
        };
        let weights: Vec<Vec<f64>> = missing
            .centres
            .iter()
            .map(|&centre| missing.weights(record, centre))
            .collect();
        let at = modelled(values);
        for parameter in 0..values.len() {
            let step = 1e-5 * values[parameter].abs().max(1e-9);
            let mut moved = values.to_vec();
            moved[parameter] += step;
            let there = modelled(&moved);
            for ((slopes, centre), weights) in slopes.iter_mut().zip(&missing.centres).zip(&weights)
            {
                let span = centre - missing.half..centre + missing.half;
                slopes[parameter] = dot(weights, span.map(|k| (at[k] - there[k]) / step));
            }
        }
        slopes
    }
}

/// Rate and wheel speed of the fit's free run at every sample; `None` without windows.
fn simulated_speeds(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Option<(Vec<f64>, Vec<f64>)> {
    if windows.is_empty() {
        return None;
    }
    let mut speeds = (vec![f64::NAN; record.len()], vec![f64::NAN; record.len()]);
    for window in windows {
        simulate(record, window, model, values, |k, _, state| {
            speeds.0[k] = state.rate_rad_s;
            speeds.1[k] = state.wheel_speed_rad_s;
        });
    }
    Some(speeds)
}

/// The simulated speed where it agrees with the measured one, else the measured one. Near standstill
/// the noise of a speed decides the sign of dry friction, and the torque that seems to be missing
/// then depends on the noise of the very speed over which it is broken down.
fn agreeing(measured: f64, simulated: f64, std: f64) -> f64 {
    if (measured - simulated).abs() < AGREEMENT * std {
        simulated
    } else {
        measured
    }
}

/// Mean of the finite samples from `k − short` to `k + 1 + short`: about the middle of interval k. NaN
/// where one of the interval's own ends is missing.
fn short_mean(samples: &[f64], k: usize, short: usize) -> f64 {
    let short = short.min(k).min(samples.len() - 2 - k);
    let (sum, count) = samples[k - short..=k + 1 + short]
        .iter()
        .filter(|sample| sample.is_finite())
        .fold((0.0, 0.0), |(sum, count), sample| {
            (sum + sample, count + 1.0)
        });
    if samples[k].is_finite() && samples[k + 1].is_finite() {
        sum / count
    } else {
        f64::NAN
    }
}

/// Fills in the current that flows in the middle of every interval.
fn add_current(
    record: &Record,
    windows: &[Window],
    locals: &[Local],
    plant: &Plant<f64>,
    state: &mut [State<f64>],
) {
    let plant = if record.current_is_measured {
        plant.clone().with_measured_current()
    } else {
        plant.clone()
    };
    let held = |k: usize| -> f64 {
        let index = locals.iter().position(|local| *local == Local::Current);
        let window = windows.iter().find(|window| window.samples.contains(&k));
        match (index, window) {
            (Some(index), Some(window)) => window.locals[index],
            _ => 0.0,
        }
    };
    let current = match &record.current {
        RecordedCurrent::Known(input) => Current::Recorded(input),
        RecordedCurrent::Unknown => Current::Held(0.0),
    };
    let past = locals.iter().position(|local| *local == Local::PastCurrent);
    let first = windows.iter().find(|window| window.samples.start == 0);
    let before = match past.zip(first) {
        Some((at, first)) => first.locals[at],
        None => record.current_a.first().copied().unwrap_or(0.0),
    };
    let mut flowing = before;
    for (k, state) in state.iter_mut().enumerate() {
        let (from, to) = (record.time_s[k], record.time_s[k + 1]);
        let drive = match current {
            Current::Recorded(input) => plant.command(input, (from, to), before, k),
            Current::Held(_) => held(k),
        };
        let step = to - from;
        state.current_a = plant.flowing_current(flowing, drive, 0.5 * step, step);
        flowing = plant.flowing_current(flowing, drive, step, step);
    }
}

/// The torques that `model` lacks in a record: on the body and on the wheel, as far as its kind and
/// channels show them. `windows` are those of the fit (or none).
pub fn missing_torques(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Vec<MissingTorque> {
    if record.len() < 4 * FEWEST_HALF_SAMPLES {
        return vec![];
    }
    let half = half_bump(record, values);
    let Some(motion) = MeasuredMotion::new(record, windows, model, values, half) else {
        return vec![];
    };
    motion.missing_torques(record, model, values, half)
}

/// One torque that `model` lacks, smoothed by bumps of half-width `half` samples that begin `stride`
/// samples apart. Bumps that touch a missing sample, or one of weight 0, are left out (an empty
/// `weight` counts them all). `None` where this kind of experiment or its channels do not show the
/// torque.
pub fn missing_torque(
    record: &Record,
    weight: &[f64],
    motion: &MeasuredMotion,
    model: &Model,
    values: &[f64],
    on: TorqueOn,
    (half, stride): (usize, usize),
) -> Option<MissingTorque> {
    let (of_body, of_wheel) = on.inertias(record.kind, values)?;
    let shows_body = record.channel(Output::Angle).is_some() || motion.rate_measured;
    if (of_body != 0.0 && !shows_body) || (of_wheel != 0.0 && !motion.wheel_speed_measured) {
        return None;
    }
    let n = record.len();
    let stride = stride.max(1);
    if n < 2 * half + 2 {
        return None;
    }
    let plant = Plant::new(model, values, record.kind);
    let modelled = |state: &State<f64>| {
        let (body, wheel) = plant.derivative(state, state.current_a, 0.0);
        of_body * body + of_wheel * wheel
    };
    let torque: Vec<f64> = motion.state.iter().map(modelled).collect();
    let counts: Vec<bool> = (0..n - 1)
        .map(|k| {
            torque[k].is_finite()
                && motion.state[k].rate_rad_s.is_finite()
                && [k, k + 1]
                    .iter()
                    .all(|&k| weight.get(k).is_none_or(|&weight| weight > 0.0))
        })
        .collect();
    let by_angle = of_body != 0.0 && !motion.rate_measured;
    let (mut centres, mut torque_nm) = (vec![], vec![]);
    for centre in (half..n - half).step_by(stride) {
        let span = centre - half..centre + half;
        if !counts[span.clone()].iter().all(|counts| *counts) {
            continue;
        }
        let bump = Bump::around(&record.time_s, centre, half);
        let mut value = -dot(&bump.intervals, torque[span.clone()].iter().copied());
        if by_angle {
            let rate = &motion.angle_slope;
            let changes = (span.start + 1..span.end)
                .map(|k| 2.0 * (rate[k] - rate[k - 1]) / (motion.step_s[k] + motion.step_s[k - 1]));
            value += of_body * dot(&bump.samples, changes);
        } else if of_body != 0.0 {
            value += of_body
                * dot(
                    &bump.intervals,
                    motion.rate_slope[span.clone()].iter().copied(),
                );
        }
        if of_wheel != 0.0 {
            let changes = motion.wheel_speed_slope[span].iter().copied();
            value += of_wheel * dot(&bump.intervals, changes);
        }
        centres.push(centre);
        torque_nm.push(value);
    }
    if centres.is_empty() {
        return None;
    }
    let (noise_std_nm, noise_correlation) = noise(
        &record.time_s,
        motion,
        &centres,
        &modelled,
        (of_body, of_wheel),
        (half, stride),
    );
    Some(MissingTorque {
        on,
        centres,
        torque_nm,
        noise_std_nm,
        noise_correlation,
        half,
        stride,
    })
}

/// Standard deviation of the weak form from the noise of the sensors, and its correlation between
/// bumps: the weak form is linear in the noise of every sample, and the model's own part of it is
/// found by moving the state by one standard deviation.
fn noise(
    time_s: &[f64],
    motion: &MeasuredMotion,
    centres: &[usize],
    modelled: &dyn Fn(&State<f64>) -> f64,
    (of_body, of_wheel): (f64, f64),
    (half, stride): (usize, usize),
) -> (f64, Vec<f64>) {
    let lags = (2 * half).div_ceil(stride);
    let mut covariance = vec![0.0; lags + 1];
    let every = centres.len().div_ceil(NOISE_PROBES).max(1);
    let probes = centres.iter().step_by(every);
    let count = probes.clone().count() as f64;
    for &centre in probes {
        let bump = Bump::around(time_s, centre, half);
        for output in Output::ALL {
            let std = motion.noise_std[output as usize];
            if std == 0.0 {
                continue;
            }
            let mut weight = vec![0.0; 2 * half + 1];
            for (index, k) in (centre - half..centre + half).enumerate() {
                let mut moved = motion.state[k];
                match output {
                    Output::Angle => moved.angle_rad += std,
                    Output::Rate => moved.rate_rad_s += std,
                    Output::WheelSpeed => moved.wheel_speed_rad_s += std,
                }
                let change = if motion.speeds_are_simulated && output != Output::Angle {
                    0.0
                } else {
                    modelled(&moved) - modelled(&motion.state[k])
                };
                weight[index] -= 0.5 * bump.intervals[index] * change;
                weight[index + 1] -= 0.5 * bump.intervals[index] * change;
                let of_slope = match output {
                    Output::Angle => 0.0,
                    Output::Rate => of_body,
                    Output::WheelSpeed => of_wheel,
                };
                let slope = std * of_slope * bump.intervals[index] / motion.step_s[k];
                weight[index] -= slope;
                weight[index + 1] += slope;
                if output == Output::Angle && !motion.rate_measured && index > 0 {
                    let (before, after) = (motion.step_s[k - 1], motion.step_s[k]);
                    let change = std * of_body * bump.samples[index - 1] * 2.0 / (before + after);
                    weight[index - 1] += change / before;
                    weight[index] -= change / before + change / after;
                    weight[index + 1] += change / after;
                }
            }
            for (lag, covariance) in covariance.iter_mut().enumerate() {
                let shift = lag * stride;
                let pairs = weight.iter().zip(weight.iter().skip(shift));
                *covariance += pairs.map(|(a, b)| a * b).sum::<f64>() / count;
            }
        }
    }
    let variance = covariance[0].max(1e-300);
    let correlation = covariance.iter().map(|value| value / variance).collect();
    (variance.sqrt(), correlation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::{EffectId, Hold, Input};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const VALUES: [f64; 6] = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
    ];

    /// A simulated log with the noise of the sensors of the thesis' bench.
    fn record(
        kind: Kind,
        model: &Model,
        values: &[f64],
        outputs: [bool; 3],
        push: Option<&dyn Fn(f64) -> f64>,
        seed: u64,
        noise: f64,
    ) -> Record {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let step = 0.004;
        let n = 5000;
        let time_s: Vec<f64> = (0..n).map(|k| k as f64 * step).collect();
        let current: Vec<f64> = time_s.iter().map(|t| 0.5 * (2.0 * t).sin()).collect();
        let input = Input::new(&time_s, &current, Hold::Zero);
        let start = State {
            angle_rad: if kind == Kind::SpinUp { 0.0 } else { 0.35 },
            ..State::rest()
        };
        let drive = match kind {
            Kind::FreeSwing => Current::Held(0.0),
            _ => Current::Recorded(&input),
        };
        let mut series = [vec![], vec![], vec![]];
        Plant::new(model, values, kind).run(start, &time_s, 0..n, drive, push, |_, reading, _| {
            for (output, std) in Output::ALL.into_iter().zip([1.2e-3, 4e-3, 0.6]) {
                let e: f64 = StandardNormal.sample(&mut rng);
                series[output as usize].push(output.of(reading) + noise * std * e);
            }
        });
        let mut series = series.into_iter();
        let outputs = outputs.map(|measured| series.next().filter(|_| measured));
        Record::new("test", kind, time_s, outputs, Some(current), false)
    }

    /// The one window of a log whose start is known.
    fn whole(record: &Record) -> Vec<Window> {
        let locals = Local::of(record)
            .iter()
            .map(|local| if *local == Local::Angle { 0.35 } else { 0.0 })
            .collect();
        let samples = 0..record.len();
        vec![Window { samples, locals }]
    }

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    }

    const CASES: [(Kind, [bool; 3]); 6] = [
        (Kind::FreeSwing, [true, true, false]),
        (Kind::FreeSwing, [true, false, false]),
        (Kind::FreeSwing, [false, true, false]),
        (Kind::SpinUp, [false, false, true]),
        (Kind::Driven, [true, true, true]),
        (Kind::Driven, [true, false, false]),
    ];

    /// Of the right model nothing is missing but noise, and its size is the stated one.
    #[test]
    fn the_right_model_leaves_the_stated_noise() {
        let model = Model::base();
        for (kind, outputs) in CASES {
            let mut ratios = vec![];
            let mut correlations = vec![];
            for seed in 0..12 {
                let record = record(kind, &model, &VALUES, outputs, None, seed, 1.0);
                for missing in missing_torques(&record, &whole(&record), &model, &VALUES) {
                    let ratio = rms(&missing.torque_nm) / missing.noise_std_nm;
                    ratios.push(ratio);
                    // Noise of neighbouring bumps is correlated as stated.
                    let products: f64 = missing
                        .torque_nm
                        .windows(2)
                        .map(|pair| pair[0] * pair[1])
                        .sum::<f64>()
                        / missing.torque_nm.len() as f64;
                    let found = products / rms(&missing.torque_nm).powi(2);
                    correlations.push(found - missing.noise_correlation[1]);
                }
            }
            assert!(!ratios.is_empty());
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((0.93..1.07).contains(&mean), "{kind:?} {outputs:?} {mean}");
            let mean = correlations.iter().sum::<f64>() / correlations.len() as f64;
            assert!(mean.abs() < 0.1, "{kind:?} {outputs:?} {mean}");
        }
    }

    /// A torque that acts, and that the model lacks, is what comes out.
    #[test]
    fn a_torque_that_acts_is_found_in_its_place_and_size() {
        let model = Model::base();
        let push = |t: f64| 2e-2 * (-((t - 8.0) / 0.1).powi(2)).exp();
        for (kind, outputs) in CASES {
            // An angle that is integrated from the rate knows no jump of the phase.
            if kind == Kind::SpinUp || outputs == [false, true, false] {
                continue;
            }
            let record = record(kind, &model, &VALUES, outputs, Some(&push), 1, 0.0);
            for missing in missing_torques(&record, &whole(&record), &model, &VALUES) {
                let (mut impulse, mut moment) = (0.0, 0.0);
                for (centre, torque) in missing.centres.iter().zip(&missing.torque_nm) {
                    let t = record.time_s[*centre];
                    if (t - 8.0).abs() < 0.6 && missing.on != TorqueOn::Wheel {
                        impulse += torque * 0.004 * missing.stride as f64;
                        moment += torque * 0.004 * missing.stride as f64 * (t - 8.0);
                    }
                }
                if missing.on != TorqueOn::Wheel {
                    let expected = 2e-2 * 0.1 * std::f64::consts::PI.sqrt();
                    let ratio = impulse / expected;
                    assert!((ratio - 1.0).abs() < 0.02, "{kind:?} {outputs:?} {ratio}");
                    assert!((moment / impulse).abs() < 2e-3, "{kind:?} {outputs:?}");
                } else {
                    // The wheel feels the push through the body's motion only, which is measured.
                    assert!(
                        rms(&missing.torque_nm) < 1e-5,
                        "{}",
                        rms(&missing.torque_nm)
                    );
                }
            }
        }
    }

    /// Every effect of the library, when the model has it, leaves nothing: sensors are undone, lag
    /// and delay are carried along, presliding friction remembers the measured path.
    #[test]
    fn a_model_with_the_effect_that_acts_lacks_nothing() {
        for &effect in EffectId::ALL {
            let info = effect.info();
            let model = Model::base().with(effect);
            let mut values = VALUES.to_vec();
            let at = model.position(effect).expect("just added");
            if at >= 6 {
                values.extend(info.parameters.iter().map(|parameter| {
                    let (low, high) = parameter.plausible;
                    if low > 0.0 {
                        (low * high).sqrt()
                    } else {
                        0.3 * high
                    }
                }));
                if effect == EffectId::BackEmfLimit {
                    values[at..].copy_from_slice(&[12.0, 8.0]);
                }
            }
            let record = record(Kind::Driven, &model, &values, [true; 3], None, 2, 0.0);
            let with = missing_torques(&record, &[], &model, &values);
            let without = missing_torques(&record, &[], &Model::base(), &VALUES);
            let largest = without
                .iter()
                .map(|m| rms(&m.torque_nm))
                .fold(0.0, f64::max);
            for missing in with {
                let left = rms(&missing.torque_nm);
                assert!(
                    left < 0.1 * largest || left < 1e-5,
                    "{} on {:?}: {left:.2e} of {largest:.2e}",
                    info.name,
                    missing.on
                );
            }
        }
    }
}
