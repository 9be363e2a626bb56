//! The residuals, prepared for a breakdown: missing torques, and outputs of the free run.

use nalgebra::{Cholesky, DMatrix, DVector};
use plant::Kind;

use super::super::residual_torque::{MeasuredMotion, ResidualTorque, TorqueOn};
use super::super::structure::without_rounding;
use crate::fit::PredictedSeries;
use crate::records::{Output, Record};

/// Uncertainty of a sum of squares in a balance log, as a share of the squared noise. Two causes: the controller
/// responds to the noise of the sensors, so the motion depends on that noise; and dry friction near
/// standstill turns the error of the rate into torque. In 24 simulated logs with the right model, the
/// coordinates explained 3 % of the squared noise on average, and 8 % at most: four times this value.
const FEEDBACK: f64 = 0.02;

/// One residual of one record, prepared for a breakdown.
pub(super) struct ResidualSeries {
    pub(super) record: usize,
    pub(super) channel: &'static str,
    pub(super) noise_std: f64,
    /// Values divided by their noise.
    pub(super) values: Vec<f64>,
    /// For each value: the first interval of the log that it averages over, and the weights of the intervals from there.
    pub(super) looks: Vec<(usize, Vec<f64>)>,
    /// Correlation of the noise between values that are 0, 1, 2, … strides apart.
    pub(super) noise_correlation: Vec<f64>,
    /// For each value: its position in strides, from which gaps follow.
    pub(super) position: Vec<usize>,
    /// Whether the second coefficient uses the sign of the wheel speed; otherwise that of the body rate.
    pub(super) wheel: bool,
}

impl ResidualSeries {
    /// Sum of the squared values above the noise.
    pub(super) fn excess(&self) -> f64 {
        self.values.iter().map(|value| value * value - 1.0).sum()
    }
}

pub(super) fn torque_series(
    index: usize,
    record: &Record,
    missing: &ResidualTorque,
) -> ResidualSeries {
    ResidualSeries {
        record: index,
        channel: missing.on.channel(),
        noise_std: missing.noise_std_nm,
        values: missing
            .torque_nm
            .iter()
            .map(|torque| torque / missing.noise_std_nm)
            .collect(),
        looks: missing
            .centres
            .iter()
            .map(|&centre| (centre - missing.half, missing.weights(record, centre)))
            .collect(),
        noise_correlation: missing.noise_correlation.clone(),
        position: missing
            .centres
            .iter()
            .map(|centre| centre / missing.stride)
            .collect(),
        wheel: missing.on == TorqueOn::Wheel,
    }
}

/// The residuals of the channels of a record, without the part that rounding explains.
pub(super) fn output_series(
    index: usize,
    record: &Record,
    traces: &[PredictedSeries],
) -> Vec<ResidualSeries> {
    record
        .channels
        .iter()
        .zip(traces)
        .map(|(channel, trace)| {
            let residual = match channel.quantum {
                Some(quantum) => without_rounding(
                    &channel.samples,
                    &trace.predicted,
                    channel.noise_std,
                    quantum,
                ),
                None => channel
                    .samples
                    .iter()
                    .zip(&trace.predicted)
                    .map(|(measured, model)| measured - model)
                    .collect(),
            };
            let counted: Vec<usize> = (0..record.len() - 1)
                .filter(|&k| residual[k].is_finite() && record.weight[k] > 0.0)
                .collect();
            ResidualSeries {
                record: index,
                channel: channel.output.name(),
                noise_std: channel.noise_std,
                values: counted
                    .iter()
                    .map(|&k| residual[k] / channel.noise_std)
                    .collect(),
                looks: counted.iter().map(|&k| (k, vec![1.0])).collect(),
                noise_correlation: vec![1.0],
                position: counted,
                wheel: channel.output == Output::WheelSpeed,
            }
        })
        .collect()
}

/// Removes from a torque the part that wrong parameters explain, by least squares over all logs. The fit of an
/// incomplete model has biased parameters; the missing torque then contains the missing effect and, everywhere else,
/// the bias.
pub(super) fn adjust(group: &mut [(&mut ResidualSeries, &[Vec<f64>])], parameters: usize) {
    let mut square = DMatrix::<f64>::zeros(parameters, parameters);
    let mut right = DVector::<f64>::zeros(parameters);
    for (series, slopes) in group.iter() {
        for (value, slope) in series.values.iter().zip(slopes.iter()) {
            for row in 0..parameters {
                right[row] += slope[row] / series.noise_std * value;
                for column in 0..parameters {
                    square[(row, column)] +=
                        slope[row] * slope[column] / (series.noise_std * series.noise_std);
                }
            }
        }
    }
    // The parameters have different units. One without influence, or collinear with another, is left out.
    let scale = DVector::from_fn(parameters, |k, _| match square[(k, k)] {
        own if own > 0.0 => 1.0 / own.sqrt(),
        _ => 0.0,
    });
    let scaled = DMatrix::from_fn(parameters, parameters, |row, column| {
        let ridge = if row == column { 1e-9 } else { 0.0 };
        square[(row, column)] * scale[row] * scale[column] + ridge
    });
    let Some(cholesky) = Cholesky::new(scaled) else {
        return;
    };
    let change = cholesky
        .solve(&right.component_mul(&scale))
        .component_mul(&scale);
    for (series, slopes) in group.iter_mut() {
        let noise_std = series.noise_std;
        for (value, slope) in series.values.iter_mut().zip(slopes.iter()) {
            let explained: f64 = slope.iter().zip(change.iter()).map(|(a, b)| a * b).sum();
            *value -= explained / noise_std;
        }
    }
}

pub(super) struct Context<'a> {
    pub(super) records: &'a [Record],
    /// For each record and coordinate: the value in every interval.
    pub(super) places: &'a [Vec<Vec<f64>>],
    pub(super) motions: &'a [Option<MeasuredMotion>],
}

impl Context<'_> {
    pub(super) fn speed(&self, series: &ResidualSeries, interval: usize) -> f64 {
        self.motions[series.record].as_ref().map_or(0.0, |motion| {
            let state = &motion.state[interval];
            if series.wheel {
                state.wheel_speed_rad_s
            } else {
                state.rate_rad_s
            }
        })
    }

    /// The share of noise that the motion seems to explain because a controller turns noise into motion.
    pub(super) fn feedback(&self, series: &ResidualSeries) -> f64 {
        match self.records[series.record].kind {
            Kind::Balance => FEEDBACK * series.values.len() as f64,
            _ => 0.0,
        }
    }

    /// The coordinate of every interval that a series averages over.
    pub(super) fn seen(&self, series: &ResidualSeries, coordinate: usize) -> Vec<f64> {
        let place = &self.places[series.record][coordinate];
        series
            .looks
            .iter()
            .map(|(start, weights)| place[start + weights.len() / 2])
            .collect()
    }
}
