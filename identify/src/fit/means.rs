//! A model against the means of the series: what a fit must beat to be one.

use plant::Model;

use super::comparison::traces;
use super::solver::cost;
use super::unknowns::{Unknowns, Window, relevant};
use crate::records::{Output, Record};

/// A series that a fit predicts no better than its mean does, or hardly.
#[derive(Clone, Debug, PartialEq)]
pub struct NoBetterThanMean {
    /// The experiment.
    pub experiment: String,
    /// What was measured.
    pub output: Output,
    /// Root mean square of measured − predicted, in the unit of the output.
    pub rmse: f64,
    /// Root mean square of measured − its mean (of each window, where the log is compared in windows).
    pub spread: f64,
}

/// Sum of squared normalised deviations of each channel of a record from its mean over every window: what a fit
/// would cost that predicts no motion at all.
fn squares_about_means(record: &Record, windows: &[Window]) -> Vec<(f64, usize)> {
    let of_channel = |samples: &[f64]| {
        let mut squares = 0.0;
        let mut count = 0;
        for window in windows {
            let counted = || {
                window
                    .samples
                    .clone()
                    .filter(|&k| samples[k].is_finite() && record.weight[k] > 0.0)
            };
            let own = counted().count();
            let mean = counted().map(|k| samples[k]).sum::<f64>() / own.max(1) as f64;
            squares += counted()
                .map(|k| (record.weight[k] * (samples[k] - mean)).powi(2))
                .sum::<f64>();
            count += own;
        }
        (squares, count)
    };
    let channels = record.channels.iter();
    channels
        .map(|channel| {
            let (squares, count) = of_channel(&channel.samples);
            (squares / channel.noise_std.powi(2), count)
        })
        .collect()
}

/// What the means of a record's series cost, in the units of [`cost`].
pub fn cost_of_means(record: &Record, windows: &[Window]) -> f64 {
    let channels = squares_about_means(record, windows);
    channels.iter().map(|(squares, _)| squares).sum()
}

/// Share of what the means miss that a fit must take away at least: a body of endless inertia stands still at the
/// mean, and takes nothing. A model that lacks an effect takes most.
const LEAST_TAKEN: f64 = 0.05;
/// Standard errors by which the means must miss more than noise: else there is no motion to be followed.
const MOVES: f64 = 5.0;

/// The series of those logs that the fit has failed: records that share parameters, directly or through others,
/// and together cost as much as their means do, to a twentieth. Empty where the fit beats them everywhere, and where
/// a log shows nothing but noise about its mean.
///
/// The means have no parameter of the model: whatever is then said of one is not founded on these logs.
pub fn failed_series(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: &[Vec<Window>],
    unknowns: &Unknowns,
) -> Vec<NoBetterThanMean> {
    let mut failed = vec![];
    for group in groups(records, model, unknowns) {
        let sum = |of: &dyn Fn(usize) -> f64| group.iter().map(|&at| of(at)).sum::<f64>();
        let own_cost = |at: usize| {
            let (records, windows) = (&records[at..=at], &windows[at..=at]);
            cost(records, model, values, windows)
        };
        let of_means = sum(&|at| cost_of_means(records[at], &windows[at]));
        let of_noise = sum(&|at| records[at].observations() as f64);
        let missed = of_means - of_noise;
        let moves = missed > MOVES * (2.0 * of_noise).sqrt();
        let cost = sum(&own_cost);
        let beats_them = cost <= of_means && cost - of_noise <= (1.0 - LEAST_TAKEN) * missed;
        if beats_them || (!moves && cost <= of_means + MOVES * (2.0 * of_noise).sqrt()) {
            continue;
        }
        for &at in &group {
            let record = records[at];
            let squares = squares_about_means(record, &windows[at]);
            let traces = traces(record, &windows[at], model, values);
            for ((channel, (squares, count)), trace) in
                record.channels.iter().zip(squares).zip(&traces)
            {
                let spread = channel.noise_std * (squares / count.max(1) as f64).sqrt();
                // A prediction that left the finite numbers has no error to compare.
                if trace.rmse < (1.0 - LEAST_TAKEN) * spread
                    && trace.predicted.iter().all(|value| value.is_finite())
                {
                    continue;
                }
                failed.push(NoBetterThanMean {
                    experiment: record.name.clone(),
                    output: channel.output,
                    rmse: trace.rmse,
                    spread,
                });
            }
        }
    }
    failed
}

/// Records by the free parameters that they share, directly or through others.
fn groups(records: &[&Record], model: &Model, unknowns: &Unknowns) -> Vec<Vec<usize>> {
    let mut groups: Vec<(Vec<usize>, Vec<usize>)> = vec![];
    for (at, record) in records.iter().enumerate() {
        let mut own = (vec![at], relevant(record, model, unknowns));
        let (touched, others) = groups.into_iter().partition::<Vec<_>, _>(|(_, shared)| {
            shared.iter().any(|unknown| own.1.contains(unknown))
        });
        groups = others;
        for (records, unknowns) in touched {
            own.0.extend(records);
            own.1.extend(unknowns);
        }
        groups.push(own);
    }
    let mut groups: Vec<Vec<usize>> = groups.into_iter().map(|(records, _)| records).collect();
    for group in &mut groups {
        group.sort_unstable();
    }
    groups.sort();
    groups
}
