//! Whether a driven log must be read in short windows because cogging, a torque that varies with the wheel's angle,
//! makes it unpredictable in one piece (see [`FitProblem::in_windows`]).

use identify::{Effort, FitProblem, carry_over, extend, joined, refit};
use plant::EffectId;

use crate::candidate::Candidate;
use crate::thresholds::Thresholds;

/// Whether, in short windows (`cut`), a cogging effect explains most of the misfit that `best` leaves without it.
/// `effort` limits the fits.
pub fn shows_in_short_windows(
    cut: &FitProblem,
    best: &Candidate,
    suspects: &[EffectId],
    thresholds: &Thresholds,
    effort: Effort,
) -> bool {
    let mut ripples: Vec<EffectId> = suspects.to_vec();
    ripples.extend(best.model.effects());
    ripples.retain(|effect| effect.info().ripple.is_some());
    ripples.sort();
    ripples.dedup();
    let mut ripples = ripples.into_iter();
    ripples.any(|ripple| takes_most(cut, best, ripple, thresholds, effort))
}

fn takes_most(
    cut: &FitProblem,
    best: &Candidate,
    ripple: EffectId,
    thresholds: &Thresholds,
    effort: Effort,
) -> bool {
    let records = cut.all_records();
    let plain = best.model.without(ripple);
    let start = vec![0.0; plain.parameter_count()];
    let values = carry_over(&best.model, &best.minimum.values, &plain, &start);
    let windows = joined(&records, &values, &best.minimum.windows);
    let free = cut.free(&plain);
    let without = refit(&records, &plain, values, windows, &free, effort);
    let with = extend(cut, &records, &plain, &without, &plain.with(ripple), effort);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let missed = without.cost - observations as f64;
    let least = thresholds.least_gain.max(thresholds.cogging_share * missed);
    without.cost - with.cost > least
}
