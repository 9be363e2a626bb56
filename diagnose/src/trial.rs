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

/// The effects beyond the diagnosed model after `effect` has been added to those of `from`, which made it
/// `model`.
pub fn added(from: &Candidate, model: &Model, effect: EffectId) -> Vec<EffectId> {
    let mut added = from.added.clone();
    added.retain(|present| model.has(*present));
    added.push(effect);
    added
}

/// The costs at which a fit on top of a candidate begins to matter. Once another one leaves nothing but
/// noise, an explanation that competes with it must take nearly as much of the misfit.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// In the windows of the score test.
    windows: f64,
    /// Over the whole logs.
    pub whole: f64,
}

impl Goal {
    /// Every fit matters.
    pub const ANY: Goal = Goal {
        windows: f64::INFINITY,
        whole: f64::INFINITY,
    };

    /// On top of `from`, beside a `leader` that leaves nothing.
    pub fn beside(from: &Candidate, leader: &Candidate) -> Goal {
        Goal {
            windows: within_reach(from.point().cost, leader.point().cost),
            whole: within_reach(from.minimum.cost, leader.minimum.cost),
        }
    }
}

/// The cost that takes [`KEPT_SHARE`] of what lies between two.
fn within_reach(from: f64, leader: f64) -> f64 {
    from - KEPT_SHARE * (from - leader)
}

/// A fit in the windows of the score test, and where it came from.
#[derive(Clone, Debug)]
pub struct Rough {
    /// The fit.
    minimum: Minimum,
    /// Its start.
    start: Start,
}

/// Fits an effect on top of `point` in the windows of the score test, from the starts that promise most.
/// `None` where that brings nothing: a fit that leaves the effect at nothing is that of the smaller model.
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
        // What has been reached already, or nearly, no other start is tried for.
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

/// Whether a fit has come to the end of the range of one of its effect's own parameters and still misses
/// something: from another start it may come to a place that means something.
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

/// The parameters and windows from which the whole logs are fitted: those of the fit in short windows, or
/// those of the smaller model over the whole logs with the new effect's parameters, whichever lies nearer.
/// Where the free run drifts away the two are far apart, and a small effect moves neither.
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

/// Fits an effect over the whole logs after [`fit_roughly`].
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
    // What brings much in short windows must bring something over the whole logs.
    let brings_much = point.cost - rough.cost > MUCH * point.cost;
    if minimum.cost > from.minimum.cost && brings_much && rough.cost <= goal.windows {
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

/// Whether a start is that of an effect that takes the place of another one.
pub fn is_refinement(start: &Start) -> bool {
    !start.effect.info().replaces.is_empty()
}

/// The best of those that were `reached` with effects that this one refines.
fn refined<T>(effect: EffectId, reached: &[(EffectId, T)], cost: impl Fn(&T) -> f64) -> Option<&T> {
    let replaces = effect.info().replaces;
    reached
        .iter()
        .filter(|(simpler, _)| replaces.contains(&simpler.name()))
        .map(|(_, reached)| reached)
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

/// Fits the suspects that the score test has left in its windows, one after the other, those that promise most
/// first: what one reaches is known to the next, and each fit keeps the machine busy by itself. Then the
/// `refinements` of those on top of them. What remains takes what `least_gain` asks of an effect and a share
/// of what the best one takes, or is refined by what does.
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
    // Beside what leaves nothing but noise, others matter only if they come near it.
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
        // What takes little beside something else is not refined yet; what leaves nothing but noise is
        // once it has been chosen.
        let is_slight = gain(simpler) < LEAST_SHARE * best_gain(&roughs);
        if is_slight || is_noise(simpler.minimum.cost) {
            continue;
        }
        let fit = (&simpler.start.model, &simpler.minimum);
        let starts = refined_starts(bench, &from.minimum, fit, effect);
        // A refinement that comes out as what it refines is that.
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

/// Fits over the whole logs what [`fit_all_roughly`] has left: what refines another effect last, otherwise those
/// that take most first.
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

/// Refits a candidate without one of its effects. `known` is what an earlier fit of that set has reached:
/// `None` if this one is no better, as far as the short windows show where there are any.
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
