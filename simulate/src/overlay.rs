//! A simulated loop compared with a measured balance log (thesis figure 5.2).
//!
//! A balancing loop forgets its start within a second. The whole log can therefore be simulated as one
//! run, with the pushes that were found in it. Between pushes, bench and simulation respond to
//! different noise, so the curves do not coincide there; their spread can be compared.

use crate::closed_loop::{ClosedLoop, LoopTrace};
use crate::error::SimulateError;
use crate::law::Law;
use plant::State;
use std::f64::consts::PI;

/// A measured balance log; SI units, angle 0 hanging. Missing samples are NaN.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredLog<'a> {
    /// Time in s, increasing.
    pub time_s: &'a [f64],
    /// Body angle in rad.
    pub angle_rad: &'a [f64],
    /// Body rate in rad/s, where it was logged.
    pub rate_rad_s: Option<&'a [f64]>,
    /// Wheel speed in rad/s, where it was logged.
    pub wheel_speed_rad_s: Option<&'a [f64]>,
    /// Commanded current in A, where it was logged.
    pub current_a: Option<&'a [f64]>,
}

/// One channel of both, at the times of the log.
#[derive(Clone, Debug, PartialEq)]
pub struct OverlaidChannel {
    /// "angle", "rate", "wheel_speed", "current".
    pub name: &'static str,
    /// As measured; the angle in rad from upright, other channels in SI units.
    pub measured: Vec<f64>,
    /// The channel as the simulated controller received it, in the unit of `measured`.
    pub simulated: Vec<f64>,
    /// Root mean square of measured − simulated, in the unit of `measured`.
    pub rms_difference: f64,
    /// Standard deviation of the measured channel, in the unit of `measured`.
    pub measured_std: f64,
    /// Standard deviation of the simulated channel, in the unit of `measured`.
    pub simulated_std: f64,
    /// Fit in percent: 100·(1 − ‖y − ŷ‖/‖y − mean y‖).
    pub fit_percent: f64,
}

/// Measured and simulated loop.
#[derive(Clone, Debug, PartialEq)]
pub struct LoggedLoop {
    /// Time in s, as in the log.
    pub time_s: Vec<f64>,
    /// The channels that the log has.
    pub channels: Vec<OverlaidChannel>,
    /// The simulated run, from time zero at the first sample of the log.
    pub trace: LoopTrace,
}

/// Simulates the log with `law` on the bench `on`, whose pushes are at the times of the log.
///
/// # Errors
/// Series of different length or fewer than two samples; those of [`ClosedLoop::run`].
pub fn overlay(
    log: &MeasuredLog<'_>,
    on: &ClosedLoop<'_>,
    law: &mut dyn Law,
) -> Result<LoggedLoop, SimulateError> {
    let count = log.time_s.len();
    if count < 2 {
        return Err(SimulateError::WrongLength {
            what: "the balance log",
            found: count,
            expected: 2,
        });
    }
    let channels = [
        ("angle", Some(log.angle_rad)),
        ("rate", log.rate_rad_s),
        ("wheel_speed", log.wheel_speed_rad_s),
        ("current", log.current_a),
    ];
    for (what, series) in channels {
        if let Some(series) = series.filter(|series| series.len() != count) {
            return Err(SimulateError::WrongLength {
                what,
                found: series.len(),
                expected: count,
            });
        }
    }

    let first_s = log.time_s[0];
    let start_of = |series: Option<&[f64]>| {
        // The mean of a few samples, since a single one has the sensor's noise.
        let few: Vec<f64> = series
            .unwrap_or(&[])
            .iter()
            .take(5)
            .copied()
            .filter(|value| value.is_finite())
            .collect();
        if few.is_empty() {
            0.0
        } else {
            few.iter().sum::<f64>() / few.len() as f64
        }
    };
    let start = State {
        angle_rad: start_of(Some(log.angle_rad)),
        rate_rad_s: start_of(log.rate_rad_s),
        wheel_speed_rad_s: start_of(log.wheel_speed_rad_s),
        ..State::rest()
    };
    let mut moved = on.clone();
    for push in &mut moved.pushes {
        push.time_s -= first_s;
    }
    let duration_s = (log.time_s[count - 1] - first_s).max(on.sample_time_s);
    let trace = moved.run(&start, duration_s, law, false)?;

    let simulated = [
        &trace.measured_angle_rad,
        &trace.measured_rate_rad_s,
        &trace.measured_wheel_speed_rad_s,
        &trace.current_a,
    ];
    let channels = channels
        .into_iter()
        .zip(simulated)
        .filter_map(|((name, measured), simulated)| {
            let offset = if name == "angle" { PI } else { 0.0 };
            let measured: Vec<f64> = measured?.iter().map(|value| value - offset).collect();
            let simulated = log
                .time_s
                .iter()
                .map(|time_s| at_time(simulated, time_s - first_s, on.sample_time_s))
                .collect();
            Some(OverlaidChannel::new(name, measured, simulated))
        })
        .collect();
    Ok(LoggedLoop {
        time_s: log.time_s.to_vec(),
        channels,
        trace,
    })
}

/// The value of a series at a time, interpolated linearly between its samples.
fn at_time(series: &[f64], time_s: f64, sample_time_s: f64) -> f64 {
    let position = (time_s / sample_time_s).max(0.0);
    let index = position as usize;
    match (series.get(index), series.get(index + 1)) {
        (Some(here), Some(next)) => here + (next - here) * (position - index as f64),
        (Some(here), None) => *here,
        _ => series.last().copied().unwrap_or(f64::NAN),
    }
}

impl OverlaidChannel {
    fn new(name: &'static str, measured: Vec<f64>, simulated: Vec<f64>) -> Self {
        let pairs: Vec<(f64, f64)> = measured
            .iter()
            .copied()
            .zip(simulated.iter().copied())
            .filter(|(measured, simulated)| measured.is_finite() && simulated.is_finite())
            .collect();
        let count = pairs.len().max(1) as f64;
        let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / count;
        let (mean_measured, mean_simulated) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let root_mean = |squares: f64| (squares / count).sqrt();
        let rms_difference = root_mean(pairs.iter().map(|(y, s)| (y - s).powi(2)).sum());
        let measured_std = root_mean(pairs.iter().map(|(y, _)| (y - mean_measured).powi(2)).sum());
        let simulated_std = root_mean(
            pairs
                .iter()
                .map(|(_, s)| (s - mean_simulated).powi(2))
                .sum(),
        );
        OverlaidChannel {
            name,
            rms_difference,
            measured_std,
            simulated_std,
            fit_percent: 100.0 * (1.0 - rms_difference / measured_std),
            measured,
            simulated,
        }
    }
}
