//! Whether a driven log must be read in short windows because cogging, a torque that varies with the wheel's angle,
//! makes it unpredictable in one piece (see [`FitProblem::in_windows`]).

use identify::{
    Effort, FitProblem, Record, Window, carry_over, cogging_promise, extend, joined, refit,
};
use plant::{EffectId, Model};

use crate::candidate::Candidate;
use crate::economy::{MISSED_STD, PROMISED_SHARE};
use crate::thresholds::Thresholds;

/// Whether, in short windows (`cut`), a cogging effect explains most of the misfit that `best` leaves without it.
/// `effort` limits the fits, which begin only where cogging promises enough ([`promises_much`]).
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
    let records = cut.all_records();
    let mut ripples = ripples.into_iter();
    ripples.any(|ripple| {
        let plain = without(&records, best, ripple);
        promises_much(&records, &plain, thresholds)
            && takes_most(cut, &plain, ripple, thresholds, effort)
    })
}

/// A model without cogging, its parameters in SI units and its windows, before any fit.
struct Plain {
    model: Model,
    values: Vec<f64>,
    windows: Vec<Vec<Window>>,
}

fn without(records: &[&Record], best: &Candidate, ripple: EffectId) -> Plain {
    let model = best.model.without(ripple);
    let start = vec![0.0; model.parameter_count()];
    let values = carry_over(&best.model, &best.minimum.values, &model, &start);
    let windows = joined(records, &values, &best.minimum.windows);
    Plain {
        model,
        values,
        windows,
    }
}

/// Whether the model leaves more than noise in short windows, and cogging promises a large part of it.
fn promises_much(records: &[&Record], plain: &Plain, thresholds: &Thresholds) -> bool {
    let promise = cogging_promise(records, &plain.model, &plain.values, &plain.windows);
    let asked = PROMISED_SHARE * thresholds.cogging_share * promise.missed;
    promise.missed > MISSED_STD * promise.missed_std
        && promise.gain > thresholds.least_gain.max(asked)
}

fn takes_most(
    cut: &FitProblem,
    plain: &Plain,
    ripple: EffectId,
    thresholds: &Thresholds,
    effort: Effort,
) -> bool {
    let records = cut.all_records();
    let (model, values, windows) = (&plain.model, plain.values.clone(), plain.windows.clone());
    let free = cut.free(model);
    let without = refit(&records, model, values, windows, &free, effort);
    let with = extend(cut, &records, model, &without, &model.with(ripple), effort);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let missed = without.cost - observations as f64;
    let least = thresholds.least_gain.max(thresholds.cogging_share * missed);
    without.cost - with.cost > least
}
