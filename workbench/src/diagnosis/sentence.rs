//! The verdict of a diagnosis in words.

use diagnose::{Diagnosis, Verdict};
use identify::Contradiction;
use plant::EffectId;

use crate::comparison::{ComparisonReport, FailurePlace};
use crate::numbers::significant;
use crate::words;

/// The verdict as one or two sentences; `last` is the model of the last step.
pub(super) fn sentence(found: &Diagnosis, last: &ComparisonReport) -> String {
    let first = found.steps.first();
    let was_there = |effect: &EffectId| first.is_some_and(|step| step.fit.model.has(*effect));
    let added: Vec<&str> = found
        .certain
        .effects()
        .iter()
        .filter(|effect| !was_there(effect))
        .map(|effect| effect.name())
        .collect();
    let added = added.join(" and ");
    let noise = if found.remainder > 0.0 {
        format!(
            "noise, with structure of at most {} of a sensor's noise",
            significant(found.remainder, 2)
        )
    } else {
        "nothing but noise".to_owned()
    };
    let text = match found.verdict {
        Verdict::NothingMissing => {
            format!("Nothing is missing: what the model leaves in the measurements is {noise}.")
        }
        Verdict::Explained => format!(
            "Explained: the model lacks {added}. What remains in the measurements is then \
             {noise}."
        ),
        Verdict::Ambiguous => {
            let beside = match added.as_str() {
                "" => String::new(),
                added => format!(" The effects that all explanations share were added: {added}."),
            };
            format!(
                "Ambiguous: something is missing, but these logs cannot tell {}.{beside}",
                rivals(found, " from ")
            )
        }
        Verdict::Unexplained if !found.contradictions.is_empty() => {
            let with = match added.as_str() {
                "" => String::new(),
                added => format!(" with {added}"),
            };
            let sentences = found.contradictions.iter();
            let sentences: Vec<String> = sentences.map(Contradiction::sentence).collect();
            format!(
                "Unexplained: the model{with} fits every log, but its parameters contradict each other: {}.",
                sentences.join("; ")
            )
        }
        Verdict::Unexplained => {
            let missing = match (added.as_str(), found.ambiguous_between.is_empty()) {
                ("", true) => "an error".to_owned(),
                (added, true) => format!("the model lacks {added}, and a further error"),
                ("", false) => format!(
                    "the model lacks one of several effects ({}: these logs cannot tell them apart), and a \
                     further error",
                    rivals(found, " or ")
                ),
                (added, false) => format!(
                    "the model lacks {added} and one of several effects ({}: these logs cannot tell them apart), \
                     and a further error",
                    rivals(found, " or ")
                ),
            };
            format!(
                "Unexplained: {missing} remains{}: {} times the noise of the sensor. No effect \
                 of the library accounts for this error.",
                remains_at(&last.places),
                significant(found.remainder, 2)
            )
        }
    };
    text + &until_decided(found)
}

/// "body-presliding-friction from body-coulomb-friction + body-softening-spring".
fn rivals(found: &Diagnosis, between: &str) -> String {
    let sets = found.ambiguous_between.iter();
    let sets: Vec<String> = sets
        .map(|set| words::set(set.iter().map(|effect| effect.name())))
        .collect();
    sets.join(between)
}

/// The model that is used while a tie is open, and the reason.
fn until_decided(found: &Diagnosis) -> String {
    let names = provisional_effects(found);
    let reasons: Vec<&str> = names
        .iter()
        .filter_map(|name| Some(EffectId::from_name(name)?.info().prior.reason))
        .collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        " Until an experiment decides between them, the model uses {}, because this is the most common one ({}), not \
         because it fits better.",
        names.join(" + "),
        reasons.join("; ")
    )
}

/// " at angle 0.1 to 0.2 rad in free swing 52 deg (71 % of the error of this log)": the most significant place that
/// holds at least half of an error. Nothing if the error is spread over more than any place.
fn remains_at(places: &[FailurePlace]) -> String {
    let mut places = places.iter();
    places
        .find(|place| place.share_of_error >= 0.5)
        .map_or(String::new(), |place| {
            format!(
                " at {} in {} ({:.0} % of the error of this log)",
                words::place(place),
                place.experiment,
                100.0 * place.share_of_error
            )
        })
}

/// The effects of the last model that are not certain.
pub(super) fn provisional_effects(found: &Diagnosis) -> Vec<String> {
    let effects = found
        .last()
        .map_or(&[][..], |step| step.fit.model.effects());
    let open = effects.iter().filter(|one| !found.certain.has(**one));
    open.map(|one| one.name().to_owned()).collect()
}
