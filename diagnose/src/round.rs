//! One round of trials: a score test of every suspect, then a fit of the most promising ones.

use identify::{Cancelled, KnownScore, Unknowns, acts, ratios, score_test};
use parallel::{parallel_map, parallel_pair};
use plant::{EffectId, StartFrom};

use crate::applicable::{applicable, completes_series};
use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::economy::{LARGE_ZERO_RAD, LEAST_SHARE, MOST_FITS, SIMPLER_SHARE};
use crate::score::{Start, absent_starts, is_scored_where_absent, starts, zero_start};
use crate::trial::{Goal, added, fit_all_roughly, fit_all_wholly, is_refinement};

/// The settings of a round of trials.
pub struct Round<'a> {
    /// Largest number of suspects that are fitted.
    pub most: usize,
    /// Whether a set of effects has a converged fit already and needs no other.
    pub is_fitted: &'a (dyn Fn(&[EffectId]) -> bool + Sync),
    /// The candidate that leaves no remainder, if there is one. A new fit is pursued only if it can compete with it.
    pub leader: Option<&'a Candidate>,
    /// Whether to try only effects that act in an experiment with a remainder.
    pub only_where_something_remains: bool,
}

/// Tries every applicable effect on top of `from`: a score test for each, and a full fit for those that promise
/// enough and whose set of effects is not fitted yet.
///
/// # Errors
/// [`Cancelled`] if the work is called off.
pub fn try_all(
    bench: &SearchBench,
    from: &Candidate,
    round: &Round,
) -> Result<Vec<Candidate>, Cancelled> {
    bench.check()?;
    let thresholds = bench.thresholds;
    let shows_where_something_remains = |effect: EffectId| {
        let remainders = bench.records.iter().zip(&from.remainders);
        remainders
            .filter(|(record, _)| acts(effect, record.kind))
            .any(|(_, remainders)| {
                remainders
                    .iter()
                    .any(|&left| left >= thresholds.least_trace)
            })
    };
    let suspects: Vec<EffectId> = bench
        .suspects
        .iter()
        .copied()
        .filter(|&effect| {
            from.model.with(effect) != from.model && applicable(bench.problem, effect)
        })
        .filter(|&effect| !completes_series(&from.model, effect))
        .filter(|&effect| {
            !round.only_where_something_remains || shows_where_something_remains(effect)
        })
        .collect();
    let fitted = |effect: EffectId| {
        let mut set = added(from, &from.model.with(effect), effect);
        set.sort();
        (round.is_fitted)(&set)
    };
    // A refinement is tried on top of the fit of the suspect that it refines: far from that fit its score says
    // nothing.
    let (refinements, suspects): (Vec<EffectId>, Vec<EffectId>) =
        suspects.iter().partition(|&&effect| {
            let replaces = effect.info().replaces;
            // Zeros of opposite signs leave nothing to a common one: they are tried at once.
            let is_first = |simpler: &&EffectId| {
                replaces.contains(&simpler.name()) && effect.info().per_log.is_none()
            };
            suspects
                .iter()
                .filter(is_first)
                .any(|&simpler| !fitted(simpler))
        });
    let point = from.point();
    let angle_zero_rad = ratios(&bench.records).angle_zero_rad.unwrap_or(0.0);
    // A cable's parameters change together with those of the effect, so that every effect then needs its own
    // simulation.
    let has_product = |one: &EffectId| one.info().product.is_some();
    let has_cable = from.model.effects().iter().any(has_product);
    let (absent, others): (Vec<EffectId>, Vec<EffectId>) = suspects
        .into_iter()
        .partition(|&effect| is_scored_where_absent(effect) && !has_cable);
    let unknowns = Unknowns::new(&from.model, &bench.problem.free(&from.model));
    let known = KnownScore {
        model: &from.model,
        values: &point.values,
        unknowns: &unknowns,
        score_test: &score_test(
            &bench.records,
            &from.model,
            &point.values,
            &point.windows,
            &unknowns,
            None,
        ),
        leaves_no_trace: &|_| false,
    };
    let (scored, others) = parallel_pair(
        || absent_starts(bench, from, point, known, &absent),
        || -> Vec<Vec<Start>> {
            parallel_map(&others, |&effect| {
                starts(bench, &from.minimum, point, known, effect)
            })
        },
    );
    let mut screened: Vec<(f64, Vec<Start>)> = scored
        .into_iter()
        .map(|start| {
            let is_zero = matches!(start.effect.info().start_from, StartFrom::AngleZero);
            let zero = (is_zero && angle_zero_rad.abs() > LARGE_ZERO_RAD)
                .then(|| zero_start(bench, point, &start, angle_zero_rad));
            [start].into_iter().chain(zero).collect()
        })
        .chain(others)
        .map(|starts| {
            let best = starts
                .iter()
                .map(|start| start.promised_cost)
                .fold(f64::INFINITY, f64::min);
            (point.cost - best, starts)
        })
        .collect();
    // Where two suspects promise about the same gain and one contains the other, the simpler one is tried first,
    // and the larger one on top of it in the next round.
    let gains: Vec<(EffectId, f64)> = screened
        .iter()
        .filter_map(|(gain, starts)| Some((starts.first()?.effect, *gain)))
        .collect();
    screened.retain(|(own, starts)| {
        starts.first().is_some_and(|start| {
            !start.effect.info().replaces.iter().any(|contained| {
                gains.iter().any(|(effect, gain)| {
                    effect.name() == *contained
                        && *gain > thresholds.least_gain
                        && *gain > SIMPLER_SHARE * own
                })
            })
        })
    });
    // χ² beyond the noise, summed over the experiments in which the effect acts.
    let missed = |effect: EffectId| -> f64 {
        let records = bench.records.iter().zip(&known.score_test.records);
        records
            .filter(|(record, _)| acts(effect, record.kind))
            .map(|(record, share)| (share.cost - record.observations() as f64).max(0.0))
            .sum()
    };
    screened.retain(|(gain, starts)| {
        let least = |start: &Start| thresholds.least_part * missed(start.effect);
        starts.first().is_some_and(|start| *gain >= least(start))
    });
    screened.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A refinement that is fitted already replaces a term. Its gain is no measure for effects that act beside
    // that term.
    let is_fitted = |starts: &[Start]| starts.first().is_some_and(|start| fitted(start.effect));
    screened.retain(|(_, starts)| {
        let is_refinement = starts
            .first()
            .is_some_and(|start| added(from, &start.model, start.effect).len() == from.added.len());
        !(is_refinement && is_fitted(starts))
    });
    let best_gain = screened.first().map_or(0.0, |(gain, _)| *gain);
    // A refinement whose simpler effect promises nothing by itself has no fit to start from: in a single spin-up, the
    // constant part of a friction is the same as a larger inertia, and only its fall while the wheel starts is seen.
    let promises = |name: &&str| {
        gains
            .iter()
            .any(|(effect, gain)| effect.name() == *name && *gain > bench.least_gain)
    };
    let (refinements, by_themselves): (Vec<EffectId>, Vec<EffectId>) = refinements
        .into_iter()
        .filter(|&effect| !fitted(effect))
        .partition(|effect| effect.info().replaces.iter().any(&promises));
    let mut chosen = screened;
    chosen.extend(parallel_map(&by_themselves, |&effect| {
        let starts = starts(bench, &from.minimum, point, known, effect);
        let promised = starts.iter().map(|start| start.promised_cost);
        (point.cost - promised.fold(f64::INFINITY, f64::min), starts)
    }));
    chosen.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A suspect that promises little beside the best is fitted all the same if another one refines it, which has no score
    // of its own here: presliding friction is a spring where the swing is small, which dry friction without it is not.
    let is_refined = |starts: &[Start]| {
        let name = starts.first().map(|start| start.effect.name());
        let mut replaced = refinements.iter().flat_map(|one| one.info().replaces);
        replaced.any(|replaced| Some(*replaced) == name)
    };
    let most = round.most.min(MOST_FITS);
    let mut rank = 0;
    chosen.retain(|(gain, starts)| {
        rank += 1;
        let is_promising = rank <= most && *gain > LEAST_SHARE * best_gain;
        *gain > bench.least_gain && (is_promising || is_refined(starts))
    });
    chosen.retain(|(_, starts)| !is_fitted(starts));
    // Simple effects come first: they are fitted fast, and a later suspect need not be fitted from a start that
    // promises no more than they have reached.
    chosen.sort_by_key(|(_, starts)| starts.first().is_some_and(is_refinement));
    let goal = round
        .leader
        .map_or(Goal::ANY, |leader| Goal::beside(from, leader));
    let chosen = chosen.into_iter().map(|(_, starts)| starts).collect();
    let least_gain =
        |effect: EffectId| bench.least_gain.max(thresholds.least_part * missed(effect));
    let roughs = fit_all_roughly(bench, from, chosen, &refinements, &least_gain, goal)?;
    fit_all_wholly(bench, from, roughs, goal)
}
