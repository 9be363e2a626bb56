//! The diagnosis of a fitted model, from the logs to the verdict.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::sync::Arc;

use identify::{
    Cancelled, Effort, FitProblem, IdentifyError, Minimum, Progress, carry_over, contradictions,
    extend, fit_until, joined, refit,
};
use parallel::parallel_map;
use plant::{EffectId, Model};

use crate::applicable::is_cleared;
use crate::bench::{IsCancelled, SearchBench};
use crate::candidate::Candidate;
use crate::decision::{Decision, decide};
use crate::economy::{MOST_REVISIONS, MOST_SUSPECTS, SAMPLES_PER_PERIOD};
use crate::evidence::imitation;
use crate::genuine::genuine;
use crate::imperfection::Imperfections;
use crate::next_experiment::propose;
use crate::open::without_open;
use crate::pool::Search;
use crate::ranking::{Ranked, ranked};
use crate::remains::remains;
use crate::report::{Diagnosis, Look, Step, looks, suspects};
use crate::search::search;
use crate::short_windows::shows_in_short_windows;
use crate::shown::shows;
use crate::steps::{Planned, planned};
use crate::thinned::{is_thinned, whole_fit, windows_at};
use crate::thresholds::Thresholds;
use crate::validation::is_worse;
use crate::verdict::Verdict;

/// The settings of a diagnosis.
#[derive(Clone, Debug)]
pub struct Options<'a> {
    /// The effects that are suspects.
    pub suspects: &'a [EffectId],
    /// The numbers that decide verdicts.
    pub thresholds: Thresholds,
}

impl Default for Options<'_> {
    /// All effects of the library, with the default thresholds.
    fn default() -> Self {
        Options {
            suspects: EffectId::ALL,
            thresholds: Thresholds::default(),
        }
    }
}

/// Diagnoses a fitted model. The search starts from the base model with those effects of `model` that are not
/// suspects (the "starting model"). Its result therefore does not depend on which suspects `model` has.
///
/// # Errors
/// [`Cancelled`] soon after `progress` answers that the work is called off.
pub fn diagnose_with(
    problem: &FitProblem,
    model: &Model,
    minimum: Minimum,
    options: &Options,
    progress: &Progress,
) -> Result<Diagnosis, Cancelled> {
    progress.check()?;
    let suspects = suspects_of(problem, options.suspects);
    let options = &Options {
        suspects: &suspects,
        thresholds: options.thresholds.clone(),
    };
    let ground = ground_of(model, options.suspects);
    let given = (model, &minimum);
    let from_ground;
    let (model, minimum) = if ground == *model {
        given
    } else {
        (progress.say)("fitting the model without what is suspected");
        from_ground = ground_fit(problem, &ground, given, progress)?;
        (&ground, &from_ground)
    };
    let cleared = problem.with_more_pushes(model, &minimum.values);
    let has_more_pushes = cleared.is_some();
    let mut problem = cleared.unwrap_or_else(|| problem.clone());
    let cut = match problem.suited_to(model) {
        Cow::Owned(cut) => Some(cut),
        Cow::Borrowed(_) => None,
    };
    let is_fitted = !has_more_pushes && cut.is_none();
    problem = cut.unwrap_or(problem);
    let begin = |problem: &FitProblem, is_fitted: bool| -> Result<Start, Cancelled> {
        progress.check()?;
        let (thresholds, cancelled) = (&options.thresholds, progress.cancelled);
        let suspects = options.suspects;
        Ok(Start::new(
            problem, model, minimum, is_fitted, suspects, thresholds, cancelled,
        ))
    };
    let mut start = begin(&problem, is_fitted)?;
    // If the starting model already shows that short windows are needed, no search over logs in one piece is made.
    if let Some(cut) = start.in_windows(&start.candidate, &problem) {
        problem = cut;
        start = begin(&problem, false)?;
    }
    let mut searched = Searched::new(start, progress)?;
    for _ in 0..MOST_REVISIONS {
        let Some(revised) = searched.revised(&problem) else {
            break;
        };
        (progress.say)("searching again: the logs are read differently with what was found");
        problem = revised;
        searched = Searched::new(begin(&problem, false)?, progress)?;
    }
    searched.diagnosis(&problem, given, progress)
}

/// The suspects of this bench. An effect with a zero for each log is a suspect only if several logs can differ.
pub fn suspects_of(problem: &FitProblem, suspects: &[EffectId]) -> Vec<EffectId> {
    let made = suspects.iter().map(|&effect| problem.made_for_logs(effect));
    made.filter(|effect| effect.info().per_log.is_none() || effect.info().parameters.len() > 1)
        .collect()
}

/// The starting model of the search: the base model with those effects of `model` that are not suspects.
fn ground_of(model: &Model, suspects: &[EffectId]) -> Model {
    let base = Model::base();
    let kept = model.effects().iter().copied();
    let kept: Vec<EffectId> = kept
        .filter(|effect| {
            let is_own = |suspect: &EffectId| suspect.name() == effect.name();
            base.has(*effect) || !suspects.iter().any(is_own)
        })
        .collect();
    Model::with_effects(&kept)
}

/// Fits the starting model from the logs alone, so that the diagnosis does not depend on the model that is
/// `given`. If that fit fails, the given fit is carried over and refined.
fn ground_fit(
    problem: &FitProblem,
    ground: &Model,
    (model, minimum): (&Model, &Minimum),
    progress: &Progress,
) -> Result<Minimum, Cancelled> {
    match fit_until(problem, ground, None, progress) {
        Ok(found) => Ok(found.fit.minimum),
        Err(IdentifyError::Cancelled(cancelled)) => Err(cancelled),
        Err(_) => {
            let suited = problem.suited_to(ground);
            let records = suited.all_records();
            let start = suited.start_values(ground);
            let values = carry_over(model, &minimum.values, ground, &start);
            let windows = joined(&records, &values, &minimum.windows);
            let free = suited.free(ground);
            let effort = Effort::FULL.until(progress.cancelled);
            Ok(refit(&records, ground, values, windows, &free, effort))
        }
    }
}

/// The starting point of a search.
struct Start<'a> {
    /// The bench with thinned logs.
    thin: FitProblem,
    /// For every record, the thinning step: every how many samples one is read.
    thinning: Vec<usize>,
    suspects: Vec<EffectId>,
    /// The starting model, fitted to the thinned logs.
    candidate: Candidate,
    /// The fit of the starting model to all samples, if it exists already.
    whole: Option<Minimum>,
    thresholds: &'a Thresholds,
    is_cancelled: IsCancelled<'a>,
    /// Results on these same logs that are computed at most once.
    imperfections: Arc<Imperfections>,
}

/// Fits a model to thinned logs, starting from its fit to all samples.
fn thin_fit(
    thin: &FitProblem,
    thinning: &[usize],
    model: &Model,
    before: &Minimum,
    is_cancelled: IsCancelled,
) -> Minimum {
    let records = thin.all_records();
    let thinned = |start: usize, step: usize| start.div_ceil(step);
    let windows = windows_at(&before.windows, thinning, thinned);
    let values = before.values.clone();
    let windows = joined(&records, &values, &windows);
    let free = thin.free(model);
    let effort = Effort::FULL.until(is_cancelled);
    refit(&records, model, values, windows, &free, effort)
}

/// A finished search, with its decision.
struct Searched<'a> {
    start: Start<'a>,
    found: Search,
    decision: Decision,
    /// What is said about an explanation that was given up (see [`without_open`]).
    given_up: Option<String>,
}

impl<'a> Start<'a> {
    /// `is_fitted` says that `given` is a fit of this model to these logs as they are.
    fn new(
        problem: &FitProblem,
        model: &Model,
        given: &Minimum,
        is_fitted: bool,
        suspects: &[EffectId],
        thresholds: &'a Thresholds,
        is_cancelled: IsCancelled<'a>,
    ) -> Start<'a> {
        let (thin, thinning) = problem.thinned(SAMPLES_PER_PERIOD);
        let records = thin.all_records();
        let mut suspects = suspects.to_vec();
        suspects.retain(|&effect| !is_cleared(&records, effect, thresholds.plain_fault));
        let minimum = if is_fitted && !is_thinned(&thinning) {
            given.clone()
        } else {
            thin_fit(&thin, &thinning, model, given, is_cancelled)
        };
        let candidate = Candidate::new(&thin, &records, vec![], model.clone(), minimum, None);
        Start {
            thin,
            thinning,
            suspects,
            candidate,
            whole: is_fitted.then(|| given.clone()),
            thresholds,
            is_cancelled,
            imperfections: Arc::default(),
        }
    }

    /// Fits a model to the thinned logs, starting from its fit to the logs before thinning.
    fn fit(&self, model: &Model, before: &Minimum) -> Minimum {
        thin_fit(&self.thin, &self.thinning, model, before, self.is_cancelled)
    }

    /// A step for the report, fitted to all samples of the bench. `known` is such a fit, if it exists already.
    fn step(
        &self,
        problem: &FitProblem,
        planned: Planned,
        candidate: &Candidate,
        look: &Look,
        known: Option<&Minimum>,
    ) -> Step {
        if !is_thinned(&self.thinning) {
            return Step::new(planned, look, candidate.clone(), look.fit.clone());
        }
        let minimum = match known {
            Some(known) => known.clone(),
            None => {
                let effort = Effort::FULL.until(self.is_cancelled);
                whole_fit(problem, &self.thinning, candidate, effort)
            }
        };
        Step::whole(problem, planned, look, candidate, minimum)
    }

    /// The inputs of the search.
    fn bench(&self) -> SearchBench<'_> {
        SearchBench::whole(
            &self.thin,
            &self.suspects,
            self.thresholds,
            self.is_cancelled,
            self.imperfections.clone(),
        )
    }

    /// The bench with driven logs cut into short windows; `None` if that is not needed. It is needed where the
    /// candidate leaves a remainder and, in short windows, cogging explains most of the misfit. Dense logs tell without a
    /// model whether the motor has teeth.
    fn in_windows(&self, candidate: &Candidate, problem: &FitProblem) -> Option<FitProblem> {
        if problem.needs_no_windows() {
            return None;
        }
        let remains = candidate.largest_remainder() > self.thresholds.remains;
        if problem.shows_teeth() {
            return remains.then(|| problem.in_windows())?;
        }
        let cut = self.thin.in_windows()?;
        let effort = Effort::FULL.until(self.is_cancelled);
        let asks = remains
            && shows_in_short_windows(&cut, candidate, &self.suspects, self.thresholds, effort);
        asks.then(|| problem.in_windows())?
    }
}

impl<'a> Searched<'a> {
    fn new(start: Start<'a>, progress: &Progress) -> Result<Searched<'a>, Cancelled> {
        let bench = start.bench();
        let found = search(&bench, start.candidate.clone(), progress)?;
        let left = |index: usize| bench.unexplained_remainder(&found.pool[index]);
        let excess = |index: usize| bench.excess(&found.pool[index]);
        let decision = decide(&found, left, excess, start.thresholds);
        let (decision, given_up) = match without_open(&bench, &found, &decision, left(0)) {
            Some((settled, sentence)) => (settled, Some(sentence)),
            None => (decision, None),
        };
        Ok(Searched {
            decision,
            given_up,
            found,
            start,
        })
    }

    /// The bench with its logs read as the result of this search suggests; `None` if the result is sufficient or
    /// suggests nothing. There are two cases: pushes that the starting model hid, and driven logs that cogging makes
    /// unpredictable in one piece.
    fn revised(&self, problem: &FitProblem) -> Option<FitProblem> {
        if matches!(
            self.decision.verdict,
            Verdict::NothingMissing | Verdict::Explained
        ) {
            return None;
        }
        let best = &self.found.pool[self.found.best];
        problem
            .with_more_pushes(&best.model, &best.minimum.values)
            .or_else(|| self.start.in_windows(best, problem))
    }

    /// `given` is the model that was diagnosed, with its fit.
    fn diagnosis(
        self,
        problem: &FitProblem,
        given: (&Model, &Minimum),
        progress: &Progress,
    ) -> Result<Diagnosis, Cancelled> {
        (progress.say)("predicting experiments that the fit has not seen");
        let Searched {
            start,
            mut found,
            decision,
            given_up,
        } = self;
        let bench = start.bench();
        let ranked = most_probable(&bench, &found, &decision);
        let steps = planned(&found, &decision, given.0);
        let candidates = steps
            .iter()
            .map(|step| place_of(&bench, &mut found, &start, step, given))
            .collect::<Result<Vec<usize>, Cancelled>>()?;
        let rows = ranked.iter().map(|one| one.index);
        let looks = looks(&bench, &found, candidates.iter().copied().chain(rows))?;
        let mut verdict = decision.verdict;
        let is_as_it_was = given.0 == &found.pool[decision.last()].model;
        if verdict == Verdict::Explained && is_as_it_was {
            verdict = Verdict::NothingMissing;
        }
        let of_candidates = steps.into_iter().zip(&candidates);
        let mut steps = parallel_map(of_candidates, |(step, &index)| {
            bench.check()?;
            let is_ground = step.model == start.candidate.model;
            let known = start.whole.as_ref().filter(|_| is_ground);
            Ok(start.step(problem, step, &found.pool[index], &looks[&index], known))
        })
        .into_iter()
        .collect::<Result<Vec<Step>, Cancelled>>()?;
        for index in 1..steps.len() {
            steps[index].is_held_out_worse =
                is_worse(&steps[index - 1].held_out, &steps[index].held_out);
        }
        let suspects = suspects(&bench, &found, &looks, ranked)?;
        progress.check()?;
        let last = &found.pool[decision.last()];
        let plain: Vec<_> = if matches!(verdict, Verdict::NothingMissing | Verdict::Explained) {
            let (values, windows) = (&last.minimum.values, &last.minimum.windows);
            let mut all = contradictions(&start.thin, &last.model, values, windows, &[]);
            all.retain(|one| one.sigmas > start.thresholds.contradiction);
            all
        } else {
            vec![]
        };
        if !plain.is_empty() {
            verdict = Verdict::Unexplained;
        }
        let ambiguous_between: Vec<Vec<EffectId>> = decision
            .ties
            .iter()
            .map(|&index| found.pool[index].set())
            .collect();
        let tied = decision.ties.iter().map(|&index| &found.pool[index]);
        let settling = propose(problem, &tied.collect::<Vec<&Candidate>>());
        let next_experiment = match (decision.ties.as_slice(), verdict) {
            ([_, _, ..], _) => settling.sentence,
            (_, Verdict::Unexplained) if !plain.is_empty() => {
                "Two results contradict each other: measure the stated value again, or repeat the experiment."
                    .to_owned()
            }
            (_, Verdict::Unexplained) => {
                let repeat = "Repeat the experiment with the largest error. A misfit that returns at the same \
             place comes from physics that the library lacks; one that does not is a disturbance.";
                match (given_up, imitation(&bench, &found.pool, found.best)) {
                    (Some(sentence), _) => sentence,
                    (None, Some(one)) => format!("{} {repeat}", one.sentence()),
                    (None, None) => repeat.to_owned(),
                }
            }
            _ => String::new(),
        };
        Ok(Diagnosis {
            verdict,
            certain: found.pool[decision.certain].model.clone(),
            steps,
            suspects,
            ambiguous_between,
            next_experiment,
            recipe: settling.recipe,
            remainder: decision.remainder,
            remains: remains(&bench.records, last),
            contradictions: plain,
        })
    }
}

/// Index in the pool of the model of a step. If the pool does not have it, it is fitted and added.
fn place_of(
    bench: &SearchBench,
    found: &mut Search,
    start: &Start,
    step: &Planned,
    (model, minimum): (&Model, &Minimum),
) -> Result<usize, Cancelled> {
    let known = found
        .pool
        .iter()
        .position(|candidate| candidate.model == step.model);
    // The diagnosed model is also fitted from its own earlier fit.
    let is_given = step.model == *model && *model != start.candidate.model;
    if let (Some(known), false) = (known, is_given) {
        return Ok(known);
    }
    bench.check()?;
    let (problem, records) = (bench.problem, &bench.records);
    let fitted = if is_given {
        start.fit(&step.model, minimum)
    } else {
        let ground = &found.pool[0];
        let (from, minimum) = (&ground.model, &ground.minimum);
        let effort = bench.until_called_off(Effort::FULL);
        extend(problem, records, from, minimum, &step.model, effort)
    };
    bench.check()?;
    if let Some(known) = known.filter(|&known| found.pool[known].minimum.cost <= fitted.cost) {
        return Ok(known);
    }
    let ground = found.pool[0].model.clone();
    let added = step.model.effects().iter().copied();
    let added = added.filter(|effect| !ground.has(*effect)).collect();
    let model = step.model.clone();
    let candidate = Candidate::new(problem, records, added, model, fitted, None);
    match known {
        Some(known) => {
            found.pool[known] = candidate;
            Ok(known)
        }
        None => {
            found.pool.push(candidate);
            found.evidence.push(f64::NEG_INFINITY);
            Ok(found.pool.len() - 1)
        }
    }
}

/// The effects that the report lists as suspects, most probable first.
fn most_probable(bench: &SearchBench, found: &Search, decision: &Decision) -> Vec<Ranked> {
    let (base, best) = (&found.pool[0], &found.pool[found.best]);
    // A set that adds to the best one something that no sensor would show has no vote.
    let is_needless: Vec<bool> = found
        .pool
        .iter()
        .zip(&found.evidence)
        .map(|(candidate, evidence)| {
            candidate.strictly_contains(best)
                && (!shows(bench, base, best, candidate)
                    || evidence - found.evidence[found.best] < bench.thresholds.tie)
        })
        .collect();
    // Where a remainder is left, the best set may have absorbed misfit of an unknown cause.
    let share = if decision.verdict == Verdict::Unexplained && bench.excess(base) > 0.0 {
        genuine(
            1.0 - bench.excess(best) / bench.excess(base),
            bench.thresholds,
        )
    } else {
        1.0
    };
    // Effects that were added, or that tie with those, have explained more than what remains. The discount for an
    // unknown cause applies to the other effects only.
    let is_taken: BTreeSet<EffectId> = decision
        .ties
        .iter()
        .chain([&decision.certain])
        .flat_map(|&index| found.pool[index].added.iter().copied())
        .collect();
    let is_genuine = |effect: EffectId| {
        if is_taken.contains(&effect) {
            1.0
        } else {
            share
        }
    };
    let mut ranked = ranked(found, &is_needless, is_genuine);
    ranked.truncate(MOST_SUSPECTS);
    ranked
}
