//! The misfit that comes from the imperfection of the model's own dry friction.
//!
//! Every simulation lets dry friction change its sign over a small range of speeds; a real joint sticks. The
//! difference leaves a misfit that no missing effect causes, and that a wrongly added effect may absorb. To
//! find its size, measurements of the same model with a sticking joint are computed, the model is
//! fitted to them, and the error of that fit is the size.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use identify::{Effort, FitProblem, PredictedSeries, Record, refit, stuck, traces_that_count};

use plant::EffectId;

use crate::candidate::Candidate;
use crate::remainder::{remainder, residual};

/// The misfit that the smoothed sign of dry friction alone would leave.
#[derive(Clone, Debug)]
pub struct Imperfection {
    /// Root mean square misfit of every series, in units of the series' noise and in the order of
    /// [`Candidate::rmse`]. Zero for a model without dry friction.
    pub rms_over_noise: Vec<f64>,
    /// Root mean square error of the candidate in every series, in the unit of the series, after the
    /// misfit of the smoothed sign has been added to the prediction, sample by sample. It grows where the smoothed
    /// sign is not the cause of the error, because the prediction is then moved the wrong way.
    pub rmse_without: Vec<f64>,
    /// The structured remainder of every record and channel, in units of noise, with the same correction.
    pub remainders_without: Vec<Vec<f64>>,
}

/// Identifies one fit of a search: its set of effects, and the bits of its cost.
type Key = (Vec<EffectId>, u64);

/// The imperfections that a search has computed. Each one takes a fit and is needed several times.
#[derive(Debug, Default)]
pub struct Imperfections {
    found: Mutex<HashMap<Key, Arc<Imperfection>>>,
}

impl Imperfections {
    /// As [`imperfection()`], computed once for each fit of the bench.
    pub fn of(
        &self,
        problem: &FitProblem,
        records: &[&Record],
        candidate: &Candidate,
        effort: Effort,
    ) -> Arc<Imperfection> {
        let key = (candidate.set(), candidate.minimum.cost.to_bits());
        // A thread that panicked leaves no half-written entry: each entry is inserted in one step.
        let found = || self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = found().get(&key) {
            return known.clone();
        }
        // The lock is not held during the fit. Two threads may compute the same entry; the results are equal.
        let new = Arc::new(imperfection(problem, records, candidate, effort));
        found().entry(key).or_insert(new).clone()
    }
}

/// Computes the misfit that the smoothed sign of dry friction alone would leave in a candidate's fit. `effort` limits
/// the fit.
pub fn imperfection(
    problem: &FitProblem,
    records: &[&Record],
    candidate: &Candidate,
    effort: Effort,
) -> Imperfection {
    let (model, minimum) = (&candidate.model, &candidate.minimum);
    if !model.effects().iter().any(|effect| effect.info().has_kink) {
        let rmse_without = candidate.rmse();
        return Imperfection {
            rms_over_noise: vec![0.0; rmse_without.len()],
            rmse_without,
            remainders_without: candidate.remainders.clone(),
        };
    }
    let sticking: Vec<Record> = records
        .iter()
        .zip(&minimum.windows)
        .zip(&candidate.traces)
        .map(|((record, windows), traces)| {
            let changes = stuck(record, windows, model, &minimum.values);
            let mut sticking = (*record).clone();
            for ((channel, trace), changes) in
                sticking.channels.iter_mut().zip(traces).zip(&changes)
            {
                for ((sample, predicted), change) in channel
                    .samples
                    .iter_mut()
                    .zip(&trace.predicted)
                    .zip(changes)
                {
                    // A missing sample stays missing.
                    if sample.is_finite() {
                        *sample = predicted + change * channel.noise_std;
                    }
                }
            }
            sticking
        })
        .collect();
    let sticking: Vec<&Record> = sticking.iter().collect();
    let again = refit(
        &sticking,
        model,
        minimum.values.clone(),
        minimum.windows.clone(),
        &problem.free(model),
        effort,
    );
    let mut found = Imperfection {
        rms_over_noise: vec![],
        rmse_without: vec![],
        remainders_without: vec![],
    };
    for (index, (sticking, windows)) in sticking.iter().zip(&again.windows).enumerate() {
        let record = records[index];
        let mut remainders = vec![];
        let fitted = traces_that_count(sticking, windows, model, &again.values);
        for (channel, fitted) in fitted.iter().enumerate() {
            let sticks = &sticking.channels[channel];
            let left = residual(&sticks.samples, &fitted.predicted);
            let own = &candidate.traces[index][channel].predicted;
            let predicted: Vec<f64> = own
                .iter()
                .zip(&left)
                .map(|(own, left)| own + left)
                .collect();
            let channel = &record.channels[channel];
            found.rms_over_noise.push(fitted.rmse / sticks.noise_std);
            remainders.push(remainder(channel, &predicted, &record.weight));
            let without = PredictedSeries::new(channel, predicted, &record.weight);
            found.rmse_without.push(without.rmse);
        }
        found.remainders_without.push(remainders);
    }
    found
}
