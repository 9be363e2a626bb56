//! How well a model predicts an experiment that was left out of its fit.
//!
//! Each experiment is left out in turn. One Newton step on the normal equations without that experiment's share
//! gives the parameters that the other experiments alone would give. Then only the start of the left-out motion is
//! fitted, since nobody knows it beforehand. An experiment that alone determines a parameter cannot be predicted
//! from the others and is skipped. If no experiment can be left out, each log is split in time: the
//! first halves predict the second halves.

use identify::{
    Effort, Minimum, Output, Record, Unknowns, final_windows, minimise, pseudo_inverse, score_test,
    traces_that_count,
};
use plant::Model;

use crate::bench::SearchBench;

/// The other experiments determine a parameter if they hold at least this share of the Fisher information on it.
const LEAST_INFORMATION: f64 = 1e-2;

/// A held-out series, compared with its prediction.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// The experiment's name.
    pub experiment: String,
    /// The channel.
    pub output: Output,
    /// Root mean square of measured − predicted in the unit of the channel.
    pub rmse: f64,
    /// Standard deviation of the sensor's noise, same unit.
    pub noise_std: f64,
    /// Number of samples.
    pub samples: usize,
    /// Fit in percent: 100 (1 − ‖y − ŷ‖/‖y − mean y‖), with y measured and ŷ predicted.
    pub fit_percent: f64,
}

/// Which data are held out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// Whole experiments, each predicted by the others.
    Experiments,
    /// The second half of every log, predicted by the first halves.
    SecondHalves,
}

/// Predicts every held-out series that varies by more than its noise, and says which data are held out. Empty if
/// nothing can be held out.
pub fn held_out(bench: &SearchBench, model: &Model, minimum: &Minimum) -> (Unseen, Vec<HeldOut>) {
    let series = by_experiment(bench, model, minimum);
    if series.is_empty() {
        (Unseen::SecondHalves, by_halves(bench, model, minimum))
    } else {
        (Unseen::Experiments, series)
    }
}

/// Whether a step makes the held-out prediction plainly worse: the sum of squared errors, in units of noise, over the
/// series that both models predict grows by more than 1 %. Noise alone changes a sum over n samples by a share of
/// √(2/n), which is 1 % at 20,000 samples; where a misfit adds to the noise, by a smaller share.
pub fn is_worse(before: &[HeldOut], after: &[HeldOut]) -> bool {
    let pairs = before.iter().filter_map(|old| {
        let is_same = |new: &&HeldOut| new.experiment == old.experiment && new.output == old.output;
        after.iter().find(is_same).map(|new| (old, new))
    });
    let (mut old_cost, mut new_cost) = (0.0, 0.0);
    for (old, new) in pairs {
        old_cost += (old.rmse / old.noise_std).powi(2) * old.samples as f64;
        new_cost += (new.rmse / new.noise_std).powi(2) * new.samples as f64;
    }
    new_cost > 1.01 * old_cost
}

/// Mean of `fit_percent` over held-out series; NaN if there are none.
pub fn mean_fit_percent(series: &[HeldOut]) -> f64 {
    if series.is_empty() {
        return f64::NAN;
    }
    series.iter().map(|one| one.fit_percent).sum::<f64>() / series.len() as f64
}

/// Predicts the channels of a record with given parameters; only the start of the motion is fitted, with `effort`.
fn predicted(
    record: &Record,
    model: &Model,
    values: &[f64],
    windows: Vec<identify::Window>,
    effort: Effort,
) -> Vec<HeldOut> {
    let unknowns = Unknowns::new(model, &[]);
    let minimum = minimise(
        &[record],
        model,
        values.to_vec(),
        vec![windows],
        &unknowns,
        effort,
    );
    traces_that_count(record, &minimum.windows[0], model, values)
        .iter()
        .zip(&record.channels)
        .filter(|(_, channel)| moves(channel))
        .map(|(trace, channel)| HeldOut {
            experiment: record.name.clone(),
            output: channel.output,
            rmse: trace.rmse,
            noise_std: channel.noise_std,
            samples: channel.samples.len(),
            fit_percent: trace.fit_percent,
        })
        .collect()
}

/// Whether a channel varies by more than its noise. The fit percentage divides by the variation.
fn moves(channel: &identify::RecordedChannel) -> bool {
    let finite = channel.samples.iter().filter(|sample| sample.is_finite());
    let n = finite.clone().count().max(1) as f64;
    let mean = finite.clone().sum::<f64>() / n;
    let variance = finite.map(|sample| (sample - mean).powi(2)).sum::<f64>() / n;
    variance > (3.0 * channel.noise_std).powi(2)
}

/// Whether a parameter belongs to one log.
fn is_of_one_log(model: &Model, position: usize) -> bool {
    let effect = model.effect_at(position);
    effect.is_some_and(|effect| effect.info().per_log.is_some())
}

fn by_experiment(bench: &SearchBench, model: &Model, minimum: &Minimum) -> Vec<HeldOut> {
    let effort = bench.until_called_off(Effort::ROUGH);
    let unknowns = Unknowns::new(model, &bench.problem.free(model));
    let whole = score_test(
        &bench.records,
        model,
        &minimum.values,
        &minimum.windows,
        &unknowns,
        None,
    );
    let count = unknowns.free.len();
    let information = whole.information();
    let gradient = whole.gradient();
    let mut series = vec![];
    for (index, record) in bench.records.iter().enumerate() {
        let others = &information - &whole.records[index].information;
        let own = &whole.records[index].information;
        // What is of this log alone is fitted to it like its start.
        let held: Vec<bool> = (0..count)
            .map(|at| minimum.on_bound[at] || is_of_one_log(model, unknowns.free[at]))
            .collect();
        let determined = (0..count).all(|at| {
            own[(at, at)] <= 0.0
                || held[at]
                || others[(at, at)] > LEAST_INFORMATION * information[(at, at)]
        });
        if !determined {
            continue;
        }
        let Some(inverse) = pseudo_inverse(&others, &held) else {
            continue;
        };
        let step = inverse * (&gradient - &whole.records[index].gradient);
        let mut values = minimum.values.clone();
        for (at, &position) in unknowns.free.iter().enumerate() {
            let (low, high) = unknowns.bounds[at];
            let next = if unknowns.logarithmic[at] {
                values[position] * step[at].clamp(-1.0, 1.0).exp()
            } else {
                values[position] + step[at]
            };
            values[position] = next.clamp(low, high);
        }
        series.extend(predicted(
            record,
            model,
            &values,
            minimum.windows[index].clone(),
            effort,
        ));
    }
    series
}

fn by_halves(bench: &SearchBench, model: &Model, minimum: &Minimum) -> Vec<HeldOut> {
    let mut series = vec![];
    let halves: Vec<(Record, Record)> = bench
        .records
        .iter()
        .filter(|record| record.len() >= 40)
        .map(|record| {
            let middle = record.len() / 2;
            (record.slice(0..middle), record.slice(middle..record.len()))
        })
        .collect();
    let first: Vec<&Record> = halves.iter().map(|(first, _)| first).collect();
    if first.is_empty() {
        return series;
    }
    let windows = first
        .iter()
        .map(|record| final_windows(record, &minimum.values))
        .collect();
    let effort = bench.until_called_off(Effort::ROUGH);
    let unknowns = Unknowns::new(model, &bench.problem.free(model));
    let fitted = minimise(
        &first,
        model,
        minimum.values.clone(),
        windows,
        &unknowns,
        effort,
    );
    for (_, second) in &halves {
        let windows = final_windows(second, &fitted.values);
        series.extend(predicted(second, model, &fitted.values, windows, effort));
    }
    series
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(experiment: &str, rmse: f64) -> HeldOut {
        HeldOut {
            experiment: experiment.to_owned(),
            output: Output::Angle,
            rmse,
            noise_std: 1.0,
            samples: 100,
            fit_percent: 0.0,
        }
    }

    #[test]
    fn prediction_is_worse_where_the_squares_grow_in_sum() {
        let before = [series("a", 3.0), series("b", 1.0)];
        assert!(!is_worse(&before, &[series("a", 2.0), series("b", 1.5)]));
        assert!(is_worse(&before, &[series("a", 3.0), series("b", 1.5)]));
        // What only one of them predicts does not count.
        assert!(!is_worse(&before, &[series("a", 3.0), series("c", 9.0)]));
        assert!(!is_worse(&before, &before));
    }
}
