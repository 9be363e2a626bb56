//! The contents of the report of a diagnosis: steps, suspects, and the details of each.

use crate::next_experiment::Recipe;
use bench_files::numbers::significant;
use std::collections::{BTreeMap, BTreeSet};

use identify::{Cancelled, Contradiction, Fit, FitProblem, Minimum, finish};
use parallel::parallel_map;
use plant::{EffectId, Model};

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

/// A step of the report: the diagnosed model, or the model after one more effect.
#[derive(Clone, Debug)]
pub struct Step {
    /// The effect that was added; `None` for the diagnosed model and for a step that only removes effects.
    pub effect: Option<EffectId>,
    /// The effects of the previous model that the step removed.
    pub replaces: Vec<EffectId>,
    /// Whether the step is provisional: an experiment must decide between explanations that tie.
    pub is_provisional: bool,
    /// The fit with standard errors.
    pub fit: Fit,
    /// The candidate of this step; its added effects are those beyond the starting model of the search.
    pub candidate: Candidate,
    /// Mean fit in percent on held-out data; NaN if there are none.
    pub validation_fit_percent: f64,
    /// Every held-out series, with its prediction error.
    pub held_out: Vec<HeldOut>,
    /// Which data were held out.
    pub unseen: Unseen,
    /// Whether the previous step predicts the held-out data plainly better.
    pub is_held_out_worse: bool,
}

impl Step {
    /// Builds a step with this fit.
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

    /// Builds a step whose fit uses all samples of the bench. The held-out predictions come from the thinned logs.
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
    /// The best model that has the effect. All other fields belong to this model.
    pub model: Model,
    /// Its fit.
    pub fit: Fit,
    /// Root mean square errors of all series, each in the unit of its channel; record by record.
    pub rmse: Vec<f64>,
    /// For every series, the share of the error that the effect removes: 1 − with/without. "Without" is the same model,
    /// fitted again without the effect. Negative where the error grows.
    pub takes_away: Vec<f64>,
    /// Mean fit in percent on held-out data; NaN if there are none.
    pub validation_fit_percent: f64,
    /// One sentence: what the effect looks like in the data, and how far the error falls with it.
    pub fingerprint: String,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The model with all effects that are certain.
    pub certain: Model,
    /// The diagnosed model, then one step for each change.
    pub steps: Vec<Step>,
    /// The effects that could be missing, most probable first.
    pub suspects: Vec<Suspect>,
    /// The sets of effects that tie; empty if none do.
    pub ambiguous_between: Vec<Vec<EffectId>>,
    /// The experiment that would settle an open question, in one sentence; empty if no question is open.
    pub next_experiment: String,
    /// The same as a recipe, where it tells the first two sets that tie apart.
    pub recipe: Option<Recipe>,
    /// The structured remainder of the last step in units of the noise of its worst series.
    pub remainder: f64,
    /// The size of the residual: against noise, against signal, and as a torque.
    pub remains: Remains,
    /// If the last step explains every log by itself: the plain contradictions that are left between experiments, or
    /// between an experiment and a stated value.
    pub contradictions: Vec<Contradiction>,
}

impl Diagnosis {
    /// The last step: its model is the one to be used for predictions.
    pub fn last(&self) -> Option<&Step> {
        self.steps.last()
    }

    /// The certain effects beyond the base model, in the order of the library.
    pub fn certain_effects(&self) -> Vec<EffectId> {
        let base = Model::base();
        let effects = self.certain.effects().iter().copied();
        effects.filter(|effect| !base.has(*effect)).collect()
    }
}

/// Details of a candidate: standard errors, and held-out prediction.
pub struct Look {
    /// The fit with standard errors.
    pub fit: Fit,
    /// Every held-out series, with its prediction error.
    pub held_out: Vec<HeldOut>,
    /// Which data were held out.
    pub unseen: Unseen,
}

/// Computes the details of these candidates of the pool, each one once.
pub fn looks(
    bench: &SearchBench,
    found: &Search,
    indices: impl Iterator<Item = usize>,
) -> Result<BTreeMap<usize, Look>, Cancelled> {
    let indices: BTreeSet<usize> = indices.collect();
    parallel_map(indices, |index| {
        bench.check()?;
        let candidate = &found.pool[index];
        let (model, minimum) = (&candidate.model, &candidate.minimum);
        let free = bench.problem.free(model);
        // What its cause cannot have predicts nothing, and such a fit may run away where there are fewer data.
        let (unseen, held_out) = if candidate.is_unphysical(bench.thresholds.unphysical) {
            (Unseen::SecondHalves, vec![])
        } else {
            held_out(bench, model, minimum)
        };
        bench.check()?;
        let look = Look {
            fit: finish(&bench.records, model, &free, minimum.clone()),
            held_out,
            unseen,
        };
        Ok((index, look))
    })
    .into_iter()
    .collect()
}

/// Builds the suspects of the report.
pub fn suspects(
    bench: &SearchBench,
    found: &Search,
    looks: &BTreeMap<usize, Look>,
    ranked: Vec<Ranked>,
) -> Result<Vec<Suspect>, Cancelled> {
    parallel_map(ranked, |one| suspect(bench, found, &looks[&one.index], one))
        .into_iter()
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
        fingerprint: fingerprint(bench, candidate, ranked.effect, [&rmse_without, &rmse_with]),
        takes_away: rmse_with.iter().zip(&rmse_without).map(share).collect(),
        rmse: rmse_with,
        validation_fit_percent: mean_fit_percent(&look.held_out),
        fit: look.fit.clone(),
    })
}

/// What the effect looks like in the data, the series in which it helps most, and why it explains nothing if its cause
/// cannot have the value of the fit.
fn fingerprint(
    bench: &SearchBench,
    candidate: &Candidate,
    effect: EffectId,
    [rmse_without, rmse_with]: [&[f64]; 2],
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
    let helps = match best {
        Some(((record, channel), before, after)) if before > after => format!(
            "{text}; with it the error of {}/{} falls from {} to {} times the noise of \
             the sensor",
            record.name,
            channel.output.name(),
            significant(before, 3),
            significant(after, 3)
        ),
        _ => text.to_owned(),
    };
    let sigmas = bench.thresholds.unphysical;
    let mut values = candidate.unphysical.iter();
    match values.find(|one| one.effect == effect && one.sigmas() > sigmas) {
        Some(one) => format!("{helps}; it explains nothing, because {}", one.why()),
        None => helps,
    }
}
