//! What the imperfection of a model's own terms leaves in every series.
//!
//! Dry friction changes its sign over a small speed in every simulation; a real joint sticks. The
//! difference is a misfit that no missing effect causes, and that a further effect may take up. Its
//! size is what would remain if the measurements were those of this very model with a joint that
//! sticks: they are computed, the model is fitted to them, and the error of the fit is taken.

use identify::{Effort, Record, Setup, refit, stuck, traces};

use crate::candidate::Candidate;

/// The error of every series, in units of its noise and in the order of [`Candidate::rmse`], that
/// the smoothed sign of dry friction alone would leave; zeros for a model without dry friction.
pub fn imperfection(setup: &Setup, records: &[&Record], candidate: &Candidate) -> Vec<f64> {
    let (model, minimum) = (&candidate.model, &candidate.minimum);
    let series = records.iter().map(|record| record.channels.len()).sum();
    if !model.effects().iter().any(|effect| effect.info().has_kink) {
        return vec![0.0; series];
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
        &setup.free(model),
        Effort::ROUGH,
    );
    sticking
        .iter()
        .zip(&again.windows)
        .flat_map(|(record, windows)| {
            let left = traces(record, windows, model, &again.values);
            let noise = record.channels.iter().map(|channel| channel.noise_std);
            left.into_iter()
                .zip(noise)
                .map(|(trace, noise)| trace.rmse / noise)
                .collect::<Vec<f64>>()
        })
        .collect()
}
