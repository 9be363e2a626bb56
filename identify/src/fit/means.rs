//! A fit compared with predicting the mean of every series: a usable fit must be better than that.

use plant::Model;

use super::comparison::traces;
use super::solver::cost;
use super::unknowns::{Unknowns, Window, relevant};
use crate::records::{Output, Record};

/// A series that a fit predicts no better, or hardly better, than its mean does.
#[derive(Clone, Debug, PartialEq)]
pub struct NoBetterThanMean {
    /// The experiment's name.
    pub experiment: String,
    /// The measured output.
    pub output: Output,
    /// Root mean square of measured minus predicted, in the unit of the output.
    pub rmse: f64,
    /// Root mean square of measured minus its mean (the mean of each window, if the log is compared in windows), same unit.
    pub spread: f64,
}

/// Squared normalised deviations of each channel of a record from its mean over every window, with the number of
/// samples: the cost of a prediction without any motion.
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

/// The cost of predicting every series of a record by its mean, in the units of [`cost`].
pub fn cost_of_means(record: &Record, windows: &[Window]) -> f64 {
    let channels = squares_about_means(record, windows);
    channels.iter().map(|(squares, _)| squares).sum()
}

/// Smallest share of the squares about the mean (beyond the noise) that a fit must explain. A body of infinite inertia
/// stays at the mean and explains nothing. A model that lacks one effect explains most.
const LEAST_TAKEN: f64 = 0.05;
/// Standard errors by which the squares about the mean must exceed those of noise; otherwise there is no motion to be
/// predicted.
const MOVES: f64 = 5.0;

/// The series of the logs that the fit fails to predict. Records that share parameters, directly or through others,
/// form a group; a group fails if its cost is within a twentieth of the cost of the means. Empty if the fit is better
/// in every group. A group that shows only noise about its means does not fail.
///
/// The means use no parameter of the model. A parameter that comes from a failed group has no basis in the logs.
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
                // A prediction that is not finite always counts as failed.
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

/// Groups of records that share free parameters, directly or through others.
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
