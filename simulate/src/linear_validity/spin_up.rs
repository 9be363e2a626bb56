//! The spin-up, body clamped: thesis figure 3.6.

use super::linear_model::LinearSpinUp;
use super::measured::{check_lengths, rmse};
use crate::error::{SimulateError, check_positive};
use plant::{Current, Kind, Model, Plant, State};

/// The linear spin-up compared with the nonlinear one, body clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct SpinUpComparison {
    /// The current in A.
    pub current_a: f64,
    /// Time in s.
    pub time_s: Vec<f64>,
    /// Wheel speed of the whole model in rad/s.
    pub whole_rad_s: Vec<f64>,
    /// Wheel speed of the linear model in rad/s.
    pub linear_rad_s: Vec<f64>,
    /// Speed of the whole model in rad/s at which the error of the linear one first exceeds the
    /// required share; `None` if it never does.
    pub good_up_to_rad_s: Option<f64>,
}

/// Drives the wheel from rest with a constant current for `duration_s` seconds, body clamped. The linear
/// model is valid while its error is below `share` of the larger of the speed and a hundredth
/// of the largest speed (without that lower limit, the first instant would decide).
///
/// # Errors
/// Quantities that are not positive.
pub fn compare_spin_up(
    model: &Model,
    values: &[f64],
    current_a: f64,
    duration_s: f64,
    share: f64,
) -> Result<SpinUpComparison, SimulateError> {
    check_positive("the duration in s", duration_s)?;
    check_positive("the share of the speed", share)?;
    const SAMPLES: usize = 1000;
    let step_s = duration_s / SAMPLES as f64;
    let time_s: Vec<f64> = (0..=SAMPLES).map(|index| index as f64 * step_s).collect();
    let plant = Plant::new(model, values, Kind::SpinUp);
    let mut whole_rad_s = vec![];
    plant.run(
        State::rest(),
        &time_s,
        0..time_s.len(),
        Current::Held(current_a),
        None,
        |_, _, state| whole_rad_s.push(state.wheel_speed_rad_s),
    );

    let linear = LinearSpinUp::of(model, values);
    let current_a_held = vec![current_a; time_s.len()];
    let linear_rad_s = linear.run(0.0, &time_s, &current_a_held)?;

    let largest = whole_rad_s
        .iter()
        .map(|speed| speed.abs())
        .fold(0.0, f64::max);
    let good_up_to_rad_s = whole_rad_s
        .iter()
        .zip(&linear_rad_s)
        .find(|(whole, linear)| (*whole - *linear).abs() > share * whole.abs().max(0.01 * largest))
        .map(|(whole, _)| whole.abs());
    Ok(SpinUpComparison {
        current_a,
        time_s,
        whole_rad_s,
        linear_rad_s,
        good_up_to_rad_s,
    })
}

/// A measured spin-up, and the whole model for it; SI units.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredSpinUp<'a> {
    /// Time in s, increasing.
    pub time_s: &'a [f64],
    /// Measured wheel speed in rad/s; NaN where a sample is missing.
    pub wheel_speed_rad_s: &'a [f64],
    /// Current in A, held from each sample to the next.
    pub current_a: &'a [f64],
    /// Wheel speed of the whole model in rad/s.
    pub whole_rad_s: &'a [f64],
}

/// Both models compared with a measured spin-up.
#[derive(Clone, Debug, PartialEq)]
pub struct SpinUpOverMeasurement {
    /// Time in s from the first sample.
    pub time_s: Vec<f64>,
    /// Measured wheel speed in rad/s.
    pub measured_rad_s: Vec<f64>,
    /// The whole model in rad/s.
    pub whole_rad_s: Vec<f64>,
    /// Wheel speed of the linear model in rad/s. Its start is that of the whole model.
    pub linear_rad_s: Vec<f64>,
    /// Largest speed of the whole model in rad/s.
    pub largest_rad_s: f64,
    /// Root mean square of measurement − whole model, relative to the largest speed.
    pub whole_error: f64,
    /// Root mean square of measurement − linear model, relative to the largest speed.
    pub linear_error: f64,
}

/// Compares the linear spin-up with a measured one, from the start of the whole model.
///
/// # Errors
/// Series of different length or fewer than two samples; a wheel that never turns.
pub fn spin_up_over_measurement(
    model: &Model,
    values: &[f64],
    spin_up: &MeasuredSpinUp<'_>,
) -> Result<SpinUpOverMeasurement, SimulateError> {
    check_lengths(&[
        ("the measured spin-up", spin_up.time_s.len()),
        ("the measured wheel speed", spin_up.wheel_speed_rad_s.len()),
        ("the current", spin_up.current_a.len()),
        ("the modelled wheel speed", spin_up.whole_rad_s.len()),
    ])?;
    let whole_rad_s = spin_up.whole_rad_s.to_vec();
    let speeds = whole_rad_s.iter().filter(|speed| speed.is_finite());
    let largest_rad_s = speeds.fold(0.0, |largest: f64, speed| largest.max(speed.abs()));
    check_positive("the largest wheel speed in rad/s", largest_rad_s)?;
    let linear = LinearSpinUp::of(model, values);
    let linear_rad_s = linear.run(whole_rad_s[0], spin_up.time_s, spin_up.current_a)?;
    let error = |modelled: &[f64]| rmse(spin_up.wheel_speed_rad_s, modelled) / largest_rad_s;
    Ok(SpinUpOverMeasurement {
        whole_error: error(&whole_rad_s),
        linear_error: error(&linear_rad_s),
        largest_rad_s,
        time_s: spin_up
            .time_s
            .iter()
            .map(|t| t - spin_up.time_s[0])
            .collect(),
        measured_rad_s: spin_up.wheel_speed_rad_s.to_vec(),
        whole_rad_s,
        linear_rad_s,
    })
}
