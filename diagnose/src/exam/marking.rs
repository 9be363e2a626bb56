//! How one verdict is marked.
//!
//! What the logs can decide is worked out by refitting: the true set of effects, started at the true
//! parameters, against every rival that the suspects offer in its place. A rival's distance is the
//! difference of χ² plus ln n for every parameter that it has more (Schwarz 1978). Sets at nearly
//! the same distance tie, and then "ambiguous" is the right answer; a simpler set that is no worse
//! is as right as the truth.

use std::borrow::Cow;

use identify::{
    Effort, Fit, Minimum, Progress, Setup, final_windows, fit_from_scratch, identify, joined, refit,
};
use plant::{EffectId, Model};

use super::draw::{ExamBench, Question};
use super::truth::Hidden;
use crate::candidate::Candidate;
use crate::diagnosis::{Diagnosis, Options, Verdict, diagnose_with};
use crate::search::{largest_trace, prepared};
use crate::suspects::{Round, try_all};

/// A rival at less than this distance cannot be told from the truth (odds of 4 to one at most):
/// a confident answer is luck.
pub const EQUAL: f64 = 3.0;
/// Up to this distance (odds of 400 to one) "ambiguous" is as right as the truth.
pub const CLOSE: f64 = 12.0;
/// A missed effect whose trace is at least this, in units of noise, makes "nothing missing" and
/// "explained" wrong and not only blind.
pub const PLAIN: f64 = 3.0;

/// χ² for each observation beyond which the fit of the true set has not found its minimum.
const BAD: f64 = 1.3;

/// What is true of a bench.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The hidden effects of the library; for an outsider those that act besides it.
    pub effects: Vec<EffectId>,
    /// True parameters in SI by name, as far as they are known.
    pub parameters: Vec<(String, f64)>,
    /// A term hides that no suspect accounts for.
    pub outside: bool,
}

impl Answer {
    /// The answer of a drawn bench.
    pub fn of(bench: &ExamBench) -> Answer {
        let outside = matches!(bench.question, Question::Outside(_) | Question::Withheld(_));
        let mut parameters: Vec<(String, f64)> = plant::BASE_PARAMETERS
            .iter()
            .zip(bench.truth.base)
            .map(|(info, value)| (info.name.to_owned(), value))
            .collect();
        parameters.push(("body_viscous_friction".to_owned(), bench.truth.body_viscous));
        parameters.push((
            "wheel_viscous_friction".to_owned(),
            bench.truth.wheel_viscous,
        ));
        let mut effects = vec![];
        for hidden in &bench.truth.hidden {
            if let Hidden::Library(effect, p) = hidden {
                for (info, value) in effect.info().parameters.iter().zip(p) {
                    parameters.push((info.name.to_owned(), *value));
                }
                if !outside {
                    effects.push(*effect);
                }
            }
        }
        effects.sort();
        Answer {
            effects,
            parameters,
            outside,
        }
    }
}

/// What a verdict is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Right: the true effects, "nothing missing" where nothing is, "ambiguous" where the logs
    /// leave a tie, "unexplained" for an outsider.
    Right,
    /// Less was said than the logs allow, but nothing wrong: "ambiguous" with the truth among the
    /// sets, or the true effects and "unexplained".
    Cautious,
    /// A tie was decided, by luck rightly.
    Lucky,
    /// Not confident, and the truth is not among what was named.
    Astray,
    /// An effect with a small trace was not seen.
    Missed,
    /// Nothing is hidden, and an effect was named or structure reported.
    FalseAlarm,
    /// A wrong confident verdict.
    Wrong,
}

impl Mark {
    /// In words.
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

/// An added parameter against its true value.
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
    /// Whether the 95 % interval holds the truth.
    pub fn covers(&self) -> bool {
        (self.value - self.truth).abs() <= 1.959_964 * self.std
    }
}

/// A marked verdict.
#[derive(Clone, Debug)]
pub struct Paper {
    /// The verdict.
    pub verdict: Verdict,
    /// The effects of its last step.
    pub named: Vec<EffectId>,
    /// All suspects with their probabilities, most probable first.
    pub suspects: Vec<(EffectId, f64)>,
    /// The sets that it says tie.
    pub ambiguous_between: Vec<Vec<EffectId>>,
    /// What remains, in units of noise.
    pub remainder: f64,
    /// The mark.
    pub mark: Mark,
    /// Effects that count as true: the hidden ones, and those of simpler sets that are no worse.
    pub accepted: Vec<EffectId>,
    /// The sets that tie with the truth, with their distance.
    pub ties: Vec<(Vec<EffectId>, f64)>,
    /// For each hidden effect its trace beside the others, in units of noise.
    pub shown: Vec<f64>,
    /// Added parameters against the truth, where the effects named are the true ones.
    pub intervals: Vec<Interval>,
    /// Time that the verdict took, identification included, s.
    pub seconds: f64,
}

/// A set of effects that was refitted beside the truth.
struct Rival {
    set: Vec<EffectId>,
    distance: f64,
    simpler: bool,
    /// The truth contains it, and shows this trace beyond it in units of noise.
    lacks: Option<f64>,
}

/// The true set fitted, started at what is known of its parameters.
pub fn fitted(setup: &Setup, base: &Minimum, effects: &[EffectId], answer: &Answer) -> Candidate {
    let records = setup.all_records();
    let model = effects
        .iter()
        .fold(Model::base(), |model, &effect| model.with(effect));
    let mut values = setup.start_values(&model);
    for (position, info) in model.parameters().iter().enumerate() {
        let known = answer.parameters.iter().find(|(name, _)| name == info.name);
        if let Some((_, value)) = known {
            values[position] = *value;
        } else if let Some(at) = Model::base().position_of(info.name) {
            values[position] = base.values[at];
        }
    }
    for (value, known) in values.iter_mut().zip(setup.known) {
        *value = known.unwrap_or(*value);
    }
    let free = setup.free(&model);
    // The starts of the logs are guessed once from the samples, once taken from the base fit; the
    // better end counts. Where both ends are bad, the schedule from short windows finds a better one.
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
        let again = fit_from_scratch(&records, &model, values, &free);
        if again.cost < minimum.cost {
            again
        } else {
            minimum
        }
    } else {
        minimum
    };
    Candidate::new(setup, &records, effects.to_vec(), model, minimum, None)
}

/// All sets that could stand in the place of the true one, by distance, and the true one's traces.
fn rivals(
    setup: &Setup,
    base: &Minimum,
    answer: &Answer,
    suspects: &[EffectId],
) -> (Vec<Rival>, Vec<f64>) {
    let records = setup.all_records();
    let truth = fitted(setup, base, &answer.effects, answer);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let each = (observations.max(2) as f64).ln();
    let mut candidates: Vec<Candidate> = vec![];
    let mut shown = vec![];
    let start = Candidate::new(setup, &records, vec![], Model::base(), base.clone(), None);
    candidates.push(start.clone());
    let mut froms = vec![start];
    for effect in &answer.effects {
        let mut rest = answer.effects.clone();
        rest.retain(|other| other != effect);
        if rest.is_empty() {
            shown.push(largest_trace(&records, &froms[0], &truth));
        } else {
            let without = fitted(setup, base, &rest, answer);
            shown.push(largest_trace(&records, &without, &truth));
            candidates.push(without.clone());
            froms.push(without);
        }
    }
    for from in froms {
        let (bench, from) = prepared(setup, from, suspects);
        let round = Round {
            most: usize::MAX,
            is_fitted: &|_| false,
            leader: None,
            only_where_something_remains: false,
        };
        candidates.extend(try_all(&bench, &from, &round));
    }
    let mut rivals: Vec<Rival> = vec![];
    for candidate in candidates {
        let set = candidate.set();
        // A larger set that holds the truth is no rival: parsimony decides.
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
    (rivals, shown)
}

/// Lets the diagnosis answer a bench, and marks it.
///
/// # Errors
/// In words, if the bench cannot be identified.
pub fn mark(setup: &Setup, answer: &Answer, suspects: &[EffectId]) -> Result<Paper, String> {
    let started = std::time::Instant::now();
    let base = Model::base();
    let found = identify(setup, &base, None).map_err(|error| error.to_string())?;
    let mut minimum = found.fit.minimum.clone();
    let options = Options { suspects };
    let progress = Progress::silent();
    let diagnosis = diagnose_with(setup, &base, found.fit.minimum, &options, &progress)
        .map_err(|cancelled| cancelled.to_string())?;
    let seconds = started.elapsed().as_secs_f64();
    // What the logs can decide is worked out without the pushes that the diagnosis leaves out, too.
    let cleared = setup.with_more_pushes(&base, &minimum.values);
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
    let setup = cleared.as_ref().unwrap_or(setup);
    let truth = answer.effects.iter();
    let truth = truth.fold(Model::base(), |model, &effect| model.with(effect));
    let suited = setup.suited_to(&truth);
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
    let setup = suited.as_ref();
    let (rivals, shown) = if answer.effects.is_empty() || answer.outside {
        (vec![], vec![])
    } else {
        rivals(setup, &minimum, answer, suspects)
    };
    Ok(marked(setup, answer, diagnosis, rivals, shown, seconds))
}

fn marked(
    setup: &Setup,
    answer: &Answer,
    diagnosis: Diagnosis,
    rivals: Vec<Rival>,
    shown: Vec<f64>,
    seconds: f64,
) -> Paper {
    let mut named: Vec<EffectId> = match diagnosis.last() {
        Some(step) => step.candidate.set(),
        None => vec![],
    };
    named.sort();
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
    // A limit of the true effect (dry friction for presliding) is the truth but for what it lacks.
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
    let intervals = match diagnosis.last() {
        Some(step) if named == answer.effects => intervals(setup, &step.fit, answer),
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

fn intervals(setup: &Setup, fit: &Fit, answer: &Answer) -> Vec<Interval> {
    let mut found = vec![];
    for effect in &answer.effects {
        for info in effect.info().parameters {
            let Some(position) = fit.model.position_of(info.name) else {
                continue;
            };
            // Per unit of inertia there is no true value to compare with.
            if setup.unit(&fit.model, position) != info.unit {
                continue;
            }
            let truth = answer.parameters.iter().find(|(name, _)| name == info.name);
            let (Some((_, truth)), Some(std)) = (truth, fit.std(position)) else {
                continue;
            };
            let mut value = fit.values[position];
            if info.name == "cogging_phase" {
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

/// The answer that a truth.json states.
///
/// # Errors
/// In words, if it names an effect that the library does not have.
pub fn answer_from(effects: &[String], parameters: Vec<(String, f64)>) -> Result<Answer, String> {
    let mut answer = Answer {
        effects: vec![],
        parameters,
        outside: false,
    };
    for name in effects {
        match EffectId::from_name(name) {
            Some(effect) => answer.effects.push(effect),
            None if name == "unknown" => answer.outside = true,
            None => {
                return Err(format!(
                    "\"{name}\" is no effect of the library; an outsider is called \"unknown\""
                ));
            }
        }
    }
    answer.effects.sort();
    Ok(answer)
}
