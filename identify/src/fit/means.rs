//! A fit compared with predicting the mean of every series: a usable fit must be better than that.

use plant::{Kind, Model};

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
/// in every group, and follows every free swing ([`is_lost_swing`]). A group that shows only noise about its means does not
/// fail.
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
    let own_cost = |at: usize| {
        let (records, windows) = (&records[at..=at], &windows[at..=at]);
        cost(records, model, values, windows)
    };
    for group in groups(records, model, unknowns) {
        let sum = |of: &dyn Fn(usize) -> f64| group.iter().map(|&at| of(at)).sum::<f64>();
        let of_means = sum(&|at| cost_of_means(records[at], &windows[at]));
        let of_noise = sum(&|at| records[at].observations() as f64);
        let missed = of_means - of_noise;
        let moves = missed > MOVES * (2.0 * of_noise).sqrt();
        let cost = sum(&own_cost);
        let beats_them = cost <= of_means && cost - of_noise <= (1.0 - LEAST_TAKEN) * missed;
        if beats_them || (!moves && cost <= of_means + MOVES * (2.0 * of_noise).sqrt()) {
            // Logs in which a motor drives much outweigh a swing that lost its phase altogether.
            for &at in &group {
                let (record, windows) = (records[at], &windows[at]);
                if is_lost_swing(record, windows, own_cost(at)) {
                    let missed = no_better(record, windows, model, values);
                    let all = missed.len() == record.channels.len();
                    failed.extend(missed.into_iter().filter(|_| all));
                }
            }
            continue;
        }
        for &at in &group {
            failed.extend(no_better(records[at], &windows[at], model, values));
        }
    }
    failed
}

/// Whether a free swing is predicted no better than by its mean, at this cost: the fit has another period than the log.
///
/// A free swing is the one experiment in which nothing but the parameters of the model decides the motion, so that a swing
/// that is missed altogether leaves none of them a basis. A spin-up at a small current, or a driven log, may be missed by a
/// model that lacks dry friction and is right elsewhere.
pub(crate) fn is_lost_swing(record: &Record, windows: &[Window], own_cost: f64) -> bool {
    if record.kind != Kind::FreeSwing {
        return false;
    }
    let noise = record.observations() as f64;
    let missed = cost_of_means(record, windows) - noise;
    missed > MOVES * (2.0 * noise).sqrt() && own_cost - noise > (1.0 - LEAST_TAKEN) * missed
}

/// The series of a record that a fit predicts no better than their means.
fn no_better(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Vec<NoBetterThanMean> {
    let squares = squares_about_means(record, windows);
    let traces = traces(record, windows, model, values);
    let mut out = vec![];
    for ((channel, (squares, count)), trace) in record.channels.iter().zip(squares).zip(&traces) {
        let spread = channel.noise_std * (squares / count.max(1) as f64).sqrt();
        // A prediction that is not finite always counts as failed.
        if trace.rmse < (1.0 - LEAST_TAKEN) * spread
            && trace.predicted.iter().all(|value| value.is_finite())
        {
            continue;
        }
        out.push(NoBetterThanMean {
            experiment: record.name.clone(),
            output: channel.output,
            rmse: trace.rmse,
            spread,
        });
    }
    out
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
