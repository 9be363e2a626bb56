//! The rivals of the truth: other explanations that the logs allow, found by refitting.

use std::sync::Arc;

use diagnose::{Candidate, Round, SearchBench, Thresholds, largest_trace, prepared, try_all};
use identify::{
    Cancelled, Effort, FitProblem, Minimum, Progress, final_windows, fit_from_scratch, refit,
};
use plant::{EffectId, Model};

use crate::answer::Answer;

/// A rival at less than this distance cannot be distinguished from the truth, because the odds are 4 to one at most. A
/// confident answer is then luck.
pub const EQUAL: f64 = 3.0;
/// Up to this distance (odds of 400 to one), "ambiguous" is as right as the truth.
pub const CLOSE: f64 = 12.0;
/// χ² per observation above which the fit of the true set has not reached its minimum.
const BAD: f64 = 1.3;

/// A set of effects that was refitted as an alternative to the truth.
pub struct Rival {
    /// The set.
    pub set: Vec<EffectId>,
    /// Difference of χ² from the truth, plus ln n for every parameter that the rival has more than the truth.
    pub distance: f64,
    /// Whether the rival has fewer parameters than the truth.
    pub simpler: bool,
    /// For a set that the truth contains: the trace of the missing effects, in units of noise.
    pub lacks: Option<f64>,
}

/// Fits the true set of effects, started at its true parameters as far as they are known.
pub fn fitted(
    problem: &FitProblem,
    base: &Minimum,
    effects: &[EffectId],
    answer: &Answer,
) -> Candidate {
    let records = problem.all_records();
    let model = effects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    let mut values = problem.start_values(&model);
    for (position, info) in model.parameters().iter().enumerate() {
        let known = answer.parameters.iter().find(|(name, _)| name == info.name);
        if let Some((_, value)) = known {
            values[position] = *value;
        } else if let Some(at) = Model::base().position_of(info.name) {
            values[position] = base.values[at];
        }
    }
    for (value, known) in values.iter_mut().zip(problem.known) {
        *value = known.unwrap_or(*value);
    }
    let free = problem.free(&model);
    // The initial states of the logs are taken once from the samples and once from the base fit; the fit of lower cost
    // counts. If both fits are bad, the schedule from short windows finds a better one.
    let guessed = records
        .iter()
        .map(|record| final_windows(record, &values))
        .collect();
    let minimum = [guessed, base.windows.clone()]
        .into_iter()
        .map(|windows| {
            refit(
                &records,
                &model,
                values.clone(),
                windows,
                &free,
                Effort::FULL,
            )
        })
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .unwrap_or_else(|| base.clone());
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let minimum = if minimum.cost > BAD * observations as f64 {
        let again = fit_from_scratch(&records, &model, values, &free, Effort::FULL);
        if again.cost < minimum.cost {
            again
        } else {
            minimum
        }
    } else {
        minimum
    };
    Candidate::new(problem, &records, effects.to_vec(), model, minimum, None)
}

/// All sets that could replace the true one, by distance, and the traces of the true set.
///
/// # Errors
/// [`Cancelled`] if the work is cancelled.
pub fn rivals(
    problem: &FitProblem,
    base: &Minimum,
    answer: &Answer,
    suspects: &[EffectId],
    progress: &Progress,
) -> Result<(Vec<Rival>, Vec<f64>), Cancelled> {
    let thresholds = Thresholds::default();
    let records = problem.all_records();
    let truth = fitted(problem, base, &answer.effects, answer);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let each = (observations.max(2) as f64).ln();
    let mut candidates: Vec<Candidate> = vec![];
    let mut shown = vec![];
    let start = Candidate::new(problem, &records, vec![], Model::base(), base.clone(), None);
    candidates.push(start.clone());
    let mut froms = vec![start];
    for effect in &answer.effects {
        let mut rest = answer.effects.clone();
        rest.retain(|other| other != effect);
        if rest.is_empty() {
            shown.push(largest_trace(&records, &froms[0], &truth));
        } else {
            let without = fitted(problem, base, &rest, answer);
            shown.push(largest_trace(&records, &without, &truth));
            candidates.push(without.clone());
            froms.push(without);
        }
    }
    for from in froms {
        let whole = SearchBench::whole(
            problem,
            suspects,
            &thresholds,
            progress.cancelled,
            Arc::default(),
        );
        let (bench, from) = prepared(&whole, from)?;
        let round = Round {
            most: usize::MAX,
            is_fitted: &|_| false,
            leader: None,
            only_where_something_remains: false,
        };
        candidates.extend(try_all(&bench, &from, &round)?);
    }
    let mut rivals: Vec<Rival> = vec![];
    for candidate in candidates {
        let set = candidate.set();
        // A larger set that contains the truth is no rival, because the diagnosis prefers the simpler set anyway.
        if set == answer.effects || candidate.strictly_contains(&truth) {
            continue;
        }
        let more = candidate.parameters as f64 - truth.parameters as f64;
        let distance = candidate.minimum.cost - truth.minimum.cost + each * more;
        let lacks = truth
            .strictly_contains(&candidate)
            .then(|| largest_trace(&records, &candidate, &truth));
        let counts = distance < CLOSE || lacks.is_some();
        if counts && !rivals.iter().any(|rival| rival.set == set) {
            rivals.push(Rival {
                set,
                distance,
                simpler: candidate.parameters < truth.parameters,
                lacks,
            });
        }
    }
    rivals.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    Ok((rivals, shown))
}
