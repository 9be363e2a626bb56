//! The search for the set of effects that explains the measurements.

use identify::{Cancelled, Effort, Outcome, Progress, fit_windowed, refit};
use parallel::parallel_map;
use plant::{EffectId, period_s};

use crate::bench::SearchBench;
use crate::candidate::{Candidate, names};
use crate::double_swap::half_swapped;
use crate::economy::{BEAM, FINISHED, MOST_EFFECTS, MOST_FITS, NEAR, WINDOW_PERIODS};
use crate::evidence::{evidences, evidences_beyond};
use crate::pool::{Search, argmax, is_fitted, merge, takes_up, ties};
use crate::round::{Round, try_all};
use crate::shown::shows;
use crate::trial::{Goal, without};

/// As [`evidences`], after fits among the best candidates that ran out of iterations have been continued to
/// their minima. An unfinished fit would look like a model that lacks something.
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

/// As [`crate::pool::simplest`]; the bench decides whether its sensors would show a difference.
fn simplest(bench: &SearchBench, pool: &[Candidate], evidence: &[f64], top: usize) -> usize {
    let shows = |smaller: &Candidate, larger: &Candidate| shows(bench, &pool[0], smaller, larger);
    crate::pool::simplest(pool, evidence, top, bench.thresholds.tie, shows)
}

/// Prepares a search: the bench, and the starting model. Where the free run of that model drifts away from the logs,
/// the model is also fitted in short windows.
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
        // The period is taken from the samples, and one of the two fits starts from what the samples show. The free
        // run of an incomplete model may have reached meaningless parameters.
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

/// Searches for the missing effects among the suspects of the bench, from `start`, the fitted starting model. The
/// logs are read in one piece.
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
    if bench.proves_nothing_missing(&pool[0]) {
        return Ok(Search {
            evidence: evidences(&bench, &pool),
            pool,
            best: 0,
            ties: vec![],
        });
    }
    let mut extended = vec![];
    let mut beam = vec![0usize];
    let mut best = 0usize;
    for depth in 1..=MOST_EFFECTS {
        for &index in &beam {
            let names = names(&pool[index].added);
            (progress.say)(&format!(
                "search: the model has {names}; trying each further effect"
            ));
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
            // A candidate that leaves no remainder is compared with others later, when its effects are swapped.
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
        } else if pool[best].largest_remainder() <= thresholds.remains
            || (evidence[top] <= evidence[best] && depth > 1)
        {
            break;
        }
        // Where no single effect decides and a plain remainder is left, pairs are tried all the same: two effects together
        // can explain what neither explains alone. A log of a few periods has so few independent values that neither may
        // outweigh its own parameters.
        beam = newest.clone();
        beam.retain(|&index| !takes_up(index) && evidence[index] > f64::NEG_INFINITY);
        beam.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
        beam.truncate(BEAM);
    }
    // If nothing beats a refinement that the search did not extend (see `takes_up`), the refinement is chosen.
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

/// Tries refinements of the effects of the best candidate once that candidate leaves no remainder: the dry friction
/// that was found may be the larger part of a Stribeck curve.
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

/// Drops effects that later ones made unnecessary, and tries other effects in the place of each.
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
        // Sets that are already in the pool are fitted again, starting from the parameters of the larger candidate. A
        // smaller model that is stuck far from its minimum would make an effect look necessary.
        let known = |set: &[EffectId]| pool.iter().find(|known| known.set() == set).cloned();
        let smaller: Vec<Candidate> = parallel_map(&chosen.added, |&effect| {
            without(bench, &chosen, effect, &known).transpose()
        })
        .into_iter()
        .flatten()
        .collect::<Result<_, Cancelled>>()?;
        merge(pool, smaller);
        // Each set with one effect removed is extended by every other effect, unless that was done before.
        let from: Vec<&Candidate> = chosen
            .added
            .iter()
            .filter_map(|&effect| {
                let mut set = chosen.set();
                set.retain(|&present| present != effect);
                pool.iter().find(|known| known.set() == set)
            })
            .filter(|candidate| {
                // An effect fitted at zero amplitude leaves a model that was extended before.
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
        let found: Vec<Vec<Candidate>> =
            parallel_map(from, |candidate| try_all(bench, candidate, &round))
                .into_iter()
                .collect::<Result<_, Cancelled>>()?;
        merge(pool, found.concat());
        swap_two(bench, pool, &chosen)?;
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

/// Fits the sets that have imitations in the place of two effects of `chosen`.
fn swap_two(
    bench: &SearchBench,
    pool: &mut Vec<Candidate>,
    chosen: &Candidate,
) -> Result<(), Cancelled> {
    for (index, completions) in half_swapped(pool, chosen, bench.suspects) {
        let mut among = bench.clone();
        among.suspects = &completions;
        let round = Round {
            most: MOST_FITS / 2,
            is_fitted: &|set| is_fitted(pool, set),
            leader: bench.leaves_nothing(chosen).then_some(chosen),
            only_where_something_remains: true,
        };
        let found = try_all(&among, &pool[index], &round)?;
        merge(pool, found);
    }
    Ok(())
}

/// The candidates that the measurements cannot distinguish from the chosen one.
fn indistinguishable(
    bench: &SearchBench,
    pool: &[Candidate],
    evidence: &[f64],
    best: usize,
) -> Vec<usize> {
    if pool[best].added.is_empty() {
        return vec![];
    }
    // A candidate with dry friction that nearly ties may lose only because its sign is smoothed.
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
