//! The mark of one verdict.
//!
//! Refits decide what the logs can tell: the true set of effects, started at the true
//! parameters, is compared with every rival set that the suspects offer in its place. A rival's distance is the
//! difference of χ², plus ln n for every parameter that it has more (Schwarz 1978). Sets at nearly
//! the same distance tie; then "ambiguous" is the right answer. A simpler set that is no worse
//! is as right as the truth.

use std::borrow::Cow;

use diagnose::{Diagnosis, Options, Step, Verdict, diagnose_with, suspects_of};
use identify::{
    Cancelled, Effort, Fit, FitProblem, IdentifyError, Progress, fit_until, joined, refit,
};
use plant::{EffectId, Model};

use crate::answer::Answer;
use crate::rivals::{CLOSE, EQUAL, Rival, rivals};

/// If an effect with at least this trace, in units of noise, is missed, "nothing missing" and
/// "explained" are wrong. With a smaller trace, the effect counts as missed only.
pub const PLAIN: f64 = 3.0;

/// The mark of a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Right: the true effects; "nothing missing" if nothing is hidden; "ambiguous" if the logs
    /// leave a tie; "unexplained" for an outsider.
    Right,
    /// Less than the logs allow, but nothing wrong: "ambiguous" with the truth among the
    /// sets, or the true effects with "unexplained".
    Cautious,
    /// The right one of tying sets was named with confidence, by luck.
    Lucky,
    /// Not confident, and the truth is not among the named sets.
    Astray,
    /// An effect with a small trace was not found.
    Missed,
    /// Nothing is hidden, but an effect was named or structure reported.
    FalseAlarm,
    /// A confident verdict that is wrong.
    Wrong,
}

impl Mark {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Mark::Right => "right",
            Mark::Cautious => "cautious",
            Mark::Lucky => "lucky",
            Mark::Astray => "astray",
            Mark::Missed => "missed",
            Mark::FalseAlarm => "false-alarm",
            Mark::Wrong => "wrong",
        }
    }
}

/// An added parameter compared with its true value.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// The parameter.
    pub name: &'static str,
    /// Its true value, SI.
    pub truth: f64,
    /// The fit's value, SI.
    pub value: f64,
    /// The fit's standard error, SI.
    pub std: f64,
}

impl Interval {
    /// Whether the 95 % interval contains the true value.
    pub fn covers(&self) -> bool {
        (self.value - self.truth).abs() <= 1.959_964 * self.std
    }
}

/// A verdict with its mark.
#[derive(Clone, Debug)]
pub struct Paper {
    /// The verdict.
    pub verdict: Verdict,
    /// The effects that the verdict calls certain.
    pub named: Vec<EffectId>,
    /// All suspects with their probabilities, most probable first.
    pub suspects: Vec<(EffectId, f64)>,
    /// The sets that the verdict calls a tie.
    pub ambiguous_between: Vec<Vec<EffectId>>,
    /// The largest structured remainder, in units of noise.
    pub remainder: f64,
    /// The mark.
    pub mark: Mark,
    /// Effects that count as true: the hidden ones, and those of simpler sets that are no worse.
    pub accepted: Vec<EffectId>,
    /// The sets that tie with the truth, each with its distance.
    pub ties: Vec<(Vec<EffectId>, f64)>,
    /// For each hidden effect: its trace beside the others, in units of noise.
    pub shown: Vec<f64>,
    /// Added parameters compared with the truth, if the named effects are the true ones.
    pub intervals: Vec<Interval>,
    /// Time that the verdict took, identification included, s.
    pub seconds: f64,
}

/// The reason why a bench could not be marked.
#[derive(Debug, thiserror::Error)]
pub enum MarkError {
    /// It cannot be identified.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Lets the diagnosis answer a bench, and marks the verdict.
///
/// # Errors
/// [`MarkError`] if the bench cannot be identified, or the work is cancelled.
pub fn mark(
    problem: &FitProblem,
    answer: &Answer,
    suspects: &[EffectId],
    progress: &Progress,
) -> Result<Paper, MarkError> {
    let suspects = &suspects_of(problem, suspects);
    let answer = &answer.made_for(problem);
    let started = std::time::Instant::now();
    let base = Model::base();
    let found = fit_until(problem, &base, None, progress)?;
    let mut minimum = found.fit.minimum.clone();
    let options = Options {
        suspects,
        ..Options::default()
    };
    let diagnosis = diagnose_with(problem, &base, found.fit.minimum, &options, progress)?;
    let seconds = started.elapsed().as_secs_f64();
    // The pushes that the diagnosis leaves out are left out here as well.
    let cleared = problem.with_more_pushes(&base, &minimum.values);
    if let Some(cleared) = &cleared {
        minimum = refit(
            &cleared.all_records(),
            &base,
            minimum.values,
            minimum.windows,
            &cleared.free(&base),
            Effort::FULL,
        );
    }
    let problem = cleared.as_ref().unwrap_or(problem);
    let truth = answer.effects.iter();
    let truth = truth.fold(Model::base(), |model, &effect| model.with(effect));
    let suited = problem.suited_to(&truth);
    if let Cow::Owned(cut) = &suited {
        let records = cut.all_records();
        let windows = joined(&records, &minimum.values, &minimum.windows);
        let free = cut.free(&base);
        minimum = refit(
            &records,
            &base,
            minimum.values,
            windows,
            &free,
            Effort::FULL,
        );
    }
    let problem = suited.as_ref();
    let (rivals, shown) = if answer.effects.is_empty() || answer.outside {
        (vec![], vec![])
    } else {
        rivals(problem, &minimum, answer, suspects, progress)?
    };
    Ok(marked(problem, answer, diagnosis, rivals, shown, seconds))
}

fn marked(
    problem: &FitProblem,
    answer: &Answer,
    diagnosis: Diagnosis,
    rivals: Vec<Rival>,
    shown: Vec<f64>,
    seconds: f64,
) -> Paper {
    let named = diagnosis.certain_effects();
    let is_accepted = |set: &[EffectId]| {
        set == answer.effects
            || rivals
                .iter()
                .any(|rival| rival.simpler && rival.distance < EQUAL && rival.set == set)
    };
    let tie = |limit: f64| {
        rivals
            .iter()
            .any(|rival| rival.distance < limit && !is_accepted(&rival.set))
    };
    let listed = diagnosis
        .ambiguous_between
        .iter()
        .any(|set| is_accepted(set));
    let is_subset =
        |small: &[EffectId], large: &[EffectId]| small.iter().all(|effect| large.contains(effect));
    // A limiting case of the true effect (dry friction for presliding) counts as true, if its missing part is small.
    let is_limit = rivals
        .iter()
        .any(|rival| rival.set == named && rival.lacks.is_some_and(|lacks| lacks < PLAIN));
    let missed_is_plain = answer
        .effects
        .iter()
        .zip(&shown)
        .any(|(effect, shown)| !named.contains(effect) && *shown >= PLAIN);
    let mark = match diagnosis.verdict {
        Verdict::Unexplained if answer.outside => Mark::Right,
        Verdict::Ambiguous if answer.outside => Mark::Astray,
        _ if answer.outside => Mark::Wrong,
        Verdict::NothingMissing if answer.effects.is_empty() => Mark::Right,
        _ if answer.effects.is_empty() => Mark::FalseAlarm,
        Verdict::NothingMissing if missed_is_plain => Mark::Wrong,
        Verdict::NothingMissing => Mark::Missed,
        Verdict::Explained if is_accepted(&named) && named != answer.effects => Mark::Right,
        Verdict::Explained if named == answer.effects && tie(EQUAL) => Mark::Lucky,
        Verdict::Explained if named == answer.effects => Mark::Right,
        Verdict::Explained
            if is_limit || (is_subset(&named, &answer.effects) && !missed_is_plain) =>
        {
            Mark::Missed
        }
        Verdict::Explained => Mark::Wrong,
        Verdict::Ambiguous if listed && tie(CLOSE) => Mark::Right,
        Verdict::Ambiguous if listed => Mark::Cautious,
        Verdict::Unexplained if is_accepted(&named) => Mark::Cautious,
        Verdict::Ambiguous | Verdict::Unexplained => Mark::Astray,
    };
    let mut accepted = answer.effects.clone();
    for rival in &rivals {
        if is_accepted(&rival.set) {
            accepted.extend(&rival.set);
        }
    }
    accepted.sort();
    accepted.dedup();
    let certain = |step: &&Step| step.fit.model == diagnosis.certain;
    let intervals = match diagnosis.steps.iter().rev().find(certain) {
        Some(step) if named == answer.effects => intervals(problem, &step.fit, answer),
        _ => vec![],
    };
    Paper {
        verdict: diagnosis.verdict,
        named,
        suspects: diagnosis
            .suspects
            .iter()
            .map(|suspect| (suspect.effect, suspect.probability))
            .collect(),
        ambiguous_between: diagnosis.ambiguous_between.clone(),
        remainder: diagnosis.remainder,
        mark,
        accepted,
        ties: rivals
            .into_iter()
            .filter(|rival| rival.distance < CLOSE)
            .map(|rival| (rival.set, rival.distance))
            .collect(),
        shown,
        intervals,
        seconds,
    }
}

fn intervals(problem: &FitProblem, fit: &Fit, answer: &Answer) -> Vec<Interval> {
    let mut found = vec![];
    for effect in &answer.effects {
        for (index, info) in effect.info().parameters.iter().enumerate() {
            let Some(position) = fit.model.position_of(info.name) else {
                continue;
            };
            // Per unit of inertia, there is no true value to compare with.
            if problem.unit(&fit.model, position) != info.unit {
                continue;
            }
            let truth = answer.parameters.iter().find(|(name, _)| name == info.name);
            let (Some((_, truth)), Some(std)) = (truth, fit.std(position)) else {
                continue;
            };
            let mut value = fit.values[position];
            if effect
                .info()
                .ripple
                .is_some_and(|ripple| ripple.phase == index)
            {
                let turn = std::f64::consts::TAU;
                value -= turn * ((value - truth) / turn).round();
            }
            found.push(Interval {
                name: info.name,
                truth: *truth,
                value,
                std,
            });
        }
    }
    found
}
