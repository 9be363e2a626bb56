//! The reasons for suspecting an effect, as JSON: fingerprints without and with the effect, and the recipe that settles
//! a tie.

use serde_json::{Value, json};
use workbench::numbers::{significant, with_prefix};
use workbench::{
    ComparisonReport, Coordinate, EffectFingerprint, Output, Recipe, ResidualKind, SwingDecay,
    TorquePart, words,
};

/// Largest number of pictures of residuals in a diagnosis.
const MOST_REASONS: usize = 3;

/// How a swing dies out over its amplitude: measured, by a model, and by another one.
pub fn decay(swing: &SwingDecay, other: Option<&SwingDecay>) -> Option<Value> {
    let measured = swing.measured.as_ref()?;
    let points = |series: &[identify::AtAmplitude]| -> Vec<[f64; 3]> {
        let at = series.iter();
        at.map(|at| [at.amplitude_rad, at.value, at.std]).collect()
    };
    let simulated = swing.simulated.as_ref();
    let other = other.and_then(|other| other.simulated.as_ref());
    Some(json!({
        "experiment": swing.experiment,
        "law": swing.laws.first().map(words::amplitude_law),
        "rates": points(&measured.rates),
        "periods": points(&measured.small_swing_periods),
        "model_rates": simulated.map(|one| points(&one.rates)),
        "model_periods": simulated.map(|one| points(&one.small_swing_periods)),
        "other_rates": other.map(|one| points(&one.rates)),
        "other_periods": other.map(|one| points(&one.small_swing_periods)),
    }))
}

/// An effect's fingerprint: the torque that the model lacks without it (before) and with it (after), over every
/// coordinate over which it shows; decays by the model with it, and by the other without.
pub fn fingerprint(found: &EffectFingerprint) -> Value {
    let decays = found.decay_with.iter().filter_map(|swing| {
        let mut all = found.decay_without.iter();
        let other = all.find(|other| other.experiment == swing.experiment)?;
        shows(swing, other).then(|| decay(swing, Some(other)))?
    });
    let torques = found.torques().into_iter().map(|torque| {
        json!({
            "experiment": torque.experiment,
            "channel": torque.channel,
            "residual": part_in_words(ResidualKind::ResidualTorque, torque.part),
            "is_torque": true,
            "unit": found.without.torque_unit(torque.channel),
            "coordinate": words::spoken(torque.coordinate.name()),
            "coordinate_unit": torque.coordinate.unit(),
            "before": torque.without,
            "after": torque.with,
        })
    });
    let torques: Vec<Value> = torques.collect();
    json!({
        "effect": found.effect,
        // What shows in no torque may show in the output of a sensor.
        "reasons": if torques.is_empty() { reasons(&found.without, &found.with) } else { torques },
        "decay": decays.collect::<Vec<_>>(),
    })
}

/// The residuals in which the first model fails most plainly, with the last model beside them.
pub fn reasons(first: &ComparisonReport, last: &ComparisonReport) -> Vec<Value> {
    let mut seen = Vec::new();
    let significant = || first.places.iter().filter(|place| place.significant);
    // A torque shows the cause directly; an output shows its accumulated effect since the start of the log.
    let has_torque = significant().any(|place| place.residual == ResidualKind::ResidualTorque);
    for place in significant() {
        if has_torque && place.residual != ResidualKind::ResidualTorque {
            continue;
        }
        let key = (
            place.experiment.as_str(),
            place.channel.as_str(),
            place.residual,
            place.coordinate,
        );
        if !seen.contains(&key) {
            seen.push(key);
        }
    }
    let with_key = |of: &ComparisonReport, key: &(&str, &str, ResidualKind, Coordinate)| {
        let mut all = of.breakdowns.iter();
        let own = all.find(|one| {
            (
                one.experiment.as_str(),
                one.channel,
                one.quantity,
                one.coordinate,
            ) == *key
        });
        own.cloned()
    };
    seen.iter()
        .take(MOST_REASONS)
        .filter_map(|key| {
            let &(experiment, channel, residual, coordinate) = key;
            let unit = match residual {
                ResidualKind::ResidualTorque => first.torque_unit(channel),
                ResidualKind::Output => {
                    let mut outputs = Output::ALL.into_iter();
                    outputs.find(|output| output.name() == channel)?.unit()
                }
            };
            let before = with_key(first, key)?;
            let part = TorquePart::plainest(&before);
            Some(json!({
                "experiment": experiment,
                "channel": channel,
                "residual": part_in_words(residual, part),
                "is_torque": residual == ResidualKind::ResidualTorque,
                "unit": unit,
                "coordinate": words::spoken(coordinate.name()),
                "coordinate_unit": coordinate.unit(),
                "before": part.points(&before),
                "after": with_key(last, key).map(|after| part.points(&after)),
            }))
        })
        .collect()
}

fn part_in_words(residual: ResidualKind, part: TorquePart) -> String {
    match part {
        TorquePart::Mean => words::residual(residual).to_owned(),
        TorquePart::AlongMotion => format!("{} along the motion", words::residual(residual)),
    }
}

/// Standard errors of a measured point by which two models differ where the swing tells them apart for the eye.
const APART: f64 = 2.0;

/// Whether the effect shows in how this swing dies out: the models without and with it are apart, at some measured
/// amplitude, by more than the measurement is uncertain there.
fn shows(with: &SwingDecay, without: &SwingDecay) -> bool {
    let (Some(measured), Some(a), Some(b)) = (&with.measured, &with.simulated, &without.simulated)
    else {
        return true;
    };
    let near = |points: &[identify::AtAmplitude], amplitude_rad: f64| {
        let distance = |at: &&identify::AtAmplitude| (at.amplitude_rad - amplitude_rad).abs();
        let nearest = points
            .iter()
            .min_by(|x, y| distance(x).total_cmp(&distance(y)));
        nearest.map(|at| at.value)
    };
    let apart = |points: &[identify::AtAmplitude],
                 a: &[identify::AtAmplitude],
                 b: &[identify::AtAmplitude]| {
        points.iter().any(|at| {
            let both = near(a, at.amplitude_rad).zip(near(b, at.amplitude_rad));
            both.is_some_and(|(a, b)| (a - b).abs() > APART * at.std)
        })
    };
    apart(&measured.rates, &a.rates, &b.rates)
        || apart(
            &measured.small_swing_periods,
            &a.small_swing_periods,
            &b.small_swing_periods,
        )
}

/// The experiment that settles a tie, and what each explanation would show in it.
pub fn recipe(recipe: &Recipe, ties: &[Vec<String>]) -> Value {
    let names: Vec<String> = ties.iter().map(|set| set.join(" + ")).collect();
    let spread = |index: usize| {
        let values = recipe.answers.iter().filter_map(|answer| answer.get(index));
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(ends, |(low, high), value| {
            (low.min(*value), high.max(*value))
        });
        high - low
    };
    let indices = 0..recipe.time_s.len();
    let widest = indices.max_by(|a, b| spread(*a).total_cmp(&spread(*b)));
    let said = widest.map(|index| {
        let each = recipe
            .answers
            .iter()
            .zip(&names)
            .filter_map(|(answer, name)| {
                Some(format!(
                    "{} by {name}",
                    with_prefix(*answer.get(index)?, recipe.unit)
                ))
            });
        format!(
            "At {} s the {} would be {}.",
            significant(recipe.time_s[index], 3),
            words::spoken(recipe.channel),
            each.collect::<Vec<_>>().join(", ")
        )
    });
    json!({
        "experiment": recipe.experiment,
        "steps": recipe.steps,
        "channel": words::spoken(recipe.channel),
        "unit": recipe.unit,
        "difference": format!(
            "{} times the noise of the sensor (root mean square)",
            significant(recipe.difference_over_noise, 3)
        ),
        "widest": said,
        "time_s": recipe.time_s,
        "answers": recipe.answers,
        "names": names,
    })
}
