//! What a search has tried, as plain data, and what can be said of it without another fit.

use plant::EffectId;

use crate::candidate::Candidate;

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

/// Index of the largest value among these.
pub fn argmax(values: &[f64], among: impl Iterator<Item = usize>) -> Option<usize> {
    among.max_by(|&a, &b| values[a].total_cmp(&values[b]))
}

/// Whether the pool has this set of effects (in the order of the library), fitted to its minimum.
pub fn is_fitted(pool: &[Candidate], set: &[EffectId]) -> bool {
    pool.iter()
        .any(|candidate| candidate.set() == set && candidate.minimum.outcome.was_successful())
}

/// Adds candidates whose set of effects the pool does not have yet, or has with a higher cost.
/// Returns where they are now, each place once: two ways may lead to the same set.
pub fn merge(pool: &mut Vec<Candidate>, found: Vec<Candidate>) -> Vec<usize> {
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
/// evidence is lower by less than `tie`, or no sensor would show the difference. `shows` is asked whether
/// one would show what the second of two candidates adds to the first.
pub fn simplest(
    pool: &[Candidate],
    evidence: &[f64],
    top: usize,
    tie: f64,
    shows: impl Fn(&Candidate, &Candidate) -> bool,
) -> usize {
    (0..pool.len())
        .filter(|&index| {
            pool[top].strictly_contains(&pool[index])
                && (evidence[top] - evidence[index] < tie || !shows(&pool[index], &pool[top]))
        })
        .min_by_key(|&index| pool[index].parameters)
        .unwrap_or(top)
}

/// Whether a candidate refines another one of these (presliding for dry friction) and leaves something
/// plain all the same, more than `remains`: the refinement may then be taking up what something else
/// causes, and the search goes on from the simpler one. What is refined is tried again on top of what
/// that finds.
pub fn takes_up(pool: &[Candidate], index: usize, among: &[usize], remains: f64) -> bool {
    let candidate = &pool[index];
    let refines = |&other: &usize| {
        pool[other].added.len() == candidate.added.len()
            && candidate.strictly_contains(&pool[other])
    };
    among.iter().any(refines) && candidate.largest_remainder() > remains
}

/// Candidates whose evidence is lower by less than `tie` than that of the chosen one, and that neither
/// contain it nor are contained in it; itself among them. None where no other does.
pub fn ties(pool: &[Candidate], evidence: &[f64], best: usize, tie: f64) -> Vec<usize> {
    if pool[best].added.is_empty() {
        return vec![];
    }
    let mut ties: Vec<usize> = (0..pool.len())
        .filter(|&index| {
            index == best
                || (evidence[best] - evidence[index] < tie
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

/// The largest candidate that every tying one contains: what they agree on.
pub fn common(found: &Search) -> Option<usize> {
    (0..found.pool.len())
        .filter(|&index| {
            found
                .ties
                .iter()
                .all(|&tie| index == tie || found.pool[tie].strictly_contains(&found.pool[index]))
        })
        .max_by_key(|&index| found.pool[index].added.len())
}
