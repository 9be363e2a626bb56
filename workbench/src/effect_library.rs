//! Descriptions of the effects of the library.

use plant::{EffectId, Kind, Role};
use serde::{Deserialize, Serialize};

/// An effect of the library.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EffectDescription {
    /// Its name in model.toml, on the command line and in every report.
    pub name: String,
    /// `body`, `wheel`, `motor` or `sensor`.
    pub role: String,
    /// Its physical cause.
    pub meaning: String,
    /// The term as a formula.
    pub equation: String,
    /// The source of the term.
    pub source: String,
    /// What the effect looks like in the measurements.
    pub fingerprint: String,
    /// The kinds of experiment in which it is visible.
    pub shows_in: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<EffectParameter>,
    /// The effects that it contains, and therefore replaces.
    pub replaces: Vec<String>,
    /// The effects that some logs cannot distinguish from it.
    pub confused_with: Vec<String>,
}

/// A parameter of an effect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EffectParameter {
    /// Its name.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// The meaning of the parameter, in words.
    pub meaning: String,
}

/// Every effect of the library, in the order in which terms are evaluated.
pub fn effect_library() -> Vec<EffectDescription> {
    EffectId::ALL
        .iter()
        .map(|effect| described(*effect))
        .collect()
}

fn described(effect: EffectId) -> EffectDescription {
    let info = effect.info();
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    EffectDescription {
        name: info.name.to_owned(),
        role: match info.role {
            Role::Body => "body",
            Role::Wheel => "wheel",
            Role::Motor => "motor",
            Role::Sensor => "sensor",
        }
        .to_owned(),
        meaning: info.meaning.to_owned(),
        equation: info.equation.to_owned(),
        source: info.source.to_owned(),
        fingerprint: info.fingerprint.to_owned(),
        shows_in: info
            .shows_in
            .iter()
            .map(|kind: &Kind| kind.name().to_owned())
            .collect(),
        parameters: info
            .parameters
            .iter()
            .map(|parameter| EffectParameter {
                name: parameter.name.to_owned(),
                unit: parameter.unit.to_owned(),
                meaning: parameter.meaning.to_owned(),
            })
            .collect(),
        replaces: owned(info.replaces),
        confused_with: owned(info.confused_with),
    }
}
