//! The verdict, and what it rests on.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use identify::{Cancelled, Effort, Fit, Minimum, Progress, Setup, Window, finish, joined, refit};
use plant::{EffectId, Model};
use rayon::prelude::*;

use crate::candidate::Candidate;
use crate::evidence::TIE;
use crate::genuine::genuine;
use crate::hidden_cogging::shows_cogging;
use crate::next_experiment::propose;
use crate::search::{
    REMAINS, Search, largest_remainder, noise, search, shows, unexplained_remainder,
};
use crate::suspects::{Bench, is_cleared};
use crate::validation::{HeldOut, held_out, mean_fit_percent};

/// What the diagnosis says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The model explains the measurements down to the noise of the sensors.
    NothingMissing,
    /// With the added effects it does.
    Explained,
    /// Several sets of effects explain the measurements equally well.
    Ambiguous,
    /// Something remains that no effect of the library accounts for.
    Unexplained,
}

impl Verdict {
    /// The name in the contract.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::NothingMissing => "nothing-missing",
            Verdict::Explained => "explained",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
    }
}

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

/// Explanations that tie are worth a choice if the best of them leaves at most this much structure in
/// units of noise; beyond it, what they share is that they do not explain the measurements.
const LEFT_BY_TIES: f64 = 3.0;

/// Samples in a period of the pendulum with which effects are searched for: a tenth of a radian of its
/// oscillation, about one step of the integration, lies between two of them.
const SAMPLES_PER_PERIOD: f64 = 63.0;

/// What may be asked of a diagnosis beside the model.
#[derive(Clone, Debug)]
pub struct Options<'a> {
    /// The effects that are suspects.
    pub suspects: &'a [EffectId],
}

impl Default for Options<'_> {
    /// The whole library.
    fn default() -> Self {
        Options {
            suspects: EffectId::ALL,
        }
    }
}

/// Diagnoses a fitted model. `say` is told in words what is going on. As [`diagnose_with`] with the
/// usual options, where nobody calls the work off.
pub fn diagnose(setup: &Setup, model: &Model, minimum: Minimum, say: &dyn Fn(&str)) -> Diagnosis {
    let options = Options::default();
    match diagnose_with(setup, model, minimum, &options, &Progress::saying(say)) {
        Ok(diagnosis) => diagnosis,
        Err(Cancelled) => unreachable!("nobody calls it off"),
    }
}

/// Most times that a search is repeated because its result shows the logs in another light.
const MOST_REVISIONS: usize = 2;

/// Diagnoses a fitted model.
///
/// # Errors
/// [`Cancelled`] soon after `progress` answers that the work is called off.
pub fn diagnose_with(
    setup: &Setup,
    model: &Model,
    minimum: Minimum,
    options: &Options,
    progress: &Progress,
) -> Result<Diagnosis, Cancelled> {
    progress.check()?;
    let suspects = options.suspects;
    let say = progress.say;
    let cleared = setup.with_more_pushes(model, &minimum.values);
    let has_more_pushes = cleared.is_some();
    let mut setup = cleared.unwrap_or_else(|| setup.clone());
    let cut = match setup.suited_to(model) {
        Cow::Owned(cut) => Some(cut),
        Cow::Borrowed(_) => None,
    };
    let is_fitted = !has_more_pushes && cut.is_none();
    setup = cut.unwrap_or(setup);
    let mut start = Start::new(&setup, model, &minimum, is_fitted, suspects);
    // What is plain at once need not be found by a search over logs in one piece.
    if let Some(cut) = start.in_windows(&start.candidate, &setup) {
        setup = cut;
        start = Start::new(&setup, model, &minimum, false, suspects);
    }
    progress.check()?;
    let mut searched = Searched::new(start, say);
    for _ in 0..MOST_REVISIONS {
        let Some(revised) = searched.revised(&setup) else {
            break;
        };
        progress.check()?;
        say("searching again: the logs are read differently with what was found");
        setup = revised;
        let start = Start::new(&setup, model, &minimum, false, suspects);
        searched = Searched::new(start, say);
    }
    progress.check()?;
    Ok(searched.diagnosis(&setup, say))
}

/// What a search starts from.
struct Start {
    /// The bench with its logs thinned.
    thin: Setup,
    /// For every record the step by which.
    thinning: Vec<usize>,
    suspects: Vec<EffectId>,
    /// The model as it was, fitted to it.
    candidate: Candidate,
    /// The same fitted to all samples, where that was done before.
    whole: Option<Minimum>,
}

/// A search over the logs of a bench, and what it comes to.
struct Searched {
    start: Start,
    found: Search,
    /// Index of the candidate with what could be added for certain.
    chosen: usize,
    /// Its structured remainder in units of noise.
    remainder: f64,
    verdict: Verdict,
}

impl Start {
    /// `is_fitted`: the minimum is that of this very setup.
    fn new(
        setup: &Setup,
        model: &Model,
        given: &Minimum,
        is_fitted: bool,
        suspects: &[EffectId],
    ) -> Start {
        let (thin, thinning) = setup.thinned(SAMPLES_PER_PERIOD);
        let records = thin.all_records();
        let mut suspects = suspects.to_vec();
        suspects.retain(|&effect| !is_cleared(&records, effect));
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
        }
    }

    /// The bench with driven logs in short windows, where cogging beside what a candidate has asks for it.
    fn in_windows(&self, candidate: &Candidate, setup: &Setup) -> Option<Setup> {
        let cut = self.thin.in_windows()?;
        let leaves = largest_remainder(&self.thin.all_records(), candidate);
        let asks = leaves > REMAINS && shows_cogging(&cut, candidate, &self.suspects);
        asks.then(|| setup.in_windows())?
    }
}

impl Searched {
    fn new(start: Start, progress: &dyn Fn(&str)) -> Searched {
        let candidate = start.candidate.clone();
        let found = search(&start.thin, candidate, &start.suspects, progress);
        let chosen = if found.ties.is_empty() {
            found.best
        } else {
            common(&found).unwrap_or(0)
        };
        let bench = Bench::whole(&start.thin, &start.suspects);
        let remainder = unexplained_remainder(&bench, &found.pool[chosen]);
        let verdict = verdict(&bench, &found, chosen, remainder);
        Searched {
            found,
            chosen,
            remainder,
            verdict,
            start,
        }
    }

    /// The bench as it must be read with what was found, where that is not enough and the logs themselves
    /// look different with it: pushes that the first model hid, or driven logs that cogging has made
    /// unpredictable in one piece.
    fn revised(&self, setup: &Setup) -> Option<Setup> {
        if matches!(self.verdict, Verdict::NothingMissing | Verdict::Explained) {
            return None;
        }
        let best = &self.found.pool[self.found.best];
        setup
            .with_more_pushes(&best.model, &best.minimum.values)
            .or_else(|| self.start.in_windows(best, setup))
    }

    fn diagnosis(self, setup: &Setup, progress: &dyn Fn(&str)) -> Diagnosis {
        progress("predicting experiments that the fit has not seen");
        let Searched {
            start,
            found,
            chosen,
            remainder,
            verdict,
        } = self;
        let Start {
            thin,
            thinning,
            suspects,
            whole,
            ..
        } = start;
        let bench = Bench::whole(&thin, &suspects);
        let (chosen, remainder) = if verdict == Verdict::Unexplained {
            let chosen = without_absorbers(&bench, &found, chosen);
            (chosen, unexplained_remainder(&bench, &found.pool[chosen]))
        } else {
            (chosen, remainder)
        };
        let path = path(&found, chosen);
        let ranked = ranked(&bench, &found, verdict);
        let indices = path.iter().map(|&(_, index)| index);
        let looks = looks(
            &bench,
            &found,
            indices.chain(ranked.iter().map(|one| one.index)),
        );
        let steps = path
            .into_par_iter()
            .map(|(effect, index)| {
                let (candidate, look) = (&found.pool[index], &looks[&index]);
                if is_thinned(&thinning) {
                    let known = whole.as_ref().filter(|_| effect.is_none());
                    let minimum = match known {
                        Some(known) => known.clone(),
                        None => whole_fit(setup, &thinning, candidate),
                    };
                    whole_step(setup, effect, candidate, minimum, look)
                } else {
                    Step {
                        effect,
                        fit: look.fit.clone(),
                        validation_fit_percent: mean_fit_percent(&look.held_out),
                        held_out: look.held_out.clone(),
                        candidate: candidate.clone(),
                    }
                }
            })
            .collect();
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
            ([a, b, ..], Verdict::Ambiguous) => propose(setup, &found.pool[*a], &found.pool[*b]),
            (_, Verdict::Unexplained) => {
                "Repeat the experiment in which the error is largest: what \
             comes back at the same place is physics that the library lacks, what does not is a \
             disturbance."
                    .to_owned()
            }
            _ => String::new(),
        };
        Diagnosis {
            verdict,
            steps,
            suspects,
            ambiguous_between,
            next_experiment,
            remainder,
        }
    }
}

fn verdict(bench: &Bench, found: &Search, chosen: usize, remainder: f64) -> Verdict {
    // Explanations that tie but leave most of it unexplained explain nothing.
    let left_by_ties = found
        .ties
        .iter()
        .map(|&index| unexplained_remainder(bench, &found.pool[index]))
        .fold(f64::INFINITY, f64::min);
    // What they share may be all that there is: where it leaves less than the noise, additions that
    // disagree with each other are the imperfections of its terms and no effects.
    let is_shared = !found.pool[chosen].added.is_empty() && remainder <= REMAINS;
    if found.ties.len() > 1 && left_by_ties <= LEFT_BY_TIES && !is_shared {
        Verdict::Ambiguous
    } else if remainder > REMAINS {
        Verdict::Unexplained
    } else if found.pool[chosen].added.is_empty() {
        Verdict::NothingMissing
    } else {
        Verdict::Explained
    }
}

/// A closer look at a candidate: its standard errors, and how it predicts what it has not seen.
struct Look {
    fit: Fit,
    held_out: Vec<HeldOut>,
}

/// A look at each of these candidates of the pool, once.
fn looks(
    bench: &Bench,
    found: &Search,
    indices: impl Iterator<Item = usize>,
) -> BTreeMap<usize, Look> {
    let indices: BTreeSet<usize> = indices.collect();
    indices
        .into_par_iter()
        .map(|index| {
            let candidate = &found.pool[index];
            let (model, minimum) = (&candidate.model, &candidate.minimum);
            let free = bench.setup.free(model);
            let look = Look {
                fit: finish(&bench.records, model, &free, minimum.clone()),
                held_out: held_out(bench, model, minimum),
            };
            (index, look)
        })
        .collect()
}

/// Whether any log is read more sparsely than it was recorded.
fn is_thinned(thinning: &[usize]) -> bool {
    thinning.iter().any(|&step| step > 1)
}

/// The windows of logs that are read at another step: `place` says where a sample stands there.
fn windows_at(
    windows: &[Vec<Window>],
    thinning: &[usize],
    place: impl Fn(usize, usize) -> usize,
) -> Vec<Vec<Window>> {
    let moved = |window: &Window, step: usize| Window {
        samples: place(window.samples.start, step)..place(window.samples.end, step),
        locals: window.locals.clone(),
    };
    windows
        .iter()
        .zip(thinning)
        .map(|(windows, &step)| windows.iter().map(|window| moved(window, step)).collect())
        .collect()
}

/// The fit of a candidate to all samples of the bench.
fn whole_fit(setup: &Setup, thinning: &[usize], candidate: &Candidate) -> Minimum {
    let records = setup.all_records();
    let whole = |start: usize, step: usize| start * step;
    let before = windows_at(&candidate.minimum.windows, thinning, whole);
    let windows = joined(&records, &candidate.minimum.values, &before);
    refit(
        &records,
        &candidate.model,
        candidate.minimum.values.clone(),
        windows,
        &setup.free(&candidate.model),
        Effort::FULL,
    )
}

/// A step whose fit is made with all samples of the bench; what the fit has not seen is predicted
/// with the thinned ones.
fn whole_step(
    setup: &Setup,
    effect: Option<EffectId>,
    candidate: &Candidate,
    minimum: Minimum,
    look: &Look,
) -> Step {
    let records = setup.all_records();
    let (added, model) = (candidate.added.clone(), candidate.model.clone());
    Step {
        effect,
        fit: finish(&records, &model, &setup.free(&model), minimum.clone()),
        validation_fit_percent: mean_fit_percent(&look.held_out),
        held_out: look.held_out.clone(),
        candidate: Candidate::new(setup, &records, added, model, minimum, None),
    }
}

/// χ² beyond what the noise of the sensors makes.
fn excess(bench: &Bench, candidate: &Candidate) -> f64 {
    let records = bench.records.iter();
    let observations: usize = records.map(|record| record.observations()).sum();
    (candidate.minimum.cost - observations as f64).max(0.0)
}

/// The chosen candidate, or one before it on the way where the last additions took less than what remains
/// in the end: an unknown cause looks a little like everything, and what an effect takes of it is then not
/// its own.
fn without_absorbers(bench: &Bench, found: &Search, chosen: usize) -> usize {
    let excess = |index: usize| excess(bench, &found.pool[index]);
    let remains = excess(chosen);
    let mut chosen = chosen;
    while let [.., (_, before), (Some(_), _)] = path(found, chosen).as_slice() {
        if excess(*before) - excess(chosen) >= remains {
            break;
        }
        chosen = *before;
    }
    chosen
}

/// The largest candidate that every tying one contains: what they agree on.
fn common(found: &Search) -> Option<usize> {
    (0..found.pool.len())
        .filter(|&index| {
            found
                .ties
                .iter()
                .all(|&tie| index == tie || found.pool[tie].strictly_contains(&found.pool[index]))
        })
        .max_by_key(|&index| found.pool[index].added.len())
}

/// The way from the model as it was to the chosen candidate, one effect a step: each time over the
/// candidate with the highest evidence of those that contain no other one on the way (dry friction
/// comes before the presliding that refines it).
fn path(found: &Search, chosen: usize) -> Vec<(Option<EffectId>, usize)> {
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
        let next = on_the_way
            .iter()
            .copied()
            .filter(|&index| {
                !on_the_way
                    .iter()
                    .any(|&other| found.pool[index].strictly_contains(&found.pool[other]))
            })
            .max_by(|&a, &b| found.evidence[a].total_cmp(&found.evidence[b]));
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

/// Most suspects that are reported.
const MOST_SUSPECTS: usize = 6;

/// An effect with its probability and the best candidate that has it.
struct Ranked {
    effect: EffectId,
    probability: f64,
    index: usize,
}

/// The effects that could be missing, most probable first.
fn ranked(bench: &Bench, found: &Search, verdict: Verdict) -> Vec<Ranked> {
    let base = &found.pool[0];
    let best = &found.pool[found.best];
    // Sets that add to the best one what no sensor would show do not vote.
    let votes: Vec<f64> = found
        .pool
        .iter()
        .zip(&found.evidence)
        .map(|(candidate, evidence)| {
            let needless = candidate.strictly_contains(best)
                && (!shows(bench, base, best, candidate)
                    || evidence - found.evidence[found.best] < TIE);
            if needless {
                0.0
            } else {
                (evidence - found.evidence[found.best]).min(0.0).exp()
            }
        })
        .collect();
    let total: f64 = votes.iter().sum();
    // Where something remains, what the best set takes of the misfit need not be its own.
    let is_genuine = if verdict == Verdict::Unexplained && excess(bench, base) > 0.0 {
        genuine(1.0 - excess(bench, best) / excess(bench, base))
    } else {
        1.0
    };
    let mut seen: Vec<EffectId> = found
        .pool
        .iter()
        .flat_map(|candidate| candidate.added.clone())
        .collect();
    seen.sort();
    seen.dedup();
    let mut ranked: Vec<(EffectId, f64, f64, usize)> = seen
        .into_iter()
        .filter_map(|effect| {
            let with = |index: &usize| found.pool[*index].added.contains(&effect);
            let probability: f64 = (0..found.pool.len())
                .filter(|index| with(index))
                .map(|index| votes[index])
                .sum::<f64>()
                / total;
            let index = (0..found.pool.len())
                .filter(with)
                .max_by(|&a, &b| found.evidence[a].total_cmp(&found.evidence[b]))?;
            // Equal probabilities (all but zero) are ranked by what the effect gains alone.
            let alone = found
                .pool
                .iter()
                .filter(|candidate| candidate.added == [effect])
                .map(|candidate| base.minimum.cost - candidate.minimum.cost)
                .fold(0.0, f64::max);
            Some((effect, probability * is_genuine, alone, index))
        })
        .collect();
    ranked.sort_by(|a, b| {
        (b.1 > 1e-6)
            .cmp(&(a.1 > 1e-6))
            .then(if a.1 > 1e-6 && (a.1 - b.1).abs() > 0.02 {
                b.1.total_cmp(&a.1)
            } else {
                b.2.total_cmp(&a.2)
            })
    });
    ranked.truncate(MOST_SUSPECTS);
    let reported = ranked.into_iter();
    reported
        .map(|(effect, probability, _, index)| Ranked {
            effect,
            probability,
            index,
        })
        .collect()
}

fn suspect(bench: &Bench, found: &Search, look: &Look, ranked: Ranked) -> Suspect {
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
fn fingerprint(bench: &Bench, effect: EffectId, base: &Candidate, with: &Candidate) -> String {
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
