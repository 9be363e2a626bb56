//! The decision after a search: which effects are certain, which are provisional, and the verdict.

use plant::Model;

use crate::candidate::Candidate;
use crate::path::without_absorbers;
use crate::pool::{Search, common};
use crate::thresholds::Thresholds;
use crate::verdict::{Findings, Verdict, verdict};

/// The decision after a search.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Index of the candidate with all effects that are certain.
    pub certain: usize,
    /// Index of the candidate that is used until an experiment decides between explanations that tie: the one
    /// whose effects are the most common on real benches.
    pub provisional: Option<usize>,
    /// Indices of the candidates that tie and are offered as alternatives; empty if there are none.
    pub ties: Vec<usize>,
    /// The verdict.
    pub verdict: Verdict,
    /// The largest structured remainder of the last model, in units of noise.
    pub remainder: f64,
}

impl Decision {
    /// Index of the model to be used for predictions: the provisional one if there is one, else the certain one.
    pub fn last(&self) -> usize {
        self.provisional.unwrap_or(self.certain)
    }
}

/// Makes the decision. For every candidate of the pool, `left` is its largest structured remainder in units of
/// noise, and `excess` is its χ² beyond the noise.
pub fn decide(
    found: &Search,
    left: impl Fn(usize) -> f64,
    excess: impl Fn(usize) -> f64,
    thresholds: &Thresholds,
) -> Decision {
    let shared = if found.ties.is_empty() {
        found.best
    } else {
        common(found).unwrap_or(0)
    };
    let findings = Findings {
        added: found.pool[shared].added.len(),
        remainder: left(shared),
        ties: found.ties.len(),
        left_by_ties: found
            .ties
            .iter()
            .map(|&index| left(index))
            .fold(f64::INFINITY, f64::min),
    };
    let verdict = verdict(&findings, thresholds);
    let settled = |certain: usize, remainder: f64| Decision {
        certain,
        provisional: None,
        ties: vec![],
        verdict,
        remainder,
    };
    let usual = most_usual(found, shared);
    let excess: Vec<f64> = (0..found.pool.len()).map(excess).collect();
    // What ties share is certain as far as it takes something away without the effects on which they disagree. Beside one
    // of those it may be needed (an eccentricity makes up for a spring), and without them its size is zero: it is then as
    // provisional as they are. So is what takes less than they do: its own size is that of a fit which lacks the larger
    // cause, and the larger cause comes first.
    let left_by_ties = found.ties.iter().map(|&tie| excess[tie]);
    let left_by_ties = left_by_ties.fold(excess[shared], f64::min);
    let disputed = excess[shared] - left_by_ties;
    let taken_by_itself =
        without_absorbers(found, shared, &excess, disputed.max(thresholds.least_gain));
    match (verdict, usual) {
        (Verdict::NothingMissing | Verdict::Explained, _) => settled(shared, findings.remainder),
        (Verdict::Ambiguous, Some(usual)) => Decision {
            provisional: Some(usual),
            ties: found.ties.clone(),
            ..settled(taken_by_itself, left(usual))
        },
        (Verdict::Ambiguous | Verdict::Unexplained, usual) => {
            // Ties that explain more than they leave are offered as alternatives, even if something else remains.
            if let Some(usual) = usual
                .filter(|&usual| without_absorbers(found, usual, &excess, excess[usual]) == usual)
            {
                return Decision {
                    provisional: Some(usual),
                    ties: found.ties.clone(),
                    ..settled(taken_by_itself, left(usual))
                };
            }
            // What the ties share is a part of each of them. It is judged by what remains beside the whole of them, not
            // beside it alone: their further effects take more away, whichever of them is right.
            let certain = without_absorbers(found, shared, &excess, left_by_ties);
            settled(certain, left(certain))
        }
    }
}

/// Of the candidates that tie, the one whose effects beyond those that all ties `share` are the most common on real
/// benches. Among equals, the one with fewer parameters; then the first in the order of the library.
fn most_usual(found: &Search, shared: usize) -> Option<usize> {
    let shared = &found.pool[shared].model;
    found.ties.iter().copied().min_by(|&a, &b| {
        let (a, b) = (&found.pool[a], &found.pool[b]);
        log_odds(b, shared)
            .total_cmp(&log_odds(a, shared))
            .then(a.parameters.cmp(&b.parameters))
            .then_with(|| a.set().cmp(&b.set()))
    })
}

/// Logarithm of the prior odds that a bench has all effects that the candidate adds to the `shared` model.
fn log_odds(candidate: &Candidate, shared: &Model) -> f64 {
    let effects = candidate.model.effects().iter();
    effects
        .filter(|effect| !shared.has(**effect))
        .map(|effect| effect.info().prior.commonness.odds().ln())
        .sum()
}

#[cfg(test)]
mod tests {
    use plant::EffectId::{
        AngleEccentricity as Eccentricity, AngleOffset as Zero, BodyCableSpring as Cable,
        BodyCoulombFriction as Coulomb, BodyPreslidingFriction as Presliding,
        BodyQuadraticDrag as Drag, BodySofteningSpring as Softening, CurrentOffset as Offset,
        WheelCoulombFriction as WheelCoulomb,
    };

    use super::*;
    use crate::hand_made::search;
    use crate::path::path;

    fn of(found: &Search) -> Decision {
        let left = |index: usize| found.pool[index].largest_remainder();
        let excess = |index: usize| found.pool[index].minimum.cost;
        decide(found, left, excess, &Thresholds::default())
    }

    #[test]
    fn what_explains_alone_is_certain() {
        let found = search(
            &[(&[], 100.0, 5.0, -50.0), (&[Coulomb], 1.0, 0.2, 0.0)],
            1,
            &[],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Explained);
        assert_eq!((decision.certain, decision.provisional), (1, None));
        assert_eq!(decision.remainder, 0.2);
    }

    /// A wheel that coasts down: dry friction and a current offset are the same torque, and much remains
    /// beside either.
    #[test]
    fn a_tie_that_takes_nearly_everything_is_taken_provisionally() {
        let found = search(
            &[
                (&[], 200_000.0, 458.0, -900.0),
                (&[Offset], 1_400.0, 38.0, 0.0),
                (&[WheelCoulomb], 1_400.0, 38.0, -0.1),
            ],
            1,
            &[1, 2],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Unexplained);
        // Every wheel has dry friction, not every amplifier an offset.
        assert_eq!((decision.certain, decision.provisional), (0, Some(2)));
        assert_eq!(decision.ties, [1, 2]);
        assert_eq!(decision.remainder, 38.0);
    }

    #[test]
    fn what_ties_share_is_certain() {
        let found = search(
            &[
                (&[], 100.0, 9.0, -50.0),
                (&[Coulomb], 30.0, 4.0, -20.0),
                (&[Presliding], 2.0, 0.5, 0.0),
                (&[Coulomb, Softening], 2.0, 0.5, -1.0),
            ],
            2,
            &[2, 3],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Ambiguous);
        assert_eq!((decision.certain, decision.provisional), (1, Some(2)));
    }

    /// An encoder with play on a soft base: an eccentricity is part of both explanations, and takes nothing away without
    /// the spring or the drag beside it.
    #[test]
    fn what_ties_share_and_takes_nothing_by_itself_is_not_certain() {
        let found = search(
            &[
                (&[], 300.0, 9.0, -50.0),
                (&[Coulomb], 90.0, 4.0, -20.0),
                (&[Coulomb, Eccentricity], 90.0, 4.0, -23.0),
                (&[Coulomb, Softening, Eccentricity], 2.0, 0.5, 0.0),
                (&[Coulomb, Drag, Eccentricity], 2.0, 0.5, -0.5),
            ],
            3,
            &[3, 4],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Ambiguous);
        assert_eq!(decision.certain, 1);
        assert!(matches!(decision.provisional, Some(3 | 4)));
        assert_eq!(decision.ties, [3, 4]);
    }

    /// A pendulum on a string before a camera: drag is common to both explanations, and next to nothing beside the zero of
    /// the angle, which a pull of the string may imitate.
    #[test]
    fn what_ties_share_comes_after_the_larger_cause_on_which_they_disagree() {
        let found = search(
            &[
                (&[], 1000.0, 30.0, -90.0),
                (&[Drag], 930.0, 29.0, -86.0),
                (&[Zero], 70.0, 8.0, -30.0),
                (&[Zero, Drag], 2.0, 0.5, 0.0),
                (&[Cable, Drag], 2.0, 0.5, -0.5),
            ],
            3,
            &[3, 4],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Ambiguous);
        assert_eq!((decision.certain, decision.provisional), (0, Some(3)));
        let path: Vec<_> = path(&found, 3)
            .into_iter()
            .map(|(effect, _)| effect)
            .collect();
        assert_eq!(path, [None, Some(Zero), Some(Drag)]);
    }

    #[test]
    fn ties_that_take_less_than_they_leave_are_none() {
        let found = search(
            &[
                (&[], 100.0, 9.0, -50.0),
                (&[Drag], 60.0, 7.0, -20.0),
                (&[Coulomb], 60.0, 7.0, -20.5),
            ],
            1,
            &[1, 2],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Unexplained);
        assert_eq!((decision.certain, decision.provisional), (0, None));
        assert!(decision.ties.is_empty());
    }

    /// A cube's short swing: dry friction and drag are common to both explanations, which leave much. Drag takes more
    /// than either leaves, though less than is left beside drag alone.
    #[test]
    fn what_ties_share_is_added_even_where_they_leave_much() {
        let found = search(
            &[
                (&[], 300.0, 30.0, -90.0),
                (&[Coulomb], 90.0, 8.0, -50.0),
                (&[Coulomb, Drag], 50.0, 5.0, -20.0),
                (&[Coulomb, Drag, Softening], 32.0, 3.5, 0.0),
                (&[Coulomb, Drag, Eccentricity], 32.0, 3.5, -0.5),
            ],
            3,
            &[3, 4],
        );
        let decision = of(&found);
        assert_eq!(decision.verdict, Verdict::Unexplained);
        assert_eq!((decision.certain, decision.provisional), (2, None));
        assert_eq!(decision.remainder, 5.0);
    }

    #[test]
    fn of_equally_usual_explanations_the_smaller_one_is_taken() {
        let found = search(
            &[
                (&[], 100.0, 9.0, -50.0),
                (&[Presliding], 2.0, 0.5, 0.0),
                (&[Drag], 2.0, 0.5, -1.0),
            ],
            1,
            &[1, 2],
        );
        assert_eq!(of(&found).provisional, Some(2));
    }
}
