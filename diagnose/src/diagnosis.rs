//! The diagnosis of a fitted model, from the logs to the verdict.

use std::borrow::Cow;
use std::sync::Arc;

use identify::{Cancelled, Effort, FitProblem, Minimum, Progress, joined, refit};
use plant::{EffectId, Model};
use rayon::prelude::*;

use crate::applicable::is_cleared;
use crate::bench::{IsCancelled, SearchBench};
use crate::candidate::Candidate;
use crate::economy::{MOST_REVISIONS, MOST_SUSPECTS, SAMPLES_PER_PERIOD};
use crate::genuine::genuine;
use crate::imperfection::Imperfections;
use crate::next_experiment::propose;
use crate::path::{path, without_absorbers};
use crate::pool::{Search, common};
use crate::ranking::{Ranked, ranked};
use crate::report::{Diagnosis, Step, looks, suspect, whole_step};
use crate::search::search;
use crate::short_windows::shows_in_short_windows;
use crate::shown::shows;
use crate::thinned::{is_thinned, whole_fit, windows_at};
use crate::thresholds::Thresholds;
use crate::validation::mean_fit_percent;
use crate::verdict::{Findings, Verdict, verdict};

/// What may be asked of a diagnosis beside the model.
#[derive(Clone, Debug)]
pub struct Options<'a> {
    /// The effects that are suspects.
    pub suspects: &'a [EffectId],
    /// The numbers that decide.
    pub thresholds: Thresholds,
}

impl Default for Options<'_> {
    /// The whole library.
    fn default() -> Self {
        Options {
            suspects: EffectId::ALL,
            thresholds: Thresholds::default(),
        }
    }
}

/// Diagnoses a fitted model.
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
            problem, model, &minimum, is_fitted, suspects, thresholds, cancelled,
        ))
    };
    let mut start = begin(&problem, is_fitted)?;
    // What is plain at once need not be found by a search over logs in one piece.
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
    searched.diagnosis(&problem, progress)
}

/// What a search starts from.
struct Start<'a> {
    /// The bench with its logs thinned.
    thin: FitProblem,
    /// For every record the step by which.
    thinning: Vec<usize>,
    suspects: Vec<EffectId>,
    /// The model as it was, fitted to it.
    candidate: Candidate,
    /// The same fitted to all samples, where that was done before.
    whole: Option<Minimum>,
    thresholds: &'a Thresholds,
    is_cancelled: IsCancelled<'a>,
    /// What has been worked out on these logs.
    imperfections: Arc<Imperfections>,
}

/// A search over the logs of a bench, and what it comes to.
struct Searched<'a> {
    start: Start<'a>,
    found: Search,
    /// Index of the candidate with what could be added for certain.
    chosen: usize,
    /// Its structured remainder in units of noise.
    remainder: f64,
    verdict: Verdict,
}

impl<'a> Start<'a> {
    /// `is_fitted`: the minimum is that of this very setup.
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
            let thinned = |start: usize, step: usize| start.div_ceil(step);
            let before = windows_at(&given.windows, &thinning, thinned);
            let values = given.values.clone();
            let windows = joined(&records, &values, &before);
            let free = thin.free(model);
            refit(&records, model, values, windows, &free, Effort::FULL)
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

    /// What the search works on.
    fn bench(&self) -> SearchBench<'_> {
        SearchBench::whole(
            &self.thin,
            &self.suspects,
            self.thresholds,
            self.is_cancelled,
            self.imperfections.clone(),
        )
    }

    /// The bench with driven logs in short windows, where an effect that makes them unpredictable in one piece
    /// asks for it beside what a candidate has.
    fn in_windows(&self, candidate: &Candidate, problem: &FitProblem) -> Option<FitProblem> {
        let cut = self.thin.in_windows()?;
        let remains = candidate.largest_remainder() > self.thresholds.remains;
        let asks =
            remains && shows_in_short_windows(&cut, candidate, &self.suspects, self.thresholds);
        asks.then(|| problem.in_windows())?
    }
}

impl<'a> Searched<'a> {
    fn new(start: Start<'a>, progress: &Progress) -> Result<Searched<'a>, Cancelled> {
        let bench = start.bench();
        let found = search(&bench, start.candidate.clone(), progress)?;
        let chosen = if found.ties.is_empty() {
            found.best
        } else {
            common(&found).unwrap_or(0)
        };
        let left = |index: usize| bench.unexplained_remainder(&found.pool[index]);
        let remainder = left(chosen);
        let findings = Findings {
            added: found.pool[chosen].added.len(),
            remainder,
            ties: found.ties.len(),
            left_by_ties: found
                .ties
                .iter()
                .map(|&index| left(index))
                .fold(f64::INFINITY, f64::min),
        };
        Ok(Searched {
            chosen,
            remainder,
            verdict: verdict(&findings, start.thresholds),
            found,
            start,
        })
    }

    /// The bench as it must be read with what was found, where that is not enough and the logs themselves
    /// look different with it: pushes that the first model hid, or driven logs that cogging has made
    /// unpredictable in one piece.
    fn revised(&self, problem: &FitProblem) -> Option<FitProblem> {
        if matches!(self.verdict, Verdict::NothingMissing | Verdict::Explained) {
            return None;
        }
        let best = &self.found.pool[self.found.best];
        problem
            .with_more_pushes(&best.model, &best.minimum.values)
            .or_else(|| self.start.in_windows(best, problem))
    }

    fn diagnosis(self, problem: &FitProblem, progress: &Progress) -> Result<Diagnosis, Cancelled> {
        (progress.say)("predicting experiments that the fit has not seen");
        let Searched {
            start,
            found,
            chosen,
            remainder,
            verdict,
        } = self;
        let (bench, thinning) = (start.bench(), &start.thinning);
        let (chosen, remainder) = if verdict == Verdict::Unexplained {
            let excess: Vec<f64> = found.pool.iter().map(|one| bench.excess(one)).collect();
            let chosen = without_absorbers(&found, chosen, &excess);
            (chosen, bench.unexplained_remainder(&found.pool[chosen]))
        } else {
            (chosen, remainder)
        };
        let path = path(&found, chosen);
        let ranked = most_probable(&bench, &found, verdict);
        let indices = path.iter().map(|&(_, index)| index);
        let looks = looks(
            &bench,
            &found,
            indices.chain(ranked.iter().map(|one| one.index)),
        )?;
        let steps = path
            .into_par_iter()
            .map(|(effect, index)| {
                let (candidate, look) = (&found.pool[index], &looks[&index]);
                if is_thinned(thinning) {
                    bench.check()?;
                    let known = start.whole.as_ref().filter(|_| effect.is_none());
                    let minimum = match known {
                        Some(known) => known.clone(),
                        None => whole_fit(problem, thinning, candidate),
                    };
                    Ok(whole_step(problem, effect, candidate, minimum, look))
                } else {
                    Ok(Step {
                        effect,
                        fit: look.fit.clone(),
                        validation_fit_percent: mean_fit_percent(&look.held_out),
                        held_out: look.held_out.clone(),
                        candidate: candidate.clone(),
                    })
                }
            })
            .collect::<Result<_, Cancelled>>()?;
        let suspects = ranked
            .into_iter()
            .map(|one| suspect(&bench, &found, &looks[&one.index], one))
            .collect();
        let ambiguous_between: Vec<Vec<EffectId>> = found
            .ties
            .iter()
            .filter(|_| verdict == Verdict::Ambiguous)
            .map(|&index| found.pool[index].set())
            .collect();
        let next_experiment = match (found.ties.as_slice(), verdict) {
            ([a, b, ..], Verdict::Ambiguous) => propose(problem, &found.pool[*a], &found.pool[*b]),
            (_, Verdict::Unexplained) => {
                "Repeat the experiment in which the error is largest: what \
             comes back at the same place is physics that the library lacks, what does not is a \
             disturbance."
                    .to_owned()
            }
            _ => String::new(),
        };
        Ok(Diagnosis {
            verdict,
            steps,
            suspects,
            ambiguous_between,
            next_experiment,
            remainder,
        })
    }
}

/// The effects that are reported as suspects.
fn most_probable(bench: &SearchBench, found: &Search, verdict: Verdict) -> Vec<Ranked> {
    let (base, best) = (&found.pool[0], &found.pool[found.best]);
    // Sets that add to the best one what no sensor would show do not vote.
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
    // Where something remains, what the best set takes of the misfit need not be its own.
    let is_genuine = if verdict == Verdict::Unexplained && bench.excess(base) > 0.0 {
        let share = 1.0 - bench.excess(best) / bench.excess(base);
        genuine(share, bench.thresholds)
    } else {
        1.0
    };
    let mut ranked = ranked(found, &is_needless, is_genuine);
    ranked.truncate(MOST_SUSPECTS);
    ranked
}
