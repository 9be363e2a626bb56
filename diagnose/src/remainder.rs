//! The structured residual of every series, in units of the series' noise.

use identify::{PredictedSeries, Record, RecordedChannel, structure, without_rounding};

/// Noise standard deviation of every series, each in the unit of its channel; record by record, channel by channel.
pub fn noise(records: &[&Record]) -> Vec<f64> {
    records
        .iter()
        .flat_map(|record| record.channels.iter().map(|channel| channel.noise_std))
        .collect()
}

/// Measured minus predicted, sample by sample; NaN where either is missing.
pub fn residual(measured: &[f64], predicted: &[f64]) -> Vec<f64> {
    measured
        .iter()
        .zip(predicted)
        .map(|(measured, predicted)| measured - predicted)
        .collect()
}

/// The structured remainder of a channel: the root mean square of the structured part of its residual, in units of
/// the channel's noise; 0 where it is not significant.
pub fn remainder(channel: &RecordedChannel, predicted: &[f64], weight: &[f64]) -> f64 {
    let left = match channel.quantum {
        Some(quantum) => without_rounding(&channel.samples, predicted, channel.noise_std, quantum),
        None => residual(&channel.samples, predicted),
    };
    let found = structure(&left, channel.noise_std, weight);
    if found.is_significant() {
        found.rms_over_noise
    } else {
        0.0
    }
}

/// As [`remainder`], for every channel of a record.
pub fn remainders_of(record: &Record, traces: &[PredictedSeries]) -> Vec<f64> {
    let channels = record.channels.iter().zip(traces);
    channels
        .map(|(channel, trace)| remainder(channel, &trace.predicted, &record.weight))
        .collect()
}
