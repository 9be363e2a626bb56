//! Whether a driven log must be read in short windows, because cogging has made it unpredictable in one
//! piece (see [`Setup::in_windows`]).

use identify::{Effort, Minimum, Setup, Window, carry_over, cogging_start, joined, refit};
use plant::{EffectId, Model};

use crate::candidate::Candidate;
use crate::suspects::LEAST_GAIN;

/// Share of what a model misses that cogging must take over short windows, for the logs to be read in
/// them: beside a larger effect it is found once that has been added.
const COGGING_SHARE: f64 = 0.5;

/// Whether cogging takes most of what `best` misses without it, where driven logs are compared over short
/// windows.
pub fn shows_cogging(cut: &Setup, best: &Candidate, suspects: &[EffectId]) -> bool {
    let cogging = EffectId::WheelCogging;
    if !suspects.contains(&cogging) && !best.model.has(cogging) {
        return false;
    }
    let records = cut.all_records();
    let fit = |model: &Model, values: Vec<f64>, windows: &[Vec<Window>]| -> Minimum {
        let windows = records.iter().zip(windows);
        let windows = windows
            .map(|(record, shorter)| joined(record, &values, shorter))
            .collect();
        let free = cut.free(model);
        refit(&records, model, values, windows, &free, Effort::FULL)
    };
    let plain = best.model.without(cogging);
    let minimum = &best.minimum;
    let start = vec![0.0; plain.parameter_count()];
    let values = carry_over(&best.model, &minimum.values, &plain, &start);
    let without = fit(&plain, values, &minimum.windows);
    let Some(own) = cogging_start(&records, &plain, &without) else {
        return false;
    };
    let larger = plain.with(cogging);
    let mut start = vec![0.0; larger.parameter_count()];
    if let Some(at) = larger.position(cogging) {
        start[at..at + own.parameters.len()].copy_from_slice(&own.parameters);
    }
    let values = carry_over(&plain, &without.values, &larger, &start);
    let with = fit(&larger, values, &without.windows);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    without.cost - with.cost > LEAST_GAIN.max(COGGING_SHARE * (without.cost - observations as f64))
}
