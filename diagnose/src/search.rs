//! The search for the set of effects that explains the measurements.

use identify::{Cancelled, Effort, Outcome, Progress, fit_windowed, refit};
use plant::{EffectId, period_s};
use rayon::prelude::*;

use crate::bench::SearchBench;
use crate::candidate::{Candidate, names};
use crate::economy::{BEAM, FINISHED, MOST_EFFECTS, MOST_FITS, NEAR, WINDOW_PERIODS};
use crate::evidence::{evidences, evidences_beyond};
use crate::pool::{Search, argmax, is_fitted, merge, takes_up, ties};
use crate::round::{Round, try_all};
use crate::shown::shows;
use crate::trial::{Goal, without};

/// As [`evidences`], after the fits of the best candidates whose iterations ran out have been brought
/// to their minima: a fit that is stuck on its way would be taken for a model that lacks something.
fn finished_evidences(bench: &SearchBench, pool: &mut [Candidate]) -> Result<Vec<f64>, Cancelled> {
    for _ in 0..FINISHED {
        let evidence = evidences(bench, pool);
        let mut order: Vec<usize> = (0..pool.len()).collect();
        order.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
        order.truncate(FINISHED);
        let Some(&index) = order
            .iter()
            .find(|&&index| pool[index].minimum.outcome == Outcome::OutOfIterations)
        else {
            return Ok(evidence);
        };
        let unfinished = &pool[index];
        let leader = &pool[order[0]];
        let goal = if index != order[0] && bench.leaves_nothing(leader) {
            Goal::beside(&pool[0], leader).whole
        } else {
            f64::INFINITY
        };
        bench.check()?;
        let mut minimum = refit(
            &bench.records,
            &unfinished.model,
            unfinished.minimum.values.clone(),
            unfinished.minimum.windows.clone(),
            &bench.problem.free(&unfinished.model),
            bench.until_called_off(Effort::PATIENT).towards(goal),
        );
        bench.check()?;
        if minimum.outcome == Outcome::OutOfIterations {
            minimum.outcome = Outcome::Stalled;
        }
        pool[index] = Candidate::new(
            bench.problem,
            &bench.records,
            unfinished.added.clone(),
            unfinished.model.clone(),
            minimum,
            unfinished.windowed.clone(),
        );
    }
    Ok(evidences(bench, pool))
}

/// As [`crate::pool::simplest`], where the sensors of the bench show the difference.
fn simplest(bench: &SearchBench, pool: &[Candidate], evidence: &[f64], top: usize) -> usize {
    let shows = |smaller: &Candidate, larger: &Candidate| shows(bench, &pool[0], smaller, larger);
    crate::pool::simplest(pool, evidence, top, bench.thresholds.tie, shows)
}

/// What a search works on, and the model from which it starts, fitted in short windows besides where
/// its free run has drifted away from the logs.
///
/// # Errors
/// [`Cancelled`] if the work is called off.
pub fn prepared<'a>(
    bench: &SearchBench<'a>,
    start: Candidate,
) -> Result<(SearchBench<'a>, Candidate), Cancelled> {
    let (mut start, mut bench) = (start, bench.clone());
    let problem = bench.problem;
    if start.largest_remainder() > NEAR {
        bench.check()?;
        // The period is that of the samples, and the fit may start from what they show: the free run of
        // a model that lacks something essential can have strayed to parameters without meaning.
        let shown = problem.start_values(&start.model);
        let window_s = WINDOW_PERIODS * period_s(&shown);
        bench.window_s = Some(window_s);
        let free = problem.free(&start.model);
        let effort = bench.until_called_off(Effort::FULL);
        let fits = [start.minimum.values.clone(), shown].map(|values| {
            let (records, model) = (&bench.records, &start.model);
            fit_windowed(records, model, values, &free, window_s, effort)
        });
        bench.check()?;
        let [windowed, from_samples] = fits;
        let windowed = if from_samples.cost < windowed.cost {
            from_samples
        } else {
            windowed
        };
        start = Candidate::new(
            problem,
            &bench.records,
            start.added,
            start.model,
            start.minimum,
            Some(windowed),
        );
    }
    Ok((bench, start))
}

/// Searches from `start` (the fitted model as it is) for the effects that are missing, among the suspects of
/// the bench, whose logs are read in one piece.
///
/// # Errors
/// [`Cancelled`] if the work is called off.
pub fn search(
    bench: &SearchBench,
    start: Candidate,
    progress: &Progress,
) -> Result<Search, Cancelled> {
    let (bench, start) = prepared(bench, start)?;
    let thresholds = bench.thresholds;
    let tie = thresholds.tie;
    let mut pool = vec![start];
    let mut extended = vec![];
    let mut beam = vec![0usize];
    let mut best = 0usize;
    for depth in 1..=MOST_EFFECTS {
        for &index in &beam {
            let names = names(&pool[index].added);
            (progress.say)(&format!("trying every effect on top of {names}"));
            extended.push(pool[index].set());
        }
        let most = if depth == 1 { MOST_FITS } else { MOST_FITS / 2 };
        let is_fitted = |set: &[EffectId]| is_fitted(&pool, set);
        let round = Round {
            most,
            is_fitted: &is_fitted,
            leader: None,
            only_where_something_remains: depth > 1,
        };
        let mut found: Vec<Candidate> = vec![];
        for &index in &beam {
            found.extend(try_all(&bench, &pool[index], &round)?);
            // What explains everything is compared with others by swapping its effects.
            if found.iter().any(|one| bench.leaves_nothing(one)) {
                break;
            }
        }
        if found.is_empty() {
            break;
        }
        let newest = merge(&mut pool, found);
        let evidence = finished_evidences(&bench, &mut pool)?;
        let takes_up = |index: usize| takes_up(&pool, index, &newest, thresholds.remains);
        let settled = newest.iter().copied().filter(|&index| !takes_up(index));
        let Some(top) = argmax(&evidence, settled.chain([best])) else {
            break;
        };
        let next = simplest(&bench, &pool, &evidence, top);
        if next != best && evidence[next] - evidence[best] >= tie {
            best = next;
            if bench.leaves_nothing(&pool[best]) {
                refine(&bench, &mut pool, &mut best)?;
                break;
            }
        } else if evidence[top] <= evidence[best]
            || pool[best].largest_remainder() <= thresholds.remains
        {
            break;
        }
        // What is better by too little to decide, while something plain remains, may be half of the
        // answer: two effects can show together what neither shows alone.
        beam = newest.clone();
        beam.retain(|&index| !takes_up(index));
        beam.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
        beam.truncate(BEAM);
    }
    // Where nothing goes further than a refinement from which the search did not go on, that is it.
    let evidence = evidences(&bench, &pool);
    if let Some(top) = argmax(&evidence, 0..pool.len()) {
        let next = simplest(&bench, &pool, &evidence, top);
        if evidence[next] - evidence[best] >= tie {
            best = next;
        }
    }

    prune_and_swap(&bench, &mut pool, &mut best, &mut extended, progress)?;
    let evidence = evidences(&bench, &pool);
    let ties = indistinguishable(&bench, &pool, &evidence, best);
    Ok(Search {
        pool,
        evidence,
        best,
        ties,
    })
}

/// Tries what refines the effects of the best candidate, where it leaves nothing else to look for: dry
/// friction may be the larger part of Stribeck's curve.
fn refine(
    bench: &SearchBench,
    pool: &mut Vec<Candidate>,
    best: &mut usize,
) -> Result<(), Cancelled> {
    let added = &pool[*best].added;
    let refinements: Vec<EffectId> = bench
        .suspects
        .iter()
        .copied()
        .filter(|suspect| {
            let replaces = suspect.info().replaces;
            added.iter().any(|effect| replaces.contains(&effect.name()))
        })
        .collect();
    let mut refining = bench.clone();
    refining.suspects = &refinements;
    refining.least_gain = bench.thresholds.least_gain_of_refinement;
    let is_fitted = |set: &[EffectId]| is_fitted(pool, set);
    let round = Round {
        most: MOST_FITS,
        is_fitted: &is_fitted,
        leader: None,
        only_where_something_remains: false,
    };
    let found = try_all(&refining, &pool[*best], &round)?;
    let newest = merge(pool, found);
    let evidence = finished_evidences(bench, pool)?;
    let Some(top) = argmax(&evidence, newest.into_iter().chain([*best])) else {
        return Ok(());
    };
    let next = simplest(bench, pool, &evidence, top);
    if next != *best && evidence[next] - evidence[*best] >= bench.thresholds.tie {
        *best = next;
    }
    Ok(())
}

/// Drops effects that later ones made needless, and tries others in the place of each.
fn prune_and_swap(
    bench: &SearchBench,
    pool: &mut Vec<Candidate>,
    best: &mut usize,
    extended: &mut Vec<Vec<EffectId>>,
    progress: &Progress,
) -> Result<(), Cancelled> {
    for _ in 0..MOST_EFFECTS {
        let chosen = pool[*best].clone();
        if chosen.added.len() < 2 {
            break;
        }
        (progress.say)("trying others in the place of each effect");
        // Also of sets that the pool has: a smaller model that is stuck far from its minimum would
        // make an effect look needed. Their starts are now those of the larger one.
        let known = |set: &[EffectId]| pool.iter().find(|known| known.set() == set).cloned();
        let smaller: Vec<Candidate> = chosen
            .added
            .par_iter()
            .filter_map(|&effect| without(bench, &chosen, effect, &known).transpose())
            .collect::<Result<_, Cancelled>>()?;
        merge(pool, smaller);
        // What is left without one effect is extended by every other one, if it was not yet.
        let from: Vec<&Candidate> = chosen
            .added
            .iter()
            .filter_map(|&effect| {
                let mut set = chosen.set();
                set.retain(|&present| present != effect);
                pool.iter().find(|known| known.set() == set)
            })
            .filter(|candidate| {
                // Effects that come out at nothing leave a model from which everything was tried before.
                let is_nothing_more = || {
                    pool.iter().any(|known| {
                        candidate.strictly_contains(known)
                            && extended.contains(&known.set())
                            && known.point().cost - candidate.point().cost
                                < bench.thresholds.least_gain
                    })
                };
                !extended.contains(&candidate.set()) && !is_nothing_more()
            })
            .collect();
        extended.extend(from.iter().map(|candidate| candidate.set()));
        let round = Round {
            most: MOST_FITS / 2,
            is_fitted: &|set| is_fitted(pool, set),
            leader: bench.leaves_nothing(&chosen).then_some(&chosen),
            only_where_something_remains: true,
        };
        let found: Vec<Vec<Candidate>> = from
            .par_iter()
            .map(|candidate| try_all(bench, candidate, &round))
            .collect::<Result<_, Cancelled>>()?;
        merge(pool, found.concat());
        let evidence = finished_evidences(bench, pool)?;
        let Some(top) = argmax(&evidence, 0..pool.len()) else {
            break;
        };
        let next = simplest(bench, pool, &evidence, top);
        if pool[next].set() == chosen.set() {
            break;
        }
        *best = next;
    }
    Ok(())
}

/// Candidates that the measurements cannot tell from the chosen one.
fn indistinguishable(
    bench: &SearchBench,
    pool: &[Candidate],
    evidence: &[f64],
    best: usize,
) -> Vec<usize> {
    if pool[best].added.is_empty() {
        return vec![];
    }
    // Dry friction that is nearly as good as another effect may lose by its smoothed sign alone.
    let excused = |candidate: &Candidate| -> Option<Vec<f64>> {
        let is_near = candidate.set() != pool[best].set()
            && candidate.largest_remainder() <= bench.thresholds.remains;
        is_near.then(|| bench.imperfection(candidate).rmse_without.clone())
    };
    let excused = evidences_beyond(bench, pool, &excused);
    let evidence: Vec<f64> = evidence
        .iter()
        .zip(excused)
        .map(|(plain, excused)| plain.max(excused))
        .collect();
    ties(pool, &evidence, best, bench.thresholds.tie)
}
