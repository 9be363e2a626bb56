//! What a diagnosis reports: steps, suspects, and a closer look at each.

use std::collections::{BTreeMap, BTreeSet};

use identify::{Cancelled, Contradiction, Fit, FitProblem, Minimum, finish};
use plant::{EffectId, Model};
use rayon::prelude::*;

use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::pool::Search;
use crate::ranking::Ranked;
use crate::remainder::noise;
use crate::remains::Remains;
use crate::steps::Planned;
use crate::trial::without;
use crate::validation::{HeldOut, Unseen, held_out, mean_fit_percent};
use crate::verdict::Verdict;

/// The model as it was, or after one effect more.
#[derive(Clone, Debug)]
pub struct Step {
    /// The effect that was added; `None` for the model as it was, and for a step that only takes out.
    pub effect: Option<EffectId>,
    /// The effects of the model before that are no longer there.
    pub replaces: Vec<EffectId>,
    /// Whether it holds until an experiment has decided between explanations that tie.
    pub is_provisional: bool,
    /// The fit with standard errors.
    pub fit: Fit,
    /// The candidate that it came from; its added effects are those beyond the base model.
    pub candidate: Candidate,
    /// Mean fit percent on what the fit has not seen; NaN if there is none.
    pub validation_fit_percent: f64,
    /// The same series by series, with the errors.
    pub held_out: Vec<HeldOut>,
    /// What that is.
    pub unseen: Unseen,
    /// Whether the step before predicts it plainly better.
    pub is_held_out_worse: bool,
}

impl Step {
    /// A step with this fit.
    pub fn new(planned: Planned, look: &Look, candidate: Candidate, fit: Fit) -> Step {
        Step {
            effect: planned.effect,
            replaces: planned.replaces,
            is_provisional: planned.is_provisional,
            fit,
            candidate,
            validation_fit_percent: mean_fit_percent(&look.held_out),
            held_out: look.held_out.clone(),
            unseen: look.unseen,
            is_held_out_worse: false,
        }
    }

    /// A step whose fit is made with all samples of the bench; what the fit has not seen is predicted
    /// with the thinned ones.
    pub fn whole(
        problem: &FitProblem,
        planned: Planned,
        look: &Look,
        thinned: &Candidate,
        minimum: Minimum,
    ) -> Step {
        let records = problem.all_records();
        let (added, model) = (thinned.added.clone(), thinned.model.clone());
        let fit = finish(&records, &model, &problem.free(&model), minimum.clone());
        let candidate = Candidate::new(problem, &records, added, model, minimum, None);
        Step::new(planned, look, candidate, fit)
    }
}

/// An effect that could be missing.
#[derive(Clone, Debug)]
pub struct Suspect {
    /// The effect.
    pub effect: EffectId,
    /// Probability that the model lacks it.
    pub probability: f64,
    /// The best model that has it: everything else here belongs to it.
    pub model: Model,
    /// Its fit.
    pub fit: Fit,
    /// Root mean square errors of all series with it, record by record.
    pub rmse: Vec<f64>,
    /// For every series the share of the error that the effect alone takes away: 1 − with/without, where "without"
    /// is the same model without the effect, fitted anew. Negative where the error grows.
    pub takes_away: Vec<f64>,
    /// Mean fit percent on what the fit has not seen; NaN if there is none.
    pub validation_fit_percent: f64,
    /// One sentence: what to look for, and what the fit gains by it.
    pub fingerprint: String,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The model with everything that is certain.
    pub certain: Model,
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
    /// The same against the signal and as a torque.
    pub remains: Remains,
    /// Where the last step explains all logs by themselves: knowns and experiments that contradict each other all
    /// the same, plainly.
    pub contradictions: Vec<Contradiction>,
}

impl Diagnosis {
    /// The last step: the model that predicts from now on.
    pub fn last(&self) -> Option<&Step> {
        self.steps.last()
    }

    /// The effects beyond the base model that are certain, in the order of the library.
    pub fn certain_effects(&self) -> Vec<EffectId> {
        let base = Model::base();
        let effects = self.certain.effects().iter().copied();
        effects.filter(|effect| !base.has(*effect)).collect()
    }
}

/// A closer look at a candidate: its standard errors, and how it predicts what it has not seen.
pub struct Look {
    /// The fit with standard errors.
    pub fit: Fit,
    /// Every series, predicted by parameters that have not seen it.
    pub held_out: Vec<HeldOut>,
    /// What they have not seen.
    pub unseen: Unseen,
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
            let (unseen, held_out) = held_out(bench, model, minimum);
            bench.check()?;
            let look = Look {
                fit: finish(&bench.records, model, &free, minimum.clone()),
                held_out,
                unseen,
            };
            Ok((index, look))
        })
        .collect()
}

/// The suspects as they are reported.
pub fn suspects(
    bench: &SearchBench,
    found: &Search,
    looks: &BTreeMap<usize, Look>,
    ranked: Vec<Ranked>,
) -> Result<Vec<Suspect>, Cancelled> {
    ranked
        .into_par_iter()
        .map(|one| suspect(bench, found, &looks[&one.index], one))
        .collect()
}

fn suspect(
    bench: &SearchBench,
    found: &Search,
    look: &Look,
    ranked: Ranked,
) -> Result<Suspect, Cancelled> {
    let candidate = &found.pool[ranked.index];
    let model = candidate.model.without(ranked.effect);
    let known = found.pool.iter().find(|one| one.model == model);
    let fitted = match known {
        Some(_) => None,
        None => without(bench, candidate, ranked.effect, &|_| None)?,
    };
    let rmse_with = candidate.rmse();
    let rmse_without = known.or(fitted.as_ref()).map(Candidate::rmse);
    let rmse_without = rmse_without.unwrap_or_else(|| rmse_with.clone());
    let share = |(with, without): (&f64, &f64)| {
        if *without > 0.0 {
            1.0 - with / without
        } else {
            0.0
        }
    };
    Ok(Suspect {
        effect: ranked.effect,
        probability: ranked.probability,
        model: candidate.model.clone(),
        fingerprint: fingerprint(bench, ranked.effect, &rmse_without, &rmse_with),
        takes_away: rmse_with.iter().zip(&rmse_without).map(share).collect(),
        rmse: rmse_with,
        validation_fit_percent: mean_fit_percent(&look.held_out),
        fit: look.fit.clone(),
    })
}

/// What a person would look for, and the series in which the effect helps most.
fn fingerprint(
    bench: &SearchBench,
    effect: EffectId,
    rmse_without: &[f64],
    rmse_with: &[f64],
) -> String {
    let names = bench
        .records
        .iter()
        .flat_map(|record| record.channels.iter().map(move |channel| (record, channel)));
    let best = names
        .zip(rmse_without.iter().zip(rmse_with))
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
