//! The search for the set of effects that explains the measurements.

use identify::{
    Channel, Effort, Outcome, Record, Setup, acts, fit_windowed, period_s, refit, structure,
    without_rounding,
};
use plant::EffectId;
use rayon::prelude::*;

use crate::candidate::Candidate;
use crate::evidence::{TIE, effective, log_evidence, log_evidence_beyond, residual};
use crate::suspects::{Bench, Goal, LEAST_GAIN, MOST_FITS, Round, applicable, try_all, without};

/// Most effects that are added in one diagnosis.
const MOST_EFFECTS: usize = 4;
/// How many sets are extended further in each round: the best first step need not belong to the
/// best pair.
const BEAM: usize = 2;
/// An effect must lower the error of some series by at least this share of the series' noise (root
/// of the difference of the mean squares). What is smaller may be significant in ten thousand
/// samples, and yet be the imperfection of an integration rule or of a clock.
pub const LEAST_TRACE: f64 = 0.2;
/// The same for a refinement that takes the place of a term: it speaks about that very term, whose own
/// imperfection is known (see `imperfection.rs`). A hundredth of the noise's variance.
const LEAST_TRACE_OF_REFINEMENT: f64 = 0.1;
/// The same for an effect beside others that were added before it, in experiments in which they act:
/// their terms have imperfections of
/// their own (dry friction with its smoothed sign sticks a little less than a real joint; a window knows
/// its past from noisy samples), which another effect may take up. A refinement is spared.
pub const LEAST_TRACE_BESIDE: f64 = 0.5;
/// What is added beside others must also show at least this share of their trace: dry
/// friction whose sign is smoothed over 0.01 rad/s is that of a real joint to about half a percent.
const LEAST_SHARE_OF_TRACE: f64 = 0.01;
/// And so many times what the smoothed sign of dry friction alone would leave there
/// (see `imperfection.rs`): of a smaller trace a quarter of the square could be that, and the sign that
/// stands for sticking there is ten times as sharp and not infinitely so.
const TIMES_IMPERFECTION: f64 = 2.0;
/// Structure of this size in units of a channel's noise counts as "something remains". The noise
/// itself is the scale below which nobody looking at the figure would see a misfit.
pub const REMAINS: f64 = 1.0;

/// Least gain in χ² of what refines the answer: the 1 % point for two parameters, since this is asked once
/// and not of twenty suspects. What gains so little is not chosen for it, but it is named beside the answer.
const LEAST_GAIN_OF_REFINEMENT: f64 = 9.2;

/// Structured remainder, in units of noise, up to which a free run is close enough to the
/// measurement for its sensitivities to mean something.
const NEAR: f64 = 5.0;
/// Periods in the short windows in which effects are scored where the free run has drifted away.
const WINDOW_PERIODS: f64 = 3.0;

/// Everything that was tried, with the evidence for it.
#[derive(Clone, Debug)]
pub struct Search {
    /// The candidates; the first is the model as it was.
    pub pool: Vec<Candidate>,
    /// Logarithm of the evidence of each.
    pub evidence: Vec<f64>,
    /// Index of the chosen one.
    pub best: usize,
    /// Indices of candidates that tie with the chosen one, itself among them where there are any.
    pub ties: Vec<usize>,
}

/// The structured remainder of a channel beside what is predicted, in units of its noise (0 where not
/// significant).
pub fn remainder(channel: &Channel, predicted: &[f64], weight: &[f64]) -> f64 {
    let left = match channel.quantum {
        Some(quantum) => without_rounding(&channel.samples, predicted, channel.noise_std, quantum),
        None => residual(&channel.samples, predicted),
    };
    let found = structure(&left, channel.noise_std, weight);
    if found.is_significant() {
        found.rms_over_noise
    } else {
        0.0
    }
}

/// For every series, the structured remainder in units of its noise (0 where not significant).
pub fn remainders(records: &[&Record], candidate: &Candidate) -> Vec<Vec<f64>> {
    records
        .iter()
        .zip(&candidate.traces)
        .map(|(record, traces)| {
            let channels = record.channels.iter().zip(traces);
            channels
                .map(|(channel, trace)| remainder(channel, &trace.predicted, &record.weight))
                .collect()
        })
        .collect()
}

/// The largest structured remainder over all series that is not what a smoothed sign of dry friction leaves,
/// in units of noise: of a small one that makes no difference.
pub fn unexplained_remainder(bench: &Bench, candidate: &Candidate) -> f64 {
    let plain = largest_remainder(&bench.records, candidate);
    if plain <= REMAINS {
        return plain;
    }
    let without = candidate.imperfection(bench.setup, &bench.records);
    let largest = without.remainders_without.iter().flatten().copied();
    plain.min(largest.fold(0.0, f64::max))
}

/// The largest structured remainder over all series, in units of noise.
pub fn largest_remainder(records: &[&Record], candidate: &Candidate) -> f64 {
    let remainders = candidate.remainders(records).iter();
    remainders.flatten().copied().fold(0.0, f64::max)
}

/// Whether a candidate leaves no structure that a sensor would show.
pub fn leaves_nothing(records: &[&Record], candidate: &Candidate) -> bool {
    largest_remainder(records, candidate) < LEAST_TRACE
}

/// The fall of every error from `before` to `after` in units of the series' noise: the root of the
/// difference of the mean squares.
fn traces(records: &[&Record], before: &Candidate, after: &Candidate) -> Vec<f64> {
    before
        .rmse()
        .iter()
        .zip(after.rmse())
        .zip(noise(records))
        .map(|((before, after), noise)| (before * before - after * after).max(0.0).sqrt() / noise)
        .collect()
}

/// The largest of [`traces`].
pub fn largest_trace(records: &[&Record], before: &Candidate, after: &Candidate) -> f64 {
    traces(records, before, after)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether what `larger` adds to `smaller` leaves a trace in any series that a person would see, and
/// that the imperfections of what was added before cannot be. `start` is the model as it was.
pub fn shows(bench: &Bench, start: &Candidate, smaller: &Candidate, larger: &Candidate) -> bool {
    let records = &bench.records;
    let is_refinement = smaller.added.len() == larger.added.len();
    let share = LEAST_SHARE_OF_TRACE * largest_trace(records, start, smaller);
    let kinds = records
        .iter()
        .flat_map(|record| record.channels.iter().map(|_| record.kind));
    traces(records, smaller, larger)
        .into_iter()
        .zip(kinds)
        .enumerate()
        .any(|(series, (trace, kind))| {
            let is_touched = smaller.added.iter().any(|&effect| acts(effect, kind));
            let least = match (is_touched, is_refinement) {
                (false, _) => LEAST_TRACE,
                (true, true) => LEAST_TRACE_OF_REFINEMENT,
                (true, false) => LEAST_TRACE_BESIDE.max(share),
            };
            let imperfection = || smaller.imperfection(bench.setup, records).rms_over_noise[series];
            // Whether the dry friction was added now or stood in the model before.
            trace >= least && trace >= TIMES_IMPERFECTION * imperfection()
        })
}

/// The noise of every series, in the order of [`Candidate::rmse`].
pub fn noise(records: &[&Record]) -> Vec<f64> {
    records
        .iter()
        .flat_map(|record| record.channels.iter().map(|channel| channel.noise_std))
        .collect()
}

/// The evidence for every candidate, with the effective sample sizes that the best of them leaves.
fn evidences(bench: &Bench, pool: &[Candidate]) -> Vec<f64> {
    evidences_beyond(bench, pool, &|_| None)
}

/// As [`evidences`], with errors from which is taken what is `excused`.
fn evidences_beyond(
    bench: &Bench,
    pool: &[Candidate],
    excused: &dyn Fn(&Candidate) -> Option<Vec<f64>>,
) -> Vec<f64> {
    let best = pool
        .iter()
        .min_by(|a, b| a.minimum.cost.total_cmp(&b.minimum.cost));
    let Some(best) = best else { return vec![] };
    let effective = effective(&bench.records, best);
    let noise = noise(&bench.records);
    let suspects = bench
        .suspects
        .iter()
        .filter(|&&effect| applicable(bench.setup, effect))
        .count();
    pool.iter()
        .map(|candidate| match excused(candidate) {
            Some(excused) => {
                log_evidence_beyond(candidate, &excused, best, &effective, &noise, suspects)
            }
            None => log_evidence(candidate, &effective, &noise, suspects),
        })
        .collect()
}

/// How many of the best candidates must have reached their minimum before they are compared.
const FINISHED: usize = 3;

/// As [`evidences`], after the fits of the best candidates whose iterations ran out have been brought
/// to their minima: a fit that is stuck on its way would be taken for a model that lacks something.
fn finished_evidences(bench: &Bench, pool: &mut [Candidate]) -> Vec<f64> {
    for _ in 0..FINISHED {
        let evidence = evidences(bench, pool);
        let mut order: Vec<usize> = (0..pool.len()).collect();
        order.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
        order.truncate(FINISHED);
        let Some(&index) = order
            .iter()
            .find(|&&index| pool[index].minimum.outcome == Outcome::OutOfIterations)
        else {
            return evidence;
        };
        let unfinished = &pool[index];
        let leader = &pool[order[0]];
        let goal = if index != order[0] && leaves_nothing(&bench.records, leader) {
            Goal::beside(&pool[0], leader).whole
        } else {
            f64::INFINITY
        };
        let mut minimum = refit(
            &bench.records,
            &unfinished.model,
            unfinished.minimum.values.clone(),
            unfinished.minimum.windows.clone(),
            &bench.setup.free(&unfinished.model),
            Effort::PATIENT.towards(goal),
        );
        if minimum.outcome == Outcome::OutOfIterations {
            minimum.outcome = Outcome::Stalled;
        }
        pool[index] = Candidate::new(
            bench.setup,
            &bench.records,
            unfinished.added.clone(),
            unfinished.model.clone(),
            minimum,
            unfinished.windowed.clone(),
        );
    }
    evidences(bench, pool)
}

/// Whether the pool has this set of effects (in the order of the library), fitted to its minimum.
fn is_fitted(pool: &[Candidate], set: &[EffectId]) -> bool {
    pool.iter()
        .any(|candidate| candidate.set() == set && candidate.minimum.outcome.was_successful())
}

/// Adds candidates whose set of effects the pool does not have yet, or has with a higher cost.
/// Returns where they are now, each place once: two ways may lead to the same set.
fn merge(pool: &mut Vec<Candidate>, found: Vec<Candidate>) -> Vec<usize> {
    let mut places = vec![];
    for candidate in found {
        match pool.iter().position(|old| old.set() == candidate.set()) {
            Some(at) => {
                if candidate.minimum.cost < pool[at].minimum.cost {
                    pool[at] = candidate;
                }
                if !places.contains(&at) {
                    places.push(at);
                }
            }
            None => {
                places.push(pool.len());
                pool.push(candidate);
            }
        }
    }
    places
}

/// The simplest candidate that `top` contains and that explains the measurements as well: its
/// evidence is not decisively lower, or no sensor would show the difference.
fn simplest(bench: &Bench, pool: &[Candidate], evidence: &[f64], top: usize) -> usize {
    (0..pool.len())
        .filter(|&index| {
            pool[top].strictly_contains(&pool[index])
                && (evidence[top] - evidence[index] < TIE
                    || !shows(bench, &pool[0], &pool[index], &pool[top]))
        })
        .min_by_key(|&index| pool[index].parameters)
        .unwrap_or(top)
}

/// Whether a candidate refines another one of these (presliding for dry friction) and leaves something
/// plain all the same: the refinement may then be taking up what something else causes, and the search
/// goes on from the simpler one. What is refined is tried again on top of what that finds.
fn takes_up(records: &[&Record], pool: &[Candidate], index: usize, among: &[usize]) -> bool {
    let candidate = &pool[index];
    let refines = |&other: &usize| {
        pool[other].added.len() == candidate.added.len()
            && candidate.strictly_contains(&pool[other])
    };
    among.iter().any(refines) && largest_remainder(records, candidate) > REMAINS
}

fn argmax(values: &[f64], among: impl Iterator<Item = usize>) -> Option<usize> {
    among.max_by(|&a, &b| values[a].total_cmp(&values[b]))
}

/// What a search works on, and the model from which it starts, fitted in short windows besides where
/// its free run has drifted away from the logs.
pub fn prepared<'a>(
    setup: &'a Setup,
    start: Candidate,
    suspects: &'a [EffectId],
) -> (Bench<'a>, Candidate) {
    let mut start = start;
    let mut bench = Bench::whole(setup, suspects);
    if largest_remainder(&bench.records, &start) > NEAR {
        // The period is that of the samples, and the fit may start from what they show: the free run of
        // a model that lacks something essential can have strayed to parameters without meaning.
        let shown = setup.start_values(&start.model);
        let window_s = WINDOW_PERIODS * period_s(&shown);
        bench.window_s = Some(window_s);
        let free = setup.free(&start.model);
        let fits = [start.minimum.values.clone(), shown].map(|values| {
            let (records, model) = (&bench.records, &start.model);
            fit_windowed(records, model, values, &free, window_s, Effort::FULL)
        });
        let [windowed, from_samples] = fits;
        let windowed = if from_samples.cost < windowed.cost {
            from_samples
        } else {
            windowed
        };
        start = Candidate::new(
            setup,
            &bench.records,
            start.added,
            start.model,
            start.minimum,
            Some(windowed),
        );
    }
    (bench, start)
}

/// Searches from `start` (the fitted model as it is) for the effects that are missing, among
/// `suspects`.
/// `progress` is told what is going on, in words.
pub fn search(
    setup: &Setup,
    start: Candidate,
    suspects: &[EffectId],
    progress: &dyn Fn(&str),
) -> Search {
    let (bench, start) = prepared(setup, start, suspects);
    let records = &bench.records;
    let mut pool = vec![start];
    let mut extended = vec![];
    let mut beam = vec![0usize];
    let mut best = 0usize;
    for depth in 1..=MOST_EFFECTS {
        for &index in &beam {
            let names = names(&pool[index].added);
            progress(&format!("trying every effect on top of {names}"));
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
            found.extend(try_all(&bench, &pool[index], &round));
            // What explains everything is compared with others by swapping its effects.
            if found.iter().any(|one| leaves_nothing(records, one)) {
                break;
            }
        }
        if found.is_empty() {
            break;
        }
        let newest = merge(&mut pool, found);
        let evidence = finished_evidences(&bench, &mut pool);
        let takes_up = |index: usize| takes_up(records, &pool, index, &newest);
        let settled = newest.iter().copied().filter(|&index| !takes_up(index));
        let Some(top) = argmax(&evidence, settled.chain([best])) else {
            break;
        };
        let next = simplest(&bench, &pool, &evidence, top);
        if next != best && evidence[next] - evidence[best] >= TIE {
            best = next;
            if leaves_nothing(records, &pool[best]) {
                refine(&bench, &mut pool, &mut best);
                break;
            }
        } else if evidence[top] <= evidence[best]
            || largest_remainder(records, &pool[best]) <= REMAINS
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
        if evidence[next] - evidence[best] >= TIE {
            best = next;
        }
    }

    prune_and_swap(&bench, &mut pool, &mut best, &mut extended, progress);
    let evidence = evidences(&bench, &pool);
    let ties = ties(&bench, &pool, &evidence, best);
    Search {
        pool,
        evidence,
        best,
        ties,
    }
}

/// Tries what refines the effects of the best candidate, where it leaves nothing else to look for: dry
/// friction may be the larger part of Stribeck's curve.
fn refine(bench: &Bench, pool: &mut Vec<Candidate>, best: &mut usize) {
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
    let refining = Bench {
        suspects: &refinements,
        least_gain: LEAST_GAIN_OF_REFINEMENT,
        ..bench.clone()
    };
    let is_fitted = |set: &[EffectId]| is_fitted(pool, set);
    let round = Round {
        most: MOST_FITS,
        is_fitted: &is_fitted,
        leader: None,
        only_where_something_remains: false,
    };
    let found = try_all(&refining, &pool[*best], &round);
    let newest = merge(pool, found);
    let evidence = finished_evidences(bench, pool);
    let Some(top) = argmax(&evidence, newest.into_iter().chain([*best])) else {
        return;
    };
    let next = simplest(bench, pool, &evidence, top);
    if next != *best && evidence[next] - evidence[*best] >= TIE {
        *best = next;
    }
}

/// Drops effects that later ones made needless, and tries others in the place of each.
fn prune_and_swap(
    bench: &Bench,
    pool: &mut Vec<Candidate>,
    best: &mut usize,
    extended: &mut Vec<Vec<EffectId>>,
    progress: &dyn Fn(&str),
) {
    for _ in 0..MOST_EFFECTS {
        let chosen = pool[*best].clone();
        if chosen.added.len() < 2 {
            break;
        }
        progress("trying others in the place of each effect");
        // Also of sets that the pool has: a smaller model that is stuck far from its minimum would
        // make an effect look needed. Their starts are now those of the larger one.
        let known = |set: &[EffectId]| pool.iter().find(|known| known.set() == set).cloned();
        let smaller: Vec<Candidate> = chosen
            .added
            .par_iter()
            .filter_map(|&effect| without(bench, &chosen, effect, &known))
            .collect();
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
                            && known.point().cost - candidate.point().cost < LEAST_GAIN
                    })
                };
                !extended.contains(&candidate.set()) && !is_nothing_more()
            })
            .collect();
        extended.extend(from.iter().map(|candidate| candidate.set()));
        let round = Round {
            most: MOST_FITS / 2,
            is_fitted: &|set| is_fitted(pool, set),
            leader: leaves_nothing(&bench.records, &chosen).then_some(&chosen),
            only_where_something_remains: true,
        };
        let found: Vec<Candidate> = from
            .par_iter()
            .flat_map(|candidate| try_all(bench, candidate, &round))
            .collect();
        merge(pool, found);
        let evidence = finished_evidences(bench, pool);
        let Some(top) = argmax(&evidence, 0..pool.len()) else {
            break;
        };
        let next = simplest(bench, pool, &evidence, top);
        if pool[next].set() == chosen.set() {
            break;
        }
        *best = next;
    }
}

/// Candidates that the measurements cannot tell from the chosen one.
fn ties(bench: &Bench, pool: &[Candidate], evidence: &[f64], best: usize) -> Vec<usize> {
    if pool[best].added.is_empty() {
        return vec![];
    }
    // Dry friction that is nearly as good as another effect may lose by its smoothed sign alone.
    let excused = |candidate: &Candidate| -> Option<Vec<f64>> {
        let is_near = candidate.set() != pool[best].set()
            && largest_remainder(&bench.records, candidate) <= REMAINS;
        is_near.then(|| {
            let imperfection = candidate.imperfection(bench.setup, &bench.records);
            imperfection.rmse_without.clone()
        })
    };
    let excused = evidences_beyond(bench, pool, &excused);
    let evidence: Vec<f64> = evidence
        .iter()
        .zip(excused)
        .map(|(plain, excused)| plain.max(excused))
        .collect();
    let mut ties: Vec<usize> = (0..pool.len())
        .filter(|&index| {
            index == best
                || (evidence[best] - evidence[index] < TIE
                    && !pool[index].added.is_empty()
                    && !pool[index].strictly_contains(&pool[best])
                    && !pool[best].strictly_contains(&pool[index]))
        })
        .collect();
    // Of two tying sets of which one contains the other, the smaller one speaks for both.
    let all = ties.clone();
    ties.retain(|&index| {
        !all.iter()
            .any(|&other| pool[index].strictly_contains(&pool[other]))
    });
    ties.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
    if ties.len() < 2 { vec![] } else { ties }
}

/// The effects in words.
pub fn names(effects: &[EffectId]) -> String {
    if effects.is_empty() {
        return "the model as it is".to_owned();
    }
    effects
        .iter()
        .map(|effect| effect.name())
        .collect::<Vec<_>>()
        .join(" + ")
}
