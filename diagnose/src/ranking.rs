//! The effects that could be missing, ordered by probability.

use plant::EffectId;

use crate::pool::{Search, argmax};

/// Width of the bins in which probabilities are compared. Evidence is known only to a small part of its unit, so
/// smaller differences would order effects arbitrarily. Within a bin, the gain of each effect alone decides.
const RESOLUTION: f64 = 0.02;
/// A probability up to this value counts as zero.
const NEGLIGIBLE: f64 = 1e-6;

/// The bin of a probability: its nearest multiple of [`RESOLUTION`], or −1 for a negligible one.
fn bin(probability: f64) -> i64 {
    if probability <= NEGLIGIBLE {
        -1
    } else {
        (probability / RESOLUTION).round() as i64
    }
}

/// An effect with its probability, and the best candidate that has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// The effect.
    pub effect: EffectId,
    /// Probability, from 0 to 1, that the model lacks the effect.
    pub probability: f64,
    /// Index of the candidate of highest evidence among those with the effect.
    pub index: usize,
}

/// The effects that could be missing, most probable first. A candidate with `is_needless` set adds to the best one
/// something that no sensor would show; it has no vote. The probability of each effect is multiplied by
/// `is_genuine` of that effect.
pub fn ranked(
    found: &Search,
    is_needless: &[bool],
    is_genuine: impl Fn(EffectId) -> f64,
) -> Vec<Ranked> {
    let votes: Vec<f64> = found
        .evidence
        .iter()
        .zip(is_needless)
        .map(|(evidence, &needless)| {
            if needless {
                0.0
            } else {
                (evidence - found.evidence[found.best]).min(0.0).exp()
            }
        })
        .collect();
    let total: f64 = votes.iter().sum();
    let mut seen: Vec<EffectId> = found
        .pool
        .iter()
        .flat_map(|candidate| candidate.added.clone())
        .collect();
    seen.sort();
    seen.dedup();
    let base = &found.pool[0];
    let mut ranked: Vec<(Ranked, f64)> = seen
        .into_iter()
        .filter_map(|effect| {
            let with = |index: &usize| found.pool[*index].added.contains(&effect);
            let probability: f64 = (0..found.pool.len())
                .filter(|index| with(index))
                .map(|index| votes[index])
                .sum::<f64>()
                / total;
            let index = argmax(&found.evidence, (0..found.pool.len()).filter(with))?;
            let alone = found
                .pool
                .iter()
                .filter(|candidate| candidate.added == [effect])
                .map(|candidate| base.minimum.cost - candidate.minimum.cost)
                .fold(0.0, f64::max);
            let probability = probability * is_genuine(effect);
            let ranked = Ranked {
                effect,
                probability,
                index,
            };
            Some((ranked, alone))
        })
        .collect();
    // A total order: by bin, then by the gain of the effect alone, then by the order of the library.
    ranked.sort_by(|(a, a_alone), (b, b_alone)| {
        bin(b.probability)
            .cmp(&bin(a.probability))
            .then(b_alone.total_cmp(a_alone))
    });
    ranked.into_iter().map(|(ranked, _)| ranked).collect()
}

#[cfg(test)]
mod tests {
    use EffectId::{
        BodyCoulombFriction as Coulomb, BodyQuadraticDrag as Drag, BodySofteningSpring as Spring,
        CurrentOffset as Offset,
    };

    use super::*;
    use crate::hand_made::search;

    fn order(found: &Search, is_needless: &[bool]) -> Vec<EffectId> {
        let ranked = ranked(found, is_needless, |_| 1.0);
        ranked.into_iter().map(|one| one.effect).collect()
    }

    #[test]
    fn probabilities_are_shares_of_the_evidence() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -90.0),
                (&[Coulomb], 10.0, 0.0, 0.0),
                (&[Drag], 12.0, 0.0, -(3f64.ln())),
                (&[Coulomb, Spring], 10.0, 0.0, 0.0),
            ],
            1,
            &[],
        );
        // Votes 1 and 1/3; the set with the spring adds what no sensor shows and has none.
        let ranked = ranked(&found, &[false, false, false, true], |_| 0.5);
        let expected = [(Coulomb, 0.375, 3), (Drag, 0.125, 2), (Spring, 0.0, 3)];
        for (one, (effect, probability, index)) in ranked.iter().zip(expected) {
            assert_eq!((one.effect, one.index), (effect, index));
            assert!((one.probability - probability).abs() < 1e-12, "{one:?}");
        }
    }

    #[test]
    fn what_has_no_probability_is_ranked_by_what_it_gains_alone() {
        let found = search(
            &[
                (&[], 100.0, 5.0, -90.0),
                (&[Coulomb], 10.0, 0.0, 0.0),
                (&[Drag], 80.0, 3.0, -60.0),
                (&[Spring], 50.0, 3.0, -70.0),
            ],
            1,
            &[],
        );
        assert_eq!(order(&found, &[false; 4]), [Coulomb, Spring, Drag]);
    }

    /// Probabilities 0.345, 0.335 and 0.32, each within 0.02 of the next but not the first of the last, with gains the
    /// other way round: a comparison with a tolerance has no order for them.
    #[test]
    fn the_order_is_total() {
        let tried: [(&[EffectId], f64, f64, f64); 4] = [
            (&[], 100.0, 5.0, -90.0),
            (&[Coulomb], 30.0, 0.0, 0.0),
            (&[Drag], 20.0, 0.0, (0.335f64 / 0.345).ln()),
            (&[Offset], 10.0, 0.0, (0.32f64 / 0.345).ln()),
        ];
        let expected = order(&search(&tried, 1, &[]), &[false; 4]);
        assert_eq!(expected, [Drag, Coulomb, Offset]);
        // However the pool is ordered.
        for turn in 0..3 {
            let mut turned = tried;
            turned[1..].rotate_left(turn);
            let best = 1 + (3 - turn) % 3;
            assert_eq!(order(&search(&turned, best, &[]), &[false; 4]), expected);
        }
    }
}
