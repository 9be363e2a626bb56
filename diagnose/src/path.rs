//! The path from the starting model to the chosen candidate, one effect per step.

use plant::EffectId;

use crate::pool::{Search, argmax};

/// A step of the path: the effect that it adds (`None` for the starting model), and the index of the candidate.
pub type PathStep = (Option<EffectId>, usize);

/// The path from the starting model to the chosen candidate, one effect per step. Each step takes, of the candidates
/// on the way that contain no other candidate on the way, the one with the highest evidence. Dry friction therefore
/// comes before the presliding that refines it.
pub fn path(found: &Search, chosen: usize) -> Vec<PathStep> {
    let mut path = vec![(None, 0)];
    let mut current = 0;
    while current != chosen {
        let on_the_way: Vec<usize> = (0..found.pool.len())
            .filter(|&index| {
                index != current
                    && (index == chosen || found.pool[chosen].strictly_contains(&found.pool[index]))
                    && found.pool[index].strictly_contains(&found.pool[current])
                    && new_effects(found, current, index).len() == 1
            })
            .collect();
        let next = argmax(
            &found.evidence,
            on_the_way.iter().copied().filter(|&index| {
                !on_the_way
                    .iter()
                    .any(|&other| found.pool[index].strictly_contains(&found.pool[other]))
            }),
        );
        let next = next.unwrap_or(chosen);
        for effect in new_effects(found, current, next) {
            path.push((Some(effect), next));
        }
        if next == current {
            break;
        }
        current = next;
    }
    path
}

fn new_effects(found: &Search, from: usize, to: usize) -> Vec<EffectId> {
    found.pool[to]
        .added
        .iter()
        .copied()
        .filter(|effect| !found.pool[from].added.contains(effect))
        .collect()
}

/// The chosen candidate, or an earlier one on its path if the last additions explained less than `remains`, the χ²
/// that the final explanation leaves beyond the noise. Every effect can imitate a part of an unknown cause, so such an
/// addition is not trusted. `excess` is the χ² beyond the noise that each candidate of the pool leaves.
pub fn without_absorbers(found: &Search, chosen: usize, excess: &[f64], remains: f64) -> usize {
    let mut chosen = chosen;
    while let [.., (_, before), (Some(_), _)] = path(found, chosen).as_slice() {
        if excess[*before] - excess[chosen] >= remains {
            break;
        }
        chosen = *before;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use EffectId::{
        BodyCoulombFriction as Coulomb, BodyPreslidingFriction as Presliding,
        BodyQuadraticDrag as Drag, BodySofteningSpring as Spring,
    };

    use super::*;
    use crate::hand_made::search;

    #[test]
    fn the_way_goes_over_the_best_evidence_one_effect_a_step() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -50.0),
                (&[Coulomb], 60.0, 3.0, -25.0),
                (&[Drag], 40.0, 2.0, -20.0),
                (&[Drag, Coulomb], 10.0, 0.0, -5.0),
                (&[Spring], 5.0, 0.0, -1.0),
            ],
            3,
            &[],
        );
        let expected = [(None, 0), (Some(Drag), 2), (Some(Coulomb), 3)];
        assert_eq!(path(&found, 3), expected);
        assert_eq!(path(&found, 0), [(None, 0)]);
    }

    #[test]
    fn what_is_refined_comes_before_its_refinement() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -50.0),
                (&[Presliding], 10.0, 0.0, -5.0),
                (&[Coulomb], 30.0, 1.0, -15.0),
            ],
            1,
            &[],
        );
        assert_eq!(
            path(&found, 1),
            [(None, 0), (Some(Coulomb), 2), (Some(Presliding), 1)]
        );
    }

    #[test]
    fn a_set_that_was_reached_at_once_is_a_step_for_each_effect() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -50.0),
                (&[Drag, Coulomb], 10.0, 0.0, -5.0),
            ],
            1,
            &[],
        );
        assert_eq!(
            path(&found, 1),
            [(None, 0), (Some(Drag), 1), (Some(Coulomb), 1)]
        );
    }

    #[test]
    fn an_addition_that_takes_less_than_remains_is_given_back() {
        let found = search(
            &[
                (&[], 100.0, 9.0, -50.0),
                (&[Drag], 40.0, 5.0, -30.0),
                (&[Drag, Coulomb], 30.0, 4.0, -25.0),
            ],
            2,
            &[],
        );
        // Coulomb friction takes 10 where 30 remain, drag 60 where 30 remain.
        assert_eq!(without_absorbers(&found, 2, &[100.0, 40.0, 30.0], 30.0), 1);
        // Where next to nothing remains, every addition is its own.
        assert_eq!(without_absorbers(&found, 2, &[75.0, 15.0, 5.0], 5.0), 2);
        // Where nearly all remains, none is.
        assert_eq!(without_absorbers(&found, 2, &[100.0, 95.0, 90.0], 90.0), 0);
    }
}
