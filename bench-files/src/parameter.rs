//! The section `[parameters.NAME]` of a model: one parameter, and which of them there are.

use plant::{BASE_PARAMETERS, EffectId, ParameterInfo};
use serde::{Deserialize, Serialize};
use toml_edit::{TableLike, Value};

use crate::error::{Error, Names, Problem};
use crate::keys;
use crate::own_effect::OwnEffect;
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};
use crate::toml_writing::{number, set};

/// The end of a parameter's unit on a bench whose torques are known only per unit of inertia.
pub(crate) const PER_INERTIA: &str = " per kg m2";

/// Quantities that may stand in the section although they are no parameters of the motion, with unit and range: j_b,
/// which follows from Θ (thesis, after 1.29), and l from plumb lines (thesis 3.4).
const BESIDE_THE_MOTION: [(&str, &str, (f64, f64)); 2] = [
    ("body_inertia", "kg m2", (0.0, 1e3)),
    ("pivot_to_com", "m", (-10.0, 10.0)),
];

/// One parameter of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name in the contract.
    pub name: String,
    /// Its value in `unit`.
    pub value: f64,
    /// Its standard error in `unit`; `None` for a value that was written by hand or measured directly.
    pub std: Option<f64>,
    /// SI unit; "… per kg m2" for a torque without a known scale. If empty, the SI unit of the parameter.
    pub unit: String,
    /// The source of the value: experiments, `[known]`, a publication. May be empty.
    pub source: String,
}

impl Parameter {
    /// Whether the value is known only per unit of inertia.
    pub fn is_per_inertia(&self) -> bool {
        self.unit.ends_with(PER_INERTIA)
    }

    /// Reads one parameter of the section `[parameters]`; `None` where its key holds no table.
    ///
    /// # Errors
    /// A name that is not known, and what is wrong with an entry.
    pub(crate) fn read(
        source: &TomlSource,
        parameters: &Section,
        key: Located<String>,
        own: &[OwnEffect],
    ) -> Result<Option<Parameter>, Error> {
        let (si, (low, high)) = unit_and_bounds(&key.value, own).ok_or_else(|| {
            source.error(
                key.span.clone(),
                Problem::UnknownName {
                    what: "parameter".to_string(),
                    name: key.value.clone(),
                    names: Names::new(parameter_names()),
                },
            )
        })?;
        let Some(entry) = parameters.section(&key.value)? else {
            return Ok(None);
        };
        let name = key.value;
        entry.allow_only(&keys::names(keys::MODEL, "parameters"))?;
        let value = entry
            .number("value")?
            .ok_or_else(|| entry.error(entry.missing("value", "value = 2.3e-3")))?
            .value;
        let std = entry.number("std")?.map(|std| std.value);
        if let Some(std) = std
            && std < 0.0
        {
            return Err(entry.error_at(
                "std",
                Problem::OutOfRange {
                    key: "std".to_string(),
                    value: std,
                    must_be: "zero or positive".to_string(),
                },
            ));
        }
        let unit = entry.text("unit")?.map_or(String::new(), |unit| unit.value);
        let per_inertia = unit.ends_with(PER_INERTIA);
        let bare = unit.strip_suffix(PER_INERTIA).unwrap_or(&unit);
        if !unit.is_empty() && in_one_spelling(bare) != in_one_spelling(si) {
            return Err(entry.error_at("unit", Problem::UnitNotSi { name, unit, si }));
        }
        if !per_inertia && !(low..=high).contains(&value) {
            return Err(entry.error_at(
                "value",
                Problem::OutOfRange {
                    key: name,
                    value,
                    must_be: format!("between {low} and {high} {si}"),
                },
            ));
        }
        Ok(Some(Parameter {
            name,
            value,
            std,
            unit,
            source: entry
                .text("source")?
                .map_or(String::new(), |source| source.value),
        }))
    }

    /// Writes the entry of the parameter.
    pub(crate) fn write(&self, entry: &mut dyn TableLike) {
        set(entry, "value", number(self.value));
        match self.std {
            Some(std) => set(entry, "std", number(std)),
            None => {
                entry.remove("std");
            }
        }
        for (key, text) in [("unit", &self.unit), ("source", &self.source)] {
            if text.is_empty() {
                entry.remove(key);
            } else {
                set(entry, key, Value::from(text.as_str()));
            }
        }
    }

    /// Whether this quantity may stand among the parameters although it is none of the motion.
    pub(crate) fn is_beside_the_motion(&self) -> bool {
        BESIDE_THE_MOTION
            .iter()
            .any(|(name, _, _)| *name == self.name)
    }
}

/// Unit and bounds of a parameter, if there is one with this name.
fn unit_and_bounds(name: &str, own: &[OwnEffect]) -> Option<(&'static str, (f64, f64))> {
    let beside = BESIDE_THE_MOTION
        .iter()
        .find(|(known, _, _)| *known == name);
    if let Some((_, unit, bounds)) = beside {
        return Some((unit, *bounds));
    }
    let own = own.iter().flat_map(|own| own.effect.info().parameters);
    let is_own = |info: &&ParameterInfo| {
        // One of those that there are for each log.
        let own = info.name.strip_suffix("EXPERIMENT");
        own.map_or(info.name == name, |own| {
            name.len() > own.len() && name.starts_with(own)
        })
    };
    library_parameters()
        .chain(own)
        .find(is_own)
        .map(|info| (info.unit, info.bounds))
}

/// The base parameters, and the parameters of all effects.
fn library_parameters() -> impl Iterator<Item = &'static ParameterInfo> {
    BASE_PARAMETERS.iter().chain(
        EffectId::ALL
            .iter()
            .flat_map(|effect| effect.info().parameters),
    )
}

fn parameter_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = Vec::new();
    let beside = BESIDE_THE_MOTION.iter().map(|(name, _, _)| *name);
    for name in library_parameters().map(|info| info.name).chain(beside) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// A unit in one spelling: `kg m2`, `kg·m²` and `kg*m^2` are the same.
fn in_one_spelling(unit: &str) -> String {
    unit.replace('²', "2")
        .replace('³', "3")
        .replace(['·', '*', ' ', '^'], "")
}
