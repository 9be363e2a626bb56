//! The section `[effects]` of a model: its effects, and which of them are provisional until an experiment decides.

use plant::{EffectId, LearnedCoordinate};
use toml_edit::{Array, TableLike, Value};

use crate::error::{Error, Names, Problem};
use crate::own_effect::OwnEffect;
use crate::parameter::Parameter;
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};
use crate::toml_writing::set;

/// A tie between explanations: one of them is in the model, the others could replace it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tie {
    /// The provisional effects of the model; not empty.
    pub provisional: Vec<EffectId>,
    /// The sets of effects that could replace them; no set is empty.
    pub rivals: Vec<Vec<EffectId>>,
}

/// The content of the section.
pub(crate) struct EffectsSection {
    /// The effects of the model.
    pub present: Vec<EffectId>,
    /// The open tie, if there is one.
    pub tie: Option<Tie>,
    /// The present effects that no log has shown near upright. The linear model leaves them out.
    pub unseen_upright: Vec<EffectId>,
}

impl EffectsSection {
    /// Reads the section; `own` are the effects that the file itself defines, `learned` its curves. A curve that
    /// the file holds is part of the model, whether it is listed or not.
    pub fn read(
        source: &TomlSource,
        section: &Section,
        own: &[OwnEffect],
        parameters: &[Parameter],
        learned: &[EffectId],
    ) -> Result<EffectsSection, Error> {
        section.allow_only(&crate::keys::names(crate::keys::MODEL, "effects"))?;
        let own: Vec<EffectId> = own
            .iter()
            .map(|own| own.effect)
            .chain(learned.iter().copied())
            .collect();
        let own = own.as_slice();
        let names = section.texts("present")?.ok_or_else(|| {
            section.error(section.missing("present", "present = [\"body-viscous-friction\"]"))
        })?;
        let mut present = Vec::new();
        for name in names {
            let effect = of_logs(known(source, &name, own)?, parameters);
            if let Some(other) = present.iter().find(|other| excludes(**other, effect)) {
                return Err(source.error(
                    name.span,
                    Problem::EffectTwice {
                        effect: effect.name(),
                        other: other.name(),
                    },
                ));
            }
            present.push(effect);
        }
        for curve in learned {
            if !present.contains(curve) {
                present.push(*curve);
            }
        }
        let mut unseen_upright = vec![];
        for name in section.texts("unseen_upright")?.unwrap_or_default() {
            unseen_upright.push(known(source, &name, own)?);
        }
        let mut provisional = vec![];
        for name in section.texts("provisional")?.unwrap_or_default() {
            let effect = of_logs(known(source, &name, own)?, parameters);
            if !present.contains(&effect) {
                return Err(source.error(
                    name.span,
                    Problem::ProvisionalAbsent {
                        effect: effect.name(),
                    },
                ));
            }
            provisional.push(effect);
        }
        let mut rivals = vec![];
        for set in section.lists_of_texts("rivals")?.unwrap_or_default() {
            let set = set.iter().map(|name| known(source, name, own));
            rivals.push(set.collect::<Result<Vec<EffectId>, Error>>()?);
        }
        rivals.retain(|set| !set.is_empty());
        let tie = (!provisional.is_empty()).then_some(Tie {
            provisional,
            rivals,
        });
        Ok(EffectsSection {
            present,
            tie,
            unseen_upright,
        })
    }
}

/// An effect with the parameters that the file has for its logs.
fn of_logs(effect: EffectId, parameters: &[Parameter]) -> EffectId {
    let logs = parameters.iter().filter_map(|one| effect.log_of(&one.name));
    effect.for_logs(&logs.map(str::to_owned).collect::<Vec<_>>())
}

/// Writes the section.
pub(crate) fn write(
    section: &mut dyn TableLike,
    present: &[EffectId],
    tie: Option<&Tie>,
    unseen_upright: &[EffectId],
) {
    let names = |effects: &[EffectId]| -> Array { effects.iter().map(|one| one.name()).collect() };
    set(section, "present", Value::Array(names(present)));
    if unseen_upright.is_empty() {
        section.remove("unseen_upright");
    } else {
        set(
            section,
            "unseen_upright",
            Value::Array(names(unseen_upright)),
        );
    }
    let Some(tie) = tie else {
        section.remove("provisional");
        section.remove("rivals");
        return;
    };
    set(
        section,
        "provisional",
        Value::Array(names(&tie.provisional)),
    );
    let rivals: Array = tie.rivals.iter().map(|set| names(set)).collect();
    set(section, "rivals", Value::Array(rivals));
}

fn known(source: &TomlSource, name: &Located<String>, own: &[EffectId]) -> Result<EffectId, Error> {
    let of_file = || {
        own.iter()
            .copied()
            .find(|effect| effect.name() == name.value)
    };
    if let (None, Some(coordinate)) = (of_file(), LearnedCoordinate::from_effect_name(&name.value))
    {
        let section = coordinate.name();
        return Err(source.error(
            name.span.clone(),
            Problem::Curve(format!(
                "the curve \"{}\" needs a section [learned.{section}] with knots and torque",
                name.value
            )),
        ));
    }
    EffectId::from_name(&name.value)
        .or_else(of_file)
        .ok_or_else(|| {
            source.error(
                name.span.clone(),
                Problem::UnknownName {
                    what: "effect".to_string(),
                    name: name.value.clone(),
                    names: Names::new(
                        EffectId::ALL
                            .iter()
                            .copied()
                            .chain(own.iter().copied())
                            .map(|effect| effect.name()),
                    ),
                },
            )
        })
}

/// Whether a model cannot have both effects: they are equal, or one contains the other.
fn excludes(a: EffectId, b: EffectId) -> bool {
    a == b || a.info().replaces.contains(&b.name()) || b.info().replaces.contains(&a.name())
}
