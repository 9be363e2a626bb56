//! The measured motion: the true state between the samples of a record, with the sensor effects of the model undone.

use plant::{Current, Kind, Model, Plant, State, period_s};

use super::undo::undone;

use crate::fit::{Nuisance, Window, early_steps, simulate};
use crate::records::{Bump, Output, Record, RecordedCurrent, angle_samples, dot, half_samples};

/// Length, in periods of the pendulum, over which the drift of an integrated rate is averaged.
const DRIFT_PERIODS: f64 = 4.0;
/// Half of the span over which a measured speed is averaged before friction is computed from it, in half-widths of the
/// bump. Dry friction computed from a noisy speed would be too small on average.
const SPEED_MEAN: f64 = 0.25;
/// A simulated speed agrees with a measured one if they differ by at most this many standard deviations of the noise. A
/// Gaussian exceeds that once in 16,000.
const AGREEMENT: f64 = 4.0;

/// The measured motion in the middle of every interval between two samples, with the sensor effects of the model
/// undone.
pub struct MeasuredMotion {
    /// Middle of the interval, s.
    pub time_s: Vec<f64>,
    /// Length of the interval, s.
    pub step_s: Vec<f64>,
    /// State in the middle of the interval; NaN if a sample is missing. The wheel angle counts from the start of the log.
    pub state: Vec<State<f64>>,
    /// Change of the angle over the interval, divided by its length, rad/s.
    pub angle_slope: Vec<f64>,
    /// Change of the measured rate over the interval, divided by its length, rad/s²; empty if not measured.
    pub rate_slope: Vec<f64>,
    /// Change of the wheel speed over the interval, divided by its length, rad/s²; empty if not measured.
    pub wheel_speed_slope: Vec<f64>,
    /// Whether measured speeds are replaced by those of the fit's free run where both agree within the noise.
    pub speeds_are_simulated: bool,
    /// Whether the rate was measured. If not, it is computed from the smoothed angle and used for friction terms only.
    pub rate_measured: bool,
    /// Whether the wheel speed was measured. If not, it is that of the fit's free run (`driven`), or 0.
    pub wheel_speed_measured: bool,
    /// Standard deviations of the noise of angle (rad), rate (rad/s) and wheel speed (rad/s), converted to the true
    /// scale; 0 if not measured.
    pub noise_std: [f64; 3],
}

impl MeasuredMotion {
    /// The motion of a record, with the model's sensor effects undone. If `windows` is not empty, the windows' nuisance
    /// parameters (the zero of a quantised angle) are undone as well. `half` is the width in samples over which a
    /// missing rate is computed from the angle.
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
        let plant = Plant::new(model, values, record.kind).for_log(&record.name);
        let moves_body = record.kind != Kind::SpinUp;
        let mut noise_std = [0.0; 3];
        let mut measured = |output: Output| -> Option<Vec<f64>> {
            let channel = record.channel(output)?;
            let (samples, scale) = undone(&plant, output, &channel.samples, &record.time_s);
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
        let nuisances = Nuisance::of(record);
        if let Some(index) = nuisances
            .iter()
            .position(|local| *local == Nuisance::AngleZero)
        {
            for window in windows {
                for value in &mut angle[window.samples.clone()] {
                    *value -= window.nuisances[index];
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
        let turned = speed.as_ref().map(|speed| turned(record, speed));
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
                // If the wheel speed was not measured, that of the fit's free run is used.
                state.wheel_speed_rad_s = mid(&simulated.1, k);
            }
            if state.wheel_speed_rad_s.is_finite() {
                last_speed = state.wheel_speed_rad_s;
            }
            state.wheel_angle_rad = match &turned {
                Some(turned) => mid(turned, k),
                None => wheel_angle + 0.5 * step * last_speed,
            };
            wheel_angle += step * last_speed;
            if let Some(before) = smoothed_before {
                // The contact follows the smoothed path, because noise would move it to and fro.
                let now = smooth(k, false);
                if now.is_finite() && before.is_finite() {
                    friction = plant.remember(friction, now - before);
                }
                smoothed_before = Some(if now.is_finite() { now } else { before });
                state.friction_torque = friction;
            }
        }
        add_current(record, windows, &nuisances, &plant, &mut state);
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

/// The wheel's angle at every sample, from the record or from `speed`, the true speed behind the sensor. A simulated
/// speed is not used: even a small error of the model would add up to turns.
fn turned(record: &Record, speed: &[f64]) -> Vec<f64> {
    let said = match record.channel(Output::WheelSpeed) {
        Some(said) if record.wheel_angle_noise_rad().is_none() => said,
        _ => return record.wheel_angles().to_vec(),
    };
    let off = |k: usize| match speed[k] - said.samples[k] {
        off if off.is_finite() => off,
        _ => 0.0,
    };
    let mut more = 0.0;
    let angles = record.wheel_angles().iter().enumerate();
    angles
        .map(|(k, angle)| {
            if k > 0 {
                more += 0.5 * (off(k - 1) + off(k)) * (record.time_s[k] - record.time_s[k - 1]);
            }
            angle + more
        })
        .collect()
}

/// Removes the slow drift of an angle that was integrated from the rate. The drift is the mean over [`DRIFT_PERIODS`]
/// periods, weighted by a raised cosine; the swing itself averages out. A jump of the phase does not average out, so
/// that the angle is wrong near a push.
fn remove_drift(angle: &mut [f64], record: &Record, values: &[f64]) {
    let half = half_samples(record, 0.5 * DRIFT_PERIODS * period_s(values));
    let n = angle.len();
    // Upright, the body does not swing, and a slow change of the angle is real motion.
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

/// The simulated speed if it agrees with the measured one, otherwise the measured one. Near standstill, the noise of a
/// measured speed decides the sign of dry friction. The missing torque would then depend on the noise of the speed
/// over which it is broken down.
fn agreeing(measured: f64, simulated: f64, std: f64) -> f64 {
    if (measured - simulated).abs() < AGREEMENT * std {
        simulated
    } else {
        measured
    }
}

/// Mean of the finite samples from `k − short` to `k + 1 + short`, around the middle of interval k. NaN if one of the
/// two ends of the interval is missing.
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

/// Fills in the motor current in the middle of every interval.
fn add_current(
    record: &Record,
    windows: &[Window],
    nuisances: &[Nuisance],
    plant: &Plant<f64>,
    state: &mut [State<f64>],
) {
    let plant = if record.current_is_measured {
        plant.clone().with_measured_current()
    } else {
        plant.clone()
    };
    let steps = windows.iter();
    let steps = steps.flat_map(|window| early_steps(record, window, &window.nuisances));
    let plant = plant.with_early_steps(steps.collect());
    let held = |k: usize| -> f64 {
        let index = nuisances
            .iter()
            .position(|local| *local == Nuisance::Current);
        let window = windows.iter().find(|window| window.samples.contains(&k));
        match (index, window) {
            (Some(index), Some(window)) => window.nuisances[index],
            _ => 0.0,
        }
    };
    let current = match &record.current {
        RecordedCurrent::Known(input) => Current::Recorded(input),
        RecordedCurrent::Unknown => Current::Held(0.0),
    };
    let past = nuisances
        .iter()
        .position(|local| *local == Nuisance::PastCurrent);
    let first = windows.iter().find(|window| window.samples.start == 0);
    let before = match past.zip(first) {
        Some((at, first)) => first.nuisances[at],
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
