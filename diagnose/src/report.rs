//! What a diagnosis reports: steps, suspects, and a closer look at each.

use std::collections::{BTreeMap, BTreeSet};

use identify::{Cancelled, Fit, FitProblem, Minimum, finish};
use plant::EffectId;
use rayon::prelude::*;

use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::pool::Search;
use crate::ranking::Ranked;
use crate::remainder::noise;
use crate::validation::{HeldOut, held_out, mean_fit_percent};
use crate::verdict::Verdict;

/// The model as it was, or after one effect more.
#[derive(Clone, Debug)]
pub struct Step {
    /// The effect that was added; `None` for the model as it was.
    pub effect: Option<EffectId>,
    /// The fit with standard errors.
    pub fit: Fit,
    /// The candidate that it came from.
    pub candidate: Candidate,
    /// Mean fit percent on experiments that the fit has not seen; NaN if there is none.
    pub validation_fit_percent: f64,
    /// The same series by series, with the errors.
    pub held_out: Vec<HeldOut>,
}

/// An effect that could be missing.
#[derive(Clone, Debug)]
pub struct Suspect {
    /// The effect.
    pub effect: EffectId,
    /// Probability that the model lacks it.
    pub probability: f64,
    /// The best model that has it.
    pub fit: Fit,
    /// Root mean square errors of all series with it, record by record.
    pub rmse: Vec<f64>,
    /// Mean fit percent on experiments that the fit has not seen; NaN if there is none.
    pub validation_fit_percent: f64,
    /// One sentence: what to look for, and what the fit gains by it.
    pub fingerprint: String,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The model as it was, then each effect added.
    pub steps: Vec<Step>,
    /// The effects that could be missing, most probable first.
    pub suspects: Vec<Suspect>,
    /// The sets of effects that tie; empty where none do.
    pub ambiguous_between: Vec<Vec<EffectId>>,
    /// The experiment that would settle what is open, in one sentence; empty where nothing is.
    pub next_experiment: String,
    /// The structured remainder of the last step in units of the noise of its worst series.
    pub remainder: f64,
}

impl Diagnosis {
    /// The last step: the model with everything that could be added.
    pub fn last(&self) -> Option<&Step> {
        self.steps.last()
    }
}

/// A closer look at a candidate: its standard errors, and how it predicts what it has not seen.
pub struct Look {
    /// The fit with standard errors.
    pub fit: Fit,
    /// Every series, predicted by parameters that have not seen its experiment.
    pub held_out: Vec<HeldOut>,
}

/// A look at each of these candidates of the pool, once.
pub fn looks(
    bench: &SearchBench,
    found: &Search,
    indices: impl Iterator<Item = usize>,
) -> Result<BTreeMap<usize, Look>, Cancelled> {
    let indices: BTreeSet<usize> = indices.collect();
    indices
        .into_par_iter()
        .map(|index| {
            bench.check()?;
            let candidate = &found.pool[index];
            let (model, minimum) = (&candidate.model, &candidate.minimum);
            let free = bench.problem.free(model);
            let look = Look {
                fit: finish(&bench.records, model, &free, minimum.clone()),
                held_out: held_out(bench, model, minimum),
            };
            Ok((index, look))
        })
        .collect()
}

/// A step whose fit is made with all samples of the bench; what the fit has not seen is predicted
/// with the thinned ones.
pub fn whole_step(
    problem: &FitProblem,
    effect: Option<EffectId>,
    candidate: &Candidate,
    minimum: Minimum,
    look: &Look,
) -> Step {
    let records = problem.all_records();
    let (added, model) = (candidate.added.clone(), candidate.model.clone());
    Step {
        effect,
        fit: finish(&records, &model, &problem.free(&model), minimum.clone()),
        validation_fit_percent: mean_fit_percent(&look.held_out),
        held_out: look.held_out.clone(),
        candidate: Candidate::new(problem, &records, added, model, minimum, None),
    }
}

/// A suspect as it is reported.
pub fn suspect(bench: &SearchBench, found: &Search, look: &Look, ranked: Ranked) -> Suspect {
    let (base, candidate) = (&found.pool[0], &found.pool[ranked.index]);
    Suspect {
        effect: ranked.effect,
        probability: ranked.probability,
        fingerprint: fingerprint(bench, ranked.effect, base, candidate),
        rmse: candidate.rmse(),
        validation_fit_percent: mean_fit_percent(&look.held_out),
        fit: look.fit.clone(),
    }
}

/// What a person would look for, and the series in which the effect helps most.
fn fingerprint(
    bench: &SearchBench,
    effect: EffectId,
    base: &Candidate,
    with: &Candidate,
) -> String {
    let names = bench
        .records
        .iter()
        .flat_map(|record| record.channels.iter().map(move |channel| (record, channel)));
    let best = names
        .zip(base.rmse().into_iter().zip(with.rmse()))
        .zip(noise(&bench.records))
        .map(|((name, (before, after)), noise)| (name, before / noise, after / noise))
        .max_by(|a, b| (a.1 - a.2).total_cmp(&(b.1 - b.2)));
    let text = effect.info().fingerprint;
    match best {
        Some(((record, channel), before, after)) if before > after => format!(
            "{text}; with it the error of {}/{} falls from {before:.2} to {after:.2} times the noise of \
             the sensor",
            record.name,
            channel.output.name(),
        ),
        _ => text.to_owned(),
    }
}
