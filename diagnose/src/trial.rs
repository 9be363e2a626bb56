//! The fits of single effects on top of a candidate: first in the windows of the score test, then over the
//! whole logs.

use identify::{
    Cancelled, Effort, Minimum, Window, carry_over, cost, fit_from_scratch, joined, refit,
};
use plant::{EffectId, Model};

use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::economy::{KEPT_SHARE, LEAST_SHARE, MOST_STARTS, MUCH, STILL_MISSES};
use crate::score::{Start, refined_starts};

/// The added effects of `model`, which came from `from` by adding `effect` (and may have lost an effect that
/// `effect` replaces).
pub fn added(from: &Candidate, model: &Model, effect: EffectId) -> Vec<EffectId> {
    let mut added = from.added.clone();
    added.retain(|present| model.has(*present));
    added.push(effect);
    added
}

/// The costs (χ²) below which a fit on top of a candidate is of interest. Once another fit leaves nothing but
/// noise, a competing explanation must remove nearly as much of the misfit.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// The limit in the windows of the score test.
    windows: f64,
    /// The limit over the whole logs.
    pub whole: f64,
}

impl Goal {
    /// No limit: every fit is of interest.
    pub const ANY: Goal = Goal {
        windows: f64::INFINITY,
        whole: f64::INFINITY,
    };

    /// The limits for fits on top of `from` that compete with a `leader` that leaves no remainder.
    pub fn beside(from: &Candidate, leader: &Candidate) -> Goal {
        Goal {
            windows: within_reach(from.point().cost, leader.point().cost),
            whole: within_reach(from.minimum.cost, leader.minimum.cost),
        }
    }
}

/// The cost that is reached after [`KEPT_SHARE`] of the way from the cost `from` to the cost `leader`.
fn within_reach(from: f64, leader: f64) -> f64 {
    from - KEPT_SHARE * (from - leader)
}

/// A fit in the windows of the score test, with its starting point.
#[derive(Clone, Debug)]
pub struct Rough {
    /// The fit.
    minimum: Minimum,
    /// The starting point.
    start: Start,
}

/// Fits an effect on top of `point` in the windows of the score test, from the most promising starting points.
/// `None` if the gain is too small: a fit with the effect at zero is that of the smaller model.
fn fit_roughly(
    bench: &SearchBench,
    point: &Minimum,
    mut starts: Vec<Start>,
    goal: f64,
) -> Result<Option<Rough>, Cancelled> {
    starts.sort_by(|a, b| a.promised_cost.total_cmp(&b.promised_cost));
    let effort = if bench.window_s.is_some() {
        Effort::SCORE
    } else {
        Effort::ROUGH
    };
    let effort = bench.until_called_off(effort);
    let mut best: Option<Rough> = None;
    for start in starts.into_iter().take(MOST_STARTS) {
        // A start that promises hardly more than what has been reached is skipped.
        let promised = KEPT_SHARE * (point.cost - start.promised_cost);
        if best.as_ref().is_some_and(|best| {
            point.cost - best.minimum.cost >= promised && !has_strayed(bench, best)
        }) {
            continue;
        }
        bench.check()?;
        let minimum = refit(
            &bench.records,
            &start.model,
            start.values.clone(),
            start.windows.as_ref().unwrap_or(&point.windows).clone(),
            &bench.problem.free(&start.model),
            effort.towards(goal),
        );
        bench.check()?;
        if best
            .as_ref()
            .is_none_or(|best| minimum.cost < best.minimum.cost)
        {
            best = Some(Rough { minimum, start });
        }
    }
    Ok(best.filter(|rough| point.cost - rough.minimum.cost >= bench.least_gain))
}

/// Whether a fit ended on a bound of one of the effect's own parameters and still misses something. Another
/// starting point may then lead to a meaningful minimum.
fn has_strayed(bench: &SearchBench, rough: &Rough) -> bool {
    let (start, minimum) = (&rough.start, &rough.minimum);
    let Some(at) = start.model.position(start.effect) else {
        return false;
    };
    let own = start.effect.info().parameters.iter();
    let is_at_end = own.zip(&minimum.values[at..]).any(|(info, value)| {
        let (low, high) = info.bounds;
        *value <= low || *value >= high
    });
    is_at_end && minimum.cost > STILL_MISSES * bench.noise_cost()
}

/// The parameters and windows from which the whole logs are fitted. Two starting points are compared, and the one
/// with the lower cost is taken: the fit in short windows, and the smaller model's fit over the whole logs
/// with the new effect's parameters. The two are far apart where the free run drifts away.
fn whole_start(
    bench: &SearchBench,
    from: &Candidate,
    rough: &Minimum,
    start: &Start,
) -> (Vec<f64>, Vec<Vec<Window>>) {
    let records = &bench.records;
    let windows = joined(records, &rough.values, &rough.windows);
    if bench.window_s.is_none() {
        return (rough.values.clone(), windows);
    }
    let values = carry_over(
        &from.model,
        &from.minimum.values,
        &start.model,
        &rough.values,
    );
    let of = |values: &[f64], windows: &[Vec<Window>]| cost(records, &start.model, values, windows);
    if of(&values, &from.minimum.windows) < of(&rough.values, &windows) {
        (values, from.minimum.windows.clone())
    } else {
        (rough.values.clone(), windows)
    }
}

/// Fits an effect over the whole logs, after [`fit_roughly`].
fn fit_whole(
    bench: &SearchBench,
    from: &Candidate,
    rough: Rough,
    goal: Goal,
) -> Result<Candidate, Cancelled> {
    bench.check()?;
    let (problem, records) = (bench.problem, &bench.records);
    let point = from.point();
    let Rough {
        minimum: rough,
        start,
    } = rough;
    let free = problem.free(&start.model);
    let full = bench.until_called_off(Effort::FULL);
    let effort = full.towards(goal.whole);
    let (values, windows) = whole_start(bench, from, &rough, &start);
    let mut minimum = refit(records, &start.model, values, windows, &free, effort);
    // A large gain in short windows without any gain over the whole logs: fit again from scratch. A user's effect may
    // be narrow, so that the cost over whole logs has many minima: any of them that leaves much more than the short
    // windows do is the wrong one.
    let brings_much = point.cost - rough.cost > MUCH * point.cost;
    let misses = |cost: f64| cost > STILL_MISSES * bench.noise_cost();
    let is_own = matches!(start.effect, EffectId::External(_));
    let is_wrong = is_own && misses(minimum.cost) && !misses(rough.cost);
    let is_lost = minimum.cost > from.minimum.cost || is_wrong;
    if is_lost && brings_much && rough.cost <= goal.windows {
        bench.check()?;
        let again = fit_from_scratch(records, &start.model, rough.values.clone(), &free, full);
        if again.cost < minimum.cost {
            minimum = again;
        }
    }
    // A larger model never fits worse than one that it contains: where the effect can be absent,
    // the smaller model's minimum is one of its points.
    if minimum.cost > from.minimum.cost
        && let (Some(absent), Some(at)) = (
            start.effect.info().absent,
            start.model.position(start.effect),
        )
        && start.effect.info().replaces.is_empty()
    {
        let mut values = start.values.clone();
        values[at..at + absent.len()].copy_from_slice(absent);
        let windows = from.minimum.windows.clone();
        bench.check()?;
        let again = refit(records, &start.model, values, windows, &free, effort);
        if again.cost < minimum.cost {
            minimum = again;
        }
    }
    bench.check()?;
    Ok(Candidate::new(
        problem,
        records,
        added(from, &start.model, start.effect),
        start.model,
        minimum,
        bench.window_s.map(|_| rough),
    ))
}

/// Whether the effect of a start replaces another one.
pub fn is_refinement(start: &Start) -> bool {
    !start.effect.info().replaces.is_empty()
}

/// Of the entries in `reached`, the one of lowest cost whose effect is refined by `effect`.
fn refined<T>(effect: EffectId, reached: &[(EffectId, T)], cost: impl Fn(&T) -> f64) -> Option<&T> {
    let replaces = effect.info().replaces;
    reached
        .iter()
        .filter(|(simpler, _)| replaces.contains(&simpler.name()))
        .map(|(_, reached)| reached)
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Fits the screened suspects in the windows of the score test, the most promising first; each fit knows the best
/// cost so far. Then fits the `refinements` on top of them. A fit is kept if it gains what `least_gain` (χ²)
/// asks of its effect and [`LEAST_SHARE`] of the best gain, or if a fit that does refines it.
pub fn fit_all_roughly(
    bench: &SearchBench,
    from: &Candidate,
    screened: Vec<Vec<Start>>,
    refinements: &[EffectId],
    least_gain: &dyn Fn(EffectId) -> f64,
    goal: Goal,
) -> Result<Vec<(EffectId, Rough)>, Cancelled> {
    let point = from.point();
    let noise = bench.noise_cost();
    let least_trace = bench.thresholds.least_trace;
    let is_noise = |cost: f64| cost < (1.0 + least_trace * least_trace) * noise;
    let mut roughs: Vec<(EffectId, Rough)> = vec![];
    let gain = |rough: &Rough| point.cost - rough.minimum.cost;
    let best_gain = |roughs: &[(EffectId, Rough)]| {
        let gains = roughs.iter().map(|(_, rough)| gain(rough));
        gains.fold(0.0, f64::max)
    };
    // Once a fit leaves nothing but noise, other fits matter only if they come near it.
    let near = |cost: f64| {
        if is_noise(cost) {
            within_reach(point.cost, cost)
        } else {
            f64::INFINITY
        }
    };
    let mut reach = goal.windows;
    for starts in screened {
        let Some(effect) = starts.first().map(|start| start.effect) else {
            continue;
        };
        let least = point.cost - least_gain(effect);
        let found = fit_roughly(bench, point, starts, reach.min(least))?;
        if let Some(rough) = found.filter(|rough| rough.minimum.cost <= least) {
            reach = reach.min(near(rough.minimum.cost));
            roughs.push((effect, rough));
        }
    }
    for &effect in refinements {
        let Some(simpler) = refined(effect, &roughs, |rough| rough.minimum.cost) else {
            continue;
        };
        // A fit that leaves nothing but noise is refined after it has been chosen. Once any fit leaves nothing but noise,
        // one that gains little beside it is not refined at all. While something remains, it is: what a refinement adds
        // may be the larger part.
        let best = best_gain(&roughs);
        let is_slight = gain(simpler) < LEAST_SHARE * best && is_noise(point.cost - best);
        if is_slight || is_noise(simpler.minimum.cost) {
            continue;
        }
        let fit = (&simpler.start.model, &simpler.minimum);
        let starts = refined_starts(bench, &from.minimum, fit, effect);
        // A refinement must gain something beyond the effect that it refines.
        let least = point.cost - least_gain(effect);
        let least = least.min(simpler.minimum.cost - bench.least_gain);
        let found = fit_roughly(bench, &simpler.minimum, starts, reach.min(least))?;
        if let Some(rough) = found.filter(|rough| rough.minimum.cost <= least) {
            reach = reach.min(near(rough.minimum.cost));
            roughs.push((effect, rough));
        }
    }
    let best_gain = best_gain(&roughs);
    let is_plain = |rough: &Rough| gain(rough) >= LEAST_SHARE * best_gain;
    let refined_names: Vec<&str> = roughs
        .iter()
        .filter(|(_, rough)| is_plain(rough))
        .flat_map(|(effect, _)| effect.info().replaces)
        .copied()
        .collect();
    roughs.retain(|(effect, rough)| is_plain(rough) || refined_names.contains(&effect.name()));
    Ok(roughs)
}

/// Fits the results of [`fit_all_roughly`] over the whole logs: those of lowest cost first, refinements last.
pub fn fit_all_wholly(
    bench: &SearchBench,
    from: &Candidate,
    mut roughs: Vec<(EffectId, Rough)>,
    mut goal: Goal,
) -> Result<Vec<Candidate>, Cancelled> {
    roughs.sort_by(|(_, a), (_, b)| a.minimum.cost.total_cmp(&b.minimum.cost));
    roughs.sort_by_key(|(_, rough)| is_refinement(&rough.start));
    let mut candidates: Vec<Candidate> = vec![];
    let mut reached: Vec<(EffectId, f64)> = vec![];
    for (effect, rough) in roughs {
        let simpler = refined(effect, &reached, |cost| *cost);
        let least = simpler.map_or(f64::INFINITY, |cost| cost - bench.least_gain);
        let own = Goal {
            whole: goal.whole.min(least),
            ..goal
        };
        let candidate = fit_whole(bench, from, rough, own)?;
        reached.push((effect, candidate.minimum.cost));
        if bench.leaves_nothing(&candidate) {
            let beside = Goal::beside(from, &candidate);
            goal.whole = goal.whole.min(beside.whole);
        }
        candidates.push(candidate);
    }
    Ok(candidates)
}

/// Refits a candidate without one of its effects. `known` returns an earlier candidate with the smaller set of
/// effects, if there is one. The result is `None` if the new fit in short windows is not better than the
/// earlier one there.
///
/// # Errors
/// [`Cancelled`].
pub fn without(
    bench: &SearchBench,
    from: &Candidate,
    effect: EffectId,
    known: &dyn Fn(&[EffectId]) -> Option<Candidate>,
) -> Result<Option<Candidate>, Cancelled> {
    let (problem, records) = (bench.problem, &bench.records);
    let model = from.model.without(effect);
    let free = problem.free(&model);
    let mut added = from.added.clone();
    added.retain(|&present| present != effect);
    let mut set = added.clone();
    set.sort();
    let known = known(&set);
    let again = |values: &[f64], windows: Vec<Vec<Window>>| -> Result<Minimum, Cancelled> {
        bench.check()?;
        let effort = bench.until_called_off(Effort::FULL);
        let found = refit(records, &model, values.to_vec(), windows, &free, effort);
        bench.check()?;
        Ok(found)
    };
    let carried = |minimum: &Minimum| -> Vec<f64> {
        let start = vec![0.0; model.parameter_count()];
        carry_over(&from.model, &minimum.values, &model, &start)
    };
    let windowed = from
        .windowed
        .as_ref()
        .map(|windowed| again(&carried(windowed), windowed.windows.clone()))
        .transpose()?;
    let minimum = match &windowed {
        Some(windowed) => {
            let reached = known.and_then(|known| known.windowed);
            let least = bench.thresholds.least_gain;
            if reached.is_some_and(|reached| reached.cost - windowed.cost < least) {
                return Ok(None);
            }
            let windows = joined(records, &windowed.values, &windowed.windows);
            again(&windowed.values, windows)?
        }
        None => again(&carried(&from.minimum), from.minimum.windows.clone())?,
    };
    Ok(Some(Candidate::new(
        problem, records, added, model, minimum, windowed,
    )))
}
