//! The effects that could be missing, by probability.

use plant::EffectId;

use crate::pool::{Search, argmax};

/// Probabilities that differ by less than this rank by what each effect gains alone: evidences are known to
/// a small part of their unit, and what all but surely lacks, or all but surely does not, would be ordered
/// by that.
const RESOLUTION: f64 = 0.02;
/// A probability below this is none.
const NEGLIGIBLE: f64 = 1e-6;

/// An effect with its probability and the best candidate that has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// The effect.
    pub effect: EffectId,
    /// Probability that the model lacks it.
    pub probability: f64,
    /// Index of the candidate with the highest evidence that has it.
    pub index: usize,
}

/// The effects that could be missing, most probable first. `is_needless` says which candidates add to the best
/// one what no sensor would show: they have no vote. Every probability is lowered by the factor `is_genuine`.
pub fn ranked(found: &Search, is_needless: &[bool], is_genuine: f64) -> Vec<Ranked> {
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
            let probability = probability * is_genuine;
            let ranked = Ranked {
                effect,
                probability,
                index,
            };
            Some((ranked, alone))
        })
        .collect();
    ranked.sort_by(|(a, a_alone), (b, b_alone)| {
        (b.probability > NEGLIGIBLE)
            .cmp(&(a.probability > NEGLIGIBLE))
            .then(
                if a.probability > NEGLIGIBLE && (a.probability - b.probability).abs() > RESOLUTION
                {
                    b.probability.total_cmp(&a.probability)
                } else {
                    b_alone.total_cmp(a_alone)
                },
            )
    });
    ranked.into_iter().map(|(ranked, _)| ranked).collect()
}
