//! The free swing: thesis figure 3.5, 20° against 60°; measured swings and their periods.

use super::linear_model::{LinearSwing, smooth_part};
use super::measured::{check_lengths, rmse};
use crate::error::{SimulateError, check_positive};
use plant::{Drive, Kind, Model, Plant, State};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The linear free swing compared with the nonlinear one.
#[derive(Clone, Debug, PartialEq)]
pub struct SwingComparison {
    /// Angle at which the body is released, in rad.
    pub amplitude_rad: f64,
    /// Time in s.
    pub time_s: Vec<f64>,
    /// Angle of the whole model, with all effects, in rad.
    pub whole_rad: Vec<f64>,
    /// Angle of the nonlinear model with only those terms that have a linearisation, in rad.
    pub smooth_rad: Vec<f64>,
    /// Angle of the linear model in rad.
    pub linear_rad: Vec<f64>,
    /// Period of the linear model in s.
    pub linear_period_s: f64,
    /// First period of the whole model in s; `None` if it does not complete one.
    pub first_period_s: Option<f64>,
    /// Root mean square of linear − whole over the first period, relative to the amplitude.
    pub error_over_first_period: f64,
    /// Root mean square of linear − smooth over the first period, relative to the amplitude.
    pub geometric_error_over_first_period: f64,
}

/// Number of samples per linear period.
const SAMPLES_A_PERIOD: usize = 200;

/// Releases the body at `amplitude_rad` for `duration_s` seconds in all three models.
///
/// # Errors
/// An amplitude or a duration that is not positive; a model that does not swing.
pub fn compare_free_swing(
    model: &Model,
    values: &[f64],
    amplitude_rad: f64,
    duration_s: f64,
) -> Result<SwingComparison, SimulateError> {
    check_positive("the amplitude in rad", amplitude_rad)?;
    check_positive("the duration in s", duration_s)?;
    let (smooth_model, smooth_values) = smooth_part(model, values);
    let linear = LinearSwing::of(&smooth_model, &smooth_values);
    let linear_period_s = linear.period_s()?;
    let step_s = linear_period_s / SAMPLES_A_PERIOD as f64;
    let samples = ((duration_s / step_s).ceil() as usize).max(SAMPLES_A_PERIOD) + 1;
    let time_s: Vec<f64> = (0..samples).map(|index| index as f64 * step_s).collect();

    let linear_rad = linear.run([amplitude_rad, 0.0], &time_s)?;
    let whole_rad = swing(model, values, amplitude_rad, &time_s);
    let smooth_rad = swing(&smooth_model, &smooth_values, amplitude_rad, &time_s);
    let error = |other: &[f64]| relative_error(&linear_rad, other, amplitude_rad, SAMPLES_A_PERIOD);
    Ok(SwingComparison {
        amplitude_rad,
        linear_period_s,
        first_period_s: first_period_s(&time_s, &whole_rad),
        error_over_first_period: error(&whole_rad),
        geometric_error_over_first_period: error(&smooth_rad),
        time_s,
        whole_rad,
        smooth_rad,
        linear_rad,
    })
}

/// The largest amplitude in rad at which the linear swing follows the nonlinear one with the same
/// terms over `periods` periods within `share` of the amplitude (root mean square).
///
/// # Errors
/// Quantities that are not positive; a model that does not swing.
pub fn largest_linear_amplitude(
    model: &Model,
    values: &[f64],
    periods: usize,
    share: f64,
) -> Result<f64, SimulateError> {
    check_positive("the number of periods", periods as f64)?;
    check_positive("the share of the amplitude", share)?;
    let (model, values) = smooth_part(model, values);
    let linear = LinearSwing::of(&model, &values);
    let step_s = linear.period_s()? / SAMPLES_A_PERIOD as f64;
    let samples = periods * SAMPLES_A_PERIOD;
    let time_s: Vec<f64> = (0..=samples).map(|index| index as f64 * step_s).collect();
    let error = |amplitude: f64| -> Result<f64, SimulateError> {
        let linear_rad = linear.run([amplitude, 0.0], &time_s)?;
        let nonlinear = swing(&model, &values, amplitude, &time_s);
        Ok(relative_error(&linear_rad, &nonlinear, amplitude, samples))
    };
    // The error grows with the amplitude; at half of the way to upright, the linear model is useless.
    let (mut good, mut bad) = (0.0, FRAC_PI_2);
    if error(bad)? <= share {
        return Ok(bad);
    }
    for _ in 0..30 {
        let middle = 0.5 * (good + bad);
        if error(middle)? <= share {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(good)
}

/// A measured free swing, and the whole model for it; angle 0 hanging, SI units.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredSwing<'a> {
    /// Time in s, increasing.
    pub time_s: &'a [f64],
    /// Measured angle in rad; NaN where a sample is missing.
    pub angle_rad: &'a [f64],
    /// Sensor reading according to the whole model, in rad.
    pub whole_rad: &'a [f64],
    /// True angle (rad) and rate (rad/s) of the whole model at the first sample.
    pub start: [f64; 2],
}

/// Both models over the first periods of a measured swing.
#[derive(Clone, Debug, PartialEq)]
pub struct SwingOverMeasurement {
    /// Amplitude of the linear model from the common start, in rad.
    pub amplitude_rad: f64,
    /// Time in s from the first sample.
    pub time_s: Vec<f64>,
    /// Measured angle in rad.
    pub measured_rad: Vec<f64>,
    /// The whole model in rad.
    pub whole_rad: Vec<f64>,
    /// The linear model in rad.
    pub linear_rad: Vec<f64>,
    /// Root mean square of measurement − whole model over these periods, relative to the amplitude.
    pub whole_error: f64,
    /// Root mean square of measurement − linear model over these periods, relative to the amplitude.
    pub linear_error: f64,
}

/// Compares the linear free swing with the first `periods` periods of a measured one (or with the
/// whole log, if it is shorter), from the start of the whole model.
///
/// # Errors
/// If the series have different lengths or fewer than two samples; if the model does not swing, or is at rest
/// at the start.
pub fn over_measurement(
    model: &Model,
    values: &[f64],
    swing: &MeasuredSwing<'_>,
    periods: usize,
) -> Result<SwingOverMeasurement, SimulateError> {
    check_lengths(&[
        ("the measured swing", swing.time_s.len()),
        ("the measured angle", swing.angle_rad.len()),
        ("the modelled angle", swing.whole_rad.len()),
    ])?;
    let (smooth_model, smooth_values) = smooth_part(model, values);
    let linear = LinearSwing::of(&smooth_model, &smooth_values);
    let period_s = linear.period_s()?;
    let from_rest = [
        swing.start[0] - linear.rest_rad,
        swing.start[1] * period_s / TAU,
    ];
    let amplitude_rad = from_rest[0].hypot(from_rest[1]);
    check_positive("the amplitude in rad", amplitude_rad)?;

    let first_s = swing.time_s[0];
    let until_s = first_s + periods as f64 * period_s;
    let count = swing.time_s.partition_point(|time| *time <= until_s).max(2);
    let time_s: Vec<f64> = swing.time_s[..count].iter().map(|t| t - first_s).collect();
    let measured_rad = swing.angle_rad[..count].to_vec();
    let whole_rad = swing.whole_rad[..count].to_vec();
    // An offset of the sensor belongs to the reading of both models.
    let offset_rad = whole_rad[0] - swing.start[0];
    let linear_rad: Vec<f64> = linear
        .run(swing.start, &time_s)?
        .iter()
        .map(|angle| angle + offset_rad)
        .collect();
    let error = |modelled: &[f64]| rmse(&measured_rad, modelled) / amplitude_rad;
    Ok(SwingOverMeasurement {
        amplitude_rad,
        whole_error: error(&whole_rad),
        linear_error: error(&linear_rad),
        time_s,
        measured_rad,
        whole_rad,
        linear_rad,
    })
}

/// The period of a measured swing at one amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredPeriod {
    /// Amplitude in rad.
    pub amplitude_rad: f64,
    /// Period in s.
    pub period_s: f64,
    /// Its standard error in s.
    pub std_s: f64,
}

/// Measured periods compared with that of the linear model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearRange {
    /// Period of the linear model in s.
    pub linear_period_s: f64,
    /// Smallest and largest amplitude in rad with a sufficiently precise period.
    pub measured_rad: (f64, f64),
    /// Range of amplitudes in rad in which the measured periods equal that of the linear model
    /// within the required share; `None` if there is no such range.
    pub good_rad: Option<(f64, f64)>,
    /// The next larger amplitude in rad with a measured period, at which the linear model is
    /// no longer valid; `None` if it is valid up to the largest.
    pub off_from_rad: Option<f64>,
}

/// Where the linear model has the measured periods within `share`: the range of amplitudes that contains
/// the most such periods; other periods inside count against it in proportion to their deviation. A period whose
/// standard error exceeds the share is left out. `None` if none remains.
///
/// # Errors
/// A share that is not positive; a model that does not swing.
pub fn linear_range(
    model: &Model,
    values: &[f64],
    periods: &[MeasuredPeriod],
    share: f64,
) -> Result<Option<LinearRange>, SimulateError> {
    check_positive("the share of the period", share)?;
    let (smooth_model, smooth_values) = smooth_part(model, values);
    let linear_period_s = LinearSwing::of(&smooth_model, &smooth_values).period_s()?;
    let mut known: Vec<&MeasuredPeriod> = periods
        .iter()
        .filter(|period| period.std_s <= share * linear_period_s)
        .collect();
    known.sort_by(|a, b| a.amplitude_rad.total_cmp(&b.amplitude_rad));
    let (Some(first), Some(last)) = (known.first(), known.last()) else {
        return Ok(None);
    };
    // The run with the largest sum (Kadane's algorithm).
    let (mut best, mut best_sum) = (None, 0.0);
    let (mut from, mut sum) = (first.amplitude_rad, 0.0);
    for period in &known {
        if sum <= 0.0 {
            (from, sum) = (period.amplitude_rad, 0.0);
        }
        sum += share - (period.period_s / linear_period_s - 1.0).abs();
        if sum > best_sum {
            (best, best_sum) = (Some((from, period.amplitude_rad)), sum);
        }
    }
    Ok(Some(LinearRange {
        linear_period_s,
        measured_rad: (first.amplitude_rad, last.amplitude_rad),
        good_rad: best,
        off_from_rad: best.and_then(|(_, to)| {
            let mut amplitudes = known.iter().map(|period| period.amplitude_rad);
            amplitudes.find(|amplitude| *amplitude > to)
        }),
    }))
}

fn swing(model: &Model, values: &[f64], amplitude_rad: f64, time_s: &[f64]) -> Vec<f64> {
    let plant = Plant::new(model, values, Kind::FreeSwing);
    let mut state = State {
        angle_rad: amplitude_rad,
        ..State::rest()
    };
    let drive = Drive {
        current_a: 0.0,
        push: [0.0; 3],
    };
    let mut angles = vec![amplitude_rad];
    for pair in time_s.windows(2) {
        state = plant.step(&state, &drive, pair[1] - pair[0]);
        angles.push(state.angle_rad);
    }
    angles
}

/// Root mean square of the difference over the first `samples` steps, relative to the amplitude.
fn relative_error(left: &[f64], right: &[f64], amplitude_rad: f64, samples: usize) -> f64 {
    let squares: f64 = left
        .iter()
        .zip(right)
        .take(samples + 1)
        .map(|(left, right)| (left - right).powi(2))
        .sum();
    (squares / (samples + 1) as f64).sqrt() / amplitude_rad
}

/// Twice the time between the first two zero crossings, each interpolated linearly between
/// samples.
fn first_period_s(time_s: &[f64], angle_rad: &[f64]) -> Option<f64> {
    let mut crossings = time_s
        .windows(2)
        .zip(angle_rad.windows(2))
        .filter(|(_, angle)| angle[0] * angle[1] < 0.0)
        .map(|(time, angle)| time[0] + (time[1] - time[0]) * angle[0] / (angle[0] - angle[1]));
    let (first, second) = (crossings.next()?, crossings.next()?);
    Some(2.0 * (second - first))
}
