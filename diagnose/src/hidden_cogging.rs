//! Whether a driven log must be read in short windows, because cogging has made it unpredictable in one
//! piece (see [`Setup::in_windows`]).

use identify::{Effort, Setup, carry_over, extend, joined, refit};
use plant::EffectId;

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
    let plain = best.model.without(cogging);
    let start = vec![0.0; plain.parameter_count()];
    let values = carry_over(&best.model, &best.minimum.values, &plain, &start);
    let windows = joined(&records, &values, &best.minimum.windows);
    let free = cut.free(&plain);
    let without = refit(&records, &plain, values, windows, &free, Effort::FULL);
    let with = extend(cut, &records, &plain, &without, &plain.with(cogging));
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    without.cost - with.cost > LEAST_GAIN.max(COGGING_SHARE * (without.cost - observations as f64))
}
