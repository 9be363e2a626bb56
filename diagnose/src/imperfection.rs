//! What the imperfection of a model's own terms leaves in every series.
//!
//! Dry friction changes its sign over a small speed in every simulation; a real joint sticks. The
//! difference is a misfit that no missing effect causes, and that a further effect may take up. Its
//! size is what would remain if the measurements were those of this very model with a joint that
//! sticks: they are computed, the model is fitted to them, and the error of the fit is taken.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use identify::{Effort, FitProblem, PredictedSeries, Record, refit, stuck, traces};

use plant::EffectId;

use crate::candidate::Candidate;
use crate::remainder::{remainder, residual};

/// What the smoothed sign of dry friction alone would leave.
#[derive(Clone, Debug)]
pub struct Imperfection {
    /// The error of every series, in units of its noise and in the order of [`Candidate::rmse`]; zeros for
    /// a model without dry friction.
    pub rms_over_noise: Vec<f64>,
    /// Root mean square errors of the candidate itself, in the unit of each series, without what the smoothed
    /// sign leaves in them: sample by sample, so that they are larger than its own errors where that is not
    /// what they are made of.
    pub rmse_without: Vec<f64>,
    /// The structured remainder of every record and channel in units of noise, likewise.
    pub remainders_without: Vec<Vec<f64>>,
}

/// A fit among all that a search makes of one bench: its set of effects, and its cost to the last bit.
type Key = (Vec<EffectId>, u64);

/// The imperfections that a search has worked out: each takes a fit, and is asked for several times.
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
        // What a thread that panicked has left is whole: entries are put in at once.
        let found = || self.found.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = found().get(&key) {
            return known.clone();
        }
        // Not under the lock: two threads at worst work out the same.
        let new = Arc::new(imperfection(problem, records, candidate, effort));
        found().entry(key).or_insert(new).clone()
    }
}

/// What the smoothed sign of dry friction alone would leave of a candidate; `effort` is that of the fit.
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
                    // What was not measured stays unmeasured.
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
        let fitted = traces(sticking, windows, model, &again.values);
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
