//! The prediction of a model, compared with the measurement, channel by channel.

use plant::Model;

use super::sensitivity::counts;
use super::simulation::simulate;
use super::unknowns::Window;
use crate::records::{Output, Record, RecordedChannel};

/// The prediction of one channel of one record, compared with the measurement.
#[derive(Clone, Debug)]
pub struct PredictedSeries {
    /// The output of the channel.
    pub output: Output,
    /// The model's output at every sample, SI.
    pub predicted: Vec<f64>,
    /// Root mean square of measured minus predicted, over the samples with weight, in the unit of the channel.
    pub rmse: f64,
    /// Fit in percent: 100 (1 − ‖y − ŷ‖/‖y − mean y‖), with y measured and ŷ predicted.
    pub fit_percent: f64,
}

impl PredictedSeries {
    /// Compares a channel with its prediction, at the samples whose weight is not 0.
    pub fn new(channel: &RecordedChannel, predicted: Vec<f64>, weight: &[f64]) -> PredictedSeries {
        let counted: Vec<(f64, f64)> = channel
            .samples
            .iter()
            .zip(&predicted)
            .zip(weight)
            .filter(|((y, model), weight)| y.is_finite() && model.is_finite() && **weight > 0.0)
            .map(|((y, model), _)| (*y, *model))
            .collect();
        let n = counted.len().max(1) as f64;
        let mean = counted.iter().map(|(y, _)| y).sum::<f64>() / n;
        let error: f64 = counted.iter().map(|(y, model)| (y - model).powi(2)).sum();
        let spread: f64 = counted.iter().map(|(y, _)| (y - mean).powi(2)).sum();
        PredictedSeries {
            output: channel.output,
            predicted,
            rmse: (error / n).sqrt(),
            fit_percent: 100.0 * (1.0 - (error / spread.max(1e-300)).sqrt()),
        }
    }
}

/// Simulates the windows of a record and compares every channel.
pub fn traces(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Vec<PredictedSeries> {
    let all: Vec<&Window> = windows.iter().collect();
    compared(record, &all, model, values)
}

/// As [`traces`], without a prediction (NaN) in windows of which nothing counts. Of a log that is read by the teeth of
/// its motor, these are most.
pub fn traces_that_count(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Vec<PredictedSeries> {
    let counting = windows.iter().filter(|window| counts(record, window));
    let counting: Vec<&Window> = counting.collect();
    compared(record, &counting, model, values)
}

fn compared(
    record: &Record,
    windows: &[&Window],
    model: &Model,
    values: &[f64],
) -> Vec<PredictedSeries> {
    let mut predicted = vec![vec![f64::NAN; record.len()]; record.channels.len()];
    for window in windows {
        simulate(record, window, model, values, |k, reading, _| {
            for (series, channel) in predicted.iter_mut().zip(&record.channels) {
                series[k] = channel.output.of(reading);
            }
        });
    }
    record
        .channels
        .iter()
        .zip(predicted)
        .map(|(channel, predicted)| PredictedSeries::new(channel, predicted, &record.weight))
        .collect()
}
