//! All candidates of a search as plain data, and what follows from them without another fit.

use plant::EffectId;

use crate::candidate::Candidate;

/// All candidates of a search, with the evidence for each.
#[derive(Clone, Debug)]
pub struct Search {
    /// The candidates. The first is the starting model of the search.
    pub pool: Vec<Candidate>,
    /// Logarithm of the evidence for each candidate, up to a common constant.
    pub evidence: Vec<f64>,
    /// Index of the chosen candidate.
    pub best: usize,
    /// Indices of the candidates that tie, the chosen one included; empty if no other candidate ties with it.
    pub ties: Vec<usize>,
}

/// The index in `among` with the largest value; `None` if `among` is empty.
pub fn argmax(values: &[f64], among: impl Iterator<Item = usize>) -> Option<usize> {
    among.max_by(|&a, &b| values[a].total_cmp(&values[b]))
}

/// Whether the pool has this set of effects (in the order of the library) with a converged fit.
pub fn is_fitted(pool: &[Candidate], set: &[EffectId]) -> bool {
    pool.iter()
        .any(|candidate| candidate.set() == set && candidate.minimum.outcome.was_successful())
}

/// Adds candidates with a new set of effects, and replaces those whose fit has a higher cost. Returns the index
/// of each found set in the pool, without repetition: two candidates can have the same set.
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

/// The simplest candidate that `top` contains and that explains the measurements as well: its evidence is lower
/// by less than `tie`, or `shows(smaller, top)` answers that no sensor would show the difference. `top` itself if
/// there is none.
pub fn simplest(
    pool: &[Candidate],
    evidence: &[f64],
    top: usize,
    tie: f64,
    shows: impl Fn(&Candidate, &Candidate) -> bool,
) -> usize {
    (0..pool.len())
        .filter(|&index| {
            // What has no evidence at all explains nothing, whether or not a larger candidate contains it.
            evidence[index] > f64::NEG_INFINITY
                && pool[top].strictly_contains(&pool[index])
                && (evidence[top] - evidence[index] < tie || !shows(&pool[index], &pool[top]))
        })
        .min_by_key(|&index| pool[index].parameters)
        .unwrap_or(top)
}

/// Whether a refinement (such as presliding for dry friction) may be absorbing another cause: it refines another
/// candidate of `among` and still leaves a structured remainder above `remains` (in units of noise). The search
/// then goes on from the simpler candidate, and the refinement is tried again on top of what that finds.
pub fn takes_up(pool: &[Candidate], index: usize, among: &[usize], remains: f64) -> bool {
    let candidate = &pool[index];
    let refines = |&other: &usize| {
        pool[other].added.len() == candidate.added.len()
            && candidate.strictly_contains(&pool[other])
    };
    among.iter().any(refines) && candidate.largest_remainder() > remains
}

/// The candidates that tie with the chosen one, the chosen one included: their evidence is lower by less than `tie`,
/// and they neither contain it nor are contained in it. Empty if no other candidate ties.
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
    // Of two tying sets, one of which contains the other, only the smaller is kept.
    let all = ties.clone();
    ties.retain(|&index| {
        !all.iter()
            .any(|&other| pool[index].strictly_contains(&pool[other]))
    });
    ties.sort_by(|&a, &b| evidence[b].total_cmp(&evidence[a]));
    if ties.len() < 2 { vec![] } else { ties }
}

/// Index of the largest candidate that every tying candidate contains: the effects on which they agree.
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

#[cfg(test)]
mod tests {
    use EffectId::{
        BodyCoulombFriction as Coulomb, BodyPreslidingFriction as Presliding,
        BodyQuadraticDrag as Drag, BodySofteningSpring as Spring, CurrentOffset as Offset,
    };

    use super::*;
    use crate::hand_made::{candidate, search};

    #[test]
    fn the_better_fit_of_a_set_takes_its_place() {
        let mut pool = vec![candidate(&[], 100.0, 5.0), candidate(&[Drag], 50.0, 2.0)];
        let found = vec![
            candidate(&[Coulomb, Drag], 20.0, 0.0),
            candidate(&[Drag], 40.0, 1.0),
            // The same set, found in another order and worse.
            candidate(&[Drag, Coulomb], 30.0, 0.0),
        ];
        assert_eq!(merge(&mut pool, found), [2, 1]);
        let costs: Vec<f64> = pool.iter().map(|one| one.minimum.cost).collect();
        assert_eq!(costs, [100.0, 40.0, 20.0]);
    }

    #[test]
    fn the_simplest_that_is_as_good_is_taken() {
        let pool = [
            candidate(&[], 100.0, 5.0),
            candidate(&[Coulomb], 12.0, 0.1),
            candidate(&[Coulomb, Drag], 10.0, 0.0),
        ];
        let evidence = [-50.0, -6.0, -4.0];
        assert_eq!(simplest(&pool, &evidence, 2, 3.0, |_, _| true), 1);
        // It is worse by more than a tie, but no sensor would show it; the base model is seen to fail.
        let shows = |smaller: &Candidate, _: &Candidate| smaller.added.is_empty();
        assert_eq!(simplest(&pool, &evidence, 2, 1.0, shows), 1);
        assert_eq!(simplest(&pool, &evidence, 2, 1.0, |_, _| true), 2);
        // No sensor would show the difference, but the smaller one has a value that no cause has.
        let evidence = [-50.0, f64::NEG_INFINITY, -4.0];
        assert_eq!(simplest(&pool, &evidence, 2, 3.0, shows), 2);
    }

    #[test]
    fn what_contains_another_is_no_tie_of_it() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -50.0),
                (&[Coulomb], 12.0, 0.0, -5.0),
                (&[Presliding], 12.0, 0.0, -5.5),
                (&[Drag], 13.0, 0.0, -6.0),
                (&[Drag, Offset], 13.0, 0.0, -6.5),
                (&[Spring], 30.0, 3.0, -15.0),
            ],
            1,
            &[],
        );
        // Presliding contains dry friction; drag speaks for drag with an offset; a spring is far.
        assert_eq!(ties(&found.pool, &found.evidence, 1, 3.0), [1, 3]);
        assert!(ties(&found.pool, &found.evidence, 1, 0.5).is_empty());
        // A model that lacks nothing ties with nothing.
        assert!(ties(&found.pool, &found.evidence, 0, 100.0).is_empty());
    }

    #[test]
    fn ties_agree_on_the_largest_set_that_all_contain() {
        let tried: &[(&[EffectId], f64, f64, f64)] = &[
            (&[], 100.0, 5.0, -50.0),
            (&[Coulomb], 50.0, 2.0, -20.0),
            (&[Coulomb, Drag], 10.0, 0.0, -4.0),
            (&[Coulomb, Spring], 10.0, 0.0, -4.5),
            (&[Offset, Spring], 10.0, 0.0, -4.5),
        ];
        assert_eq!(common(&search(tried, 2, &[2, 3])), Some(1));
        assert_eq!(common(&search(tried, 2, &[2, 4])), Some(0));
    }

    #[test]
    fn a_refinement_that_leaves_something_plain_takes_something_up() {
        let pool = [
            candidate(&[], 100.0, 5.0),
            candidate(&[Coulomb], 60.0, 3.0),
            candidate(&[Presliding], 50.0, 2.0),
        ];
        assert!(takes_up(&pool, 2, &[1, 2], 1.0));
        assert!(!takes_up(&pool, 2, &[1, 2], 2.5));
        assert!(!takes_up(&pool, 2, &[2], 1.0));
        assert!(!takes_up(&pool, 1, &[1, 2], 1.0));
    }

    #[test]
    fn only_a_fit_at_its_minimum_is_a_fit() {
        let mut pool = vec![candidate(&[Coulomb, Drag], 10.0, 0.0)];
        let mut set = vec![Drag, Coulomb];
        set.sort();
        assert!(is_fitted(&pool, &set));
        assert!(!is_fitted(&pool, &[Drag]));
        pool[0].minimum.outcome = identify::Outcome::OutOfIterations;
        assert!(!is_fitted(&pool, &set));
    }
}
