//! The way from the model as it was to the chosen candidate, one effect a step.

use plant::EffectId;

use crate::pool::{Search, argmax};

/// A step of the way: the effect that it adds (`None`: the model as it was) and the candidate where it ends.
pub type PathStep = (Option<EffectId>, usize);

/// The way from the model as it was to the chosen candidate, one effect a step: each time over the
/// candidate with the highest evidence of those that contain no other one on the way (dry friction
/// comes before the presliding that refines it).
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

/// The chosen candidate, or one before it on the way where the last additions took less than what remains
/// in the end: an unknown cause looks a little like everything, and what an effect takes of it is then not
/// its own. `excess` is what each candidate of the pool leaves, χ² beyond the noise.
pub fn without_absorbers(found: &Search, chosen: usize, excess: &[f64]) -> usize {
    let remains = excess[chosen];
    let mut chosen = chosen;
    while let [.., (_, before), (Some(_), _)] = path(found, chosen).as_slice() {
        if excess[*before] - excess[chosen] >= remains {
            break;
        }
        chosen = *before;
    }
    chosen
}
