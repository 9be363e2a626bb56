//! Two effects exchanged at once.
//!
//! Two explanations may imitate each other as pairs and not effect by effect: with the body clamped and the wheel
//! driven in one sense, a lag of the motor beside an offset of the current follows the log of a lagging speed sensor
//! beside dry friction, and neither mixture of the two does. (The sensor's lag also delays the friction that acts on
//! the wheel; an offset of the current acts without the motor's lag.) A search that exchanges one effect at a time does
//! not get from one pair to the other. Effects that are known to imitate each other say so
//! (`EffectInfo::confused_with`), so that few pairs have to be fitted.

use plant::EffectId;

use crate::candidate::Candidate;

fn imitates(effect: EffectId, other: EffectId) -> bool {
    effect.info().confused_with.contains(&other.name())
}

/// The candidates that have an imitation in the place of one effect of `chosen` and lack a second effect, by their
/// index in the pool, each with the imitations of that second effect among the `suspects`.
pub fn half_swapped(
    pool: &[Candidate],
    chosen: &Candidate,
    suspects: &[EffectId],
) -> Vec<(usize, Vec<EffectId>)> {
    let sets = pool.iter().map(Candidate::set);
    let found = sets.enumerate().filter_map(|(index, set)| {
        let completions = completions(&set, &chosen.set(), suspects);
        (!completions.is_empty()).then_some((index, completions))
    });
    found.collect()
}

fn completions(set: &[EffectId], chosen: &[EffectId], suspects: &[EffectId]) -> Vec<EffectId> {
    let without = |of: &[EffectId], those: &[EffectId]| -> Vec<EffectId> {
        let left = of.iter().copied().filter(|effect| !those.contains(effect));
        left.collect()
    };
    let (added, missing) = (without(set, chosen), without(chosen, set));
    let ([added], [first, second]) = (&added[..], &missing[..]) else {
        return vec![];
    };
    let completes = |effect: EffectId| {
        effect != *added
            && (imitates(*added, *first) && imitates(effect, *second)
                || imitates(*added, *second) && imitates(effect, *first))
    };
    let suspects = suspects.iter().copied();
    suspects.filter(|&effect| completes(effect)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_is_exchanged_for_the_pair_of_its_imitations() {
        let chosen = [EffectId::MotorLag, EffectId::CurrentOffset];
        let all: Vec<EffectId> = EffectId::ALL.to_vec();
        let found = completions(&[EffectId::WheelSpeedLag], &chosen, &all);
        assert_eq!(found, [EffectId::WheelCoulombFriction]);
        // One effect exchanged, or none, is the work of the search itself.
        assert_eq!(completions(&[EffectId::MotorLag], &chosen, &all), []);
        // What imitates neither begins no such pair.
        assert_eq!(completions(&[EffectId::WheelCogging], &chosen, &all), []);
        // A third effect stays.
        let three = [EffectId::WheelQuadraticDrag, chosen[0], chosen[1]];
        let begun = [EffectId::WheelQuadraticDrag, EffectId::WheelSpeedLag];
        let found = completions(&begun, &three, &all);
        assert_eq!(found, [EffectId::WheelCoulombFriction]);
    }
}
