//! Users' effects: a torque as a formula, in `effects/NAME.toml` of the bench folder, or as `[own.NAME]` in
//! a model.toml, which is then complete without the bench.
//!
//! The formula gives the torque as it acts, positive in the direction of positive angles. The library counts torques
//! against the motion.

mod definition;
mod expression;

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use plant::{EffectId, Role};
use toml_edit::{Array, DocumentMut, Table, Value, value};

use crate::error::{Error, Names, Problem};
use crate::files::Files;
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};
use crate::toml_writing::number;
use definition::define;
use expression::{Formula, Meaning};

/// Prefix of the names of users' effects.
pub const OWN_PREFIX: &str = "own:";
/// The folder beside bench.toml.
const FOLDER: &str = "effects";
/// The quantities of the motion that a torque may depend on, in the order of a formula's variables.
const MOTION: [&str; 5] = ["angle", "rate", "wheel_speed", "wheel_angle", "current"];

/// An effect that a user has defined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnEffect {
    /// The effect; its name is `own:NAME`.
    pub effect: EffectId,
    /// Its definition as text, in a canonical form.
    text: String,
}

/// A text with its place, and one parameter as it is read.
struct ParameterText {
    name: String,
    unit: String,
    starts: Vec<f64>,
    bounds: (f64, f64),
}

impl OwnEffect {
    /// All effects in the folder of a bench, by name.
    pub(crate) fn all_of(files: Files, folder: &Path) -> Result<Vec<OwnEffect>, Error> {
        let folder = folder.join(FOLDER);
        let mut paths = files.toml_files_in(&folder)?;
        paths.sort();
        let effects = paths.iter().map(|path| {
            let name = path
                .file_stem()
                .map_or("".into(), |stem| stem.to_string_lossy());
            let source = TomlSource::read(files, path)?;
            let document = source.parse()?;
            OwnEffect::read(&source, &source.root(&document), &name)
        });
        effects.collect()
    }

    /// All effects in the folder of a bench on the disk, by name.
    ///
    /// # Errors
    /// The first thing that is wrong with one of them.
    pub fn of_folder(folder: &Path) -> Result<Vec<OwnEffect>, Error> {
        OwnEffect::all_of(Files::Disk, folder)
    }

    /// Whether a text could stand in `effects/NAME.toml`: read as that file is, but the effect is not kept. Returns
    /// the names of its parameters.
    ///
    /// # Errors
    /// What is wrong with it, with line and column; `path` names the file.
    pub fn check(text: &str, name: &str, path: &Path) -> Result<Vec<String>, Error> {
        let source = TomlSource::new(path, text.to_owned());
        let document = source.parse()?;
        let parsed = Parsed::read(&source, &source.root(&document), name)?;
        let parameters = parsed.parameters.into_iter();
        Ok(parameters.map(|parameter| parameter.name).collect())
    }

    /// Reads one.
    pub(crate) fn read(
        source: &TomlSource,
        section: &Section,
        name: &str,
    ) -> Result<OwnEffect, Error> {
        let Parsed {
            role,
            torque,
            fingerprint,
            parameters,
            formula,
            text,
        } = Parsed::read(source, section, name)?;
        let content = format!("{OWN_PREFIX}{name}\n{text}");
        let effect = EffectId::external(&content, || {
            define(name, role, &torque, fingerprint, &parameters, formula)
        })
        .map_err(|error| section.error(Problem::Formula(error.to_string())))?;
        Ok(OwnEffect { effect, text })
    }

    /// NAME, without what stands before it.
    pub fn bare_name(&self) -> &'static str {
        let name = self.effect.name();
        name.strip_prefix(OWN_PREFIX).unwrap_or(name)
    }

    /// The definition as a table for `[own.NAME]`.
    pub(crate) fn table(&self) -> Table {
        let document: Result<DocumentMut, _> = self.text.parse();
        // The text was made here.
        let mut table =
            document.map_or_else(|_| Table::new(), |document| document.as_table().clone());
        forget_places(&mut table);
        table
    }
}

/// An effect as it was read, before it is defined.
struct Parsed {
    role: Role,
    torque: String,
    fingerprint: Option<String>,
    parameters: Vec<ParameterText>,
    formula: Formula,
    /// The definition in one form.
    text: String,
}

impl Parsed {
    fn read(source: &TomlSource, section: &Section, name: &str) -> Result<Parsed, Error> {
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || !name.chars().all(is_plain) {
            return Err(section.error(Problem::Formula(
                "the name of an effect has letters, digits, - and _ only".to_owned(),
            )));
        }
        let role_text = section.required_text("role", "role = \"body\" (or \"wheel\")")?;
        let role = match role_text.value.as_str() {
            "body" => Role::Body,
            "wheel" => Role::Wheel,
            _ => {
                return Err(section.error_at(
                    "role",
                    Problem::UnknownName {
                        what: "role".to_owned(),
                        name: role_text.value.clone(),
                        names: Names::new(["body", "wheel"]),
                    },
                ));
            }
        };
        let torque = section.required_text("torque", "torque = \"-k*angle\"")?;
        let fingerprint = section.text("fingerprint")?.map(|text| text.value);
        let parameters = parameters(section)?;
        let mut definitions: Vec<Located<String>> = vec![];
        let mut texts: Vec<(String, Located<String>)> = vec![];
        for key in section.keys() {
            if crate::keys::names(crate::keys::OWN_EFFECT, "own").contains(&key.value.as_str()) {
                continue;
            }
            let is_taken = MOTION.contains(&key.value.as_str())
                || parameters.iter().any(|one| one.name == key.value);
            if is_taken {
                return Err(source.error(
                    key.span.clone(),
                    Problem::Formula(format!("\"{}\" has a meaning already", key.value)),
                ));
            }
            let text = section.required_text(&key.value, "a formula in quotation marks")?;
            definitions.push(key.clone());
            texts.push((key.value.clone(), text));
        }
        let formula = formulas(source, &texts, &torque, &parameters)?;
        let text = canonical(
            &role_text.value,
            &torque.value,
            &texts,
            fingerprint.as_deref(),
            &parameters,
        );
        Ok(Parsed {
            role,
            torque: torque.value,
            fingerprint,
            parameters,
            formula,
            text,
        })
    }
}

/// Removes the positions of tables, so that they are written where they are inserted.
fn forget_places(table: &mut Table) {
    table.set_position(None);
    for (_, item) in table.iter_mut() {
        if let Some(inner) = item.as_table_mut() {
            forget_places(inner);
        }
    }
}

/// `[parameters.NAME]`, in the order of the file.
fn parameters(section: &Section) -> Result<Vec<ParameterText>, Error> {
    let Some(table) = section.section("parameters")? else {
        return Err(section.error(section.missing(
            "parameters",
            "[parameters.k] with unit = \"N m/rad\", start = 1e-3",
        )));
    };
    let mut found = vec![];
    for key in table.keys() {
        let Some(entry) = table.section(&key.value)? else {
            continue;
        };
        entry.allow_only(&crate::keys::names(
            crate::keys::OWN_EFFECT,
            "own.parameters",
        ))?;
        let starts = match entry.numbers("start", &[0], "a number, or a list of numbers") {
            Ok(Some(list)) if !list.is_empty() => list,
            _ => vec![entry.required_number("start")?],
        };
        let bounds = match entry
            .numbers("bounds", &[2], "two numbers, [low, high]")?
            .as_deref()
        {
            Some([low, high]) if low < high => (*low, *high),
            Some(_) => {
                return Err(entry.error_at(
                    "bounds",
                    Problem::Formula("the first bound must lie below the second".to_owned()),
                ));
            }
            None => (f64::NEG_INFINITY, f64::INFINITY),
        };
        if let Some(outside) = starts
            .iter()
            .find(|start| !(bounds.0..=bounds.1).contains(*start))
        {
            return Err(entry.error_at(
                "start",
                Problem::OutOfRange {
                    key: "start".to_owned(),
                    value: *outside,
                    must_be: format!("between {} and {}", bounds.0, bounds.1),
                },
            ));
        }
        found.push(ParameterText {
            unit: entry.required_text("unit", "unit = \"N m\"")?.value,
            name: key.value,
            starts,
            bounds,
        });
    }
    if found.is_empty() {
        return Err(table.error(Problem::Formula(
            "an effect needs at least one parameter for the fit".to_owned(),
        )));
    }
    Ok(found)
}

/// The torque with all definitions inserted. A definition may use others from anywhere in the file.
fn formulas(
    source: &TomlSource,
    texts: &[(String, Located<String>)],
    torque: &Located<String>,
    parameters: &[ParameterText],
) -> Result<Formula, Error> {
    let error = |text: &Located<String>, at: usize, what: String| {
        // The quotation mark precedes the first byte of the formula.
        let from = (text.span.start + 1 + at).min(text.span.end.saturating_sub(1));
        let place: Range<usize> = from..(from + 1).min(text.span.end);
        source.error(place, Problem::Formula(what))
    };
    let mut done: Vec<(&str, Formula)> = vec![];
    let read = |text: &Located<String>, done: &[(&str, Formula)]| {
        let mut names: BTreeMap<&str, Meaning> = BTreeMap::new();
        names.insert("pi", Meaning::Number(std::f64::consts::PI));
        let own = parameters.iter().map(|one| one.name.as_str());
        for (variable, name) in MOTION.into_iter().chain(own).enumerate() {
            names.insert(name, Meaning::Variable(variable));
        }
        for (name, formula) in done {
            names.insert(name, Meaning::Formula(formula));
        }
        Formula::read(&text.value, &names)
    };
    let mut open: Vec<&(String, Located<String>)> = texts.iter().collect();
    while !open.is_empty() {
        let before = open.len();
        let mut failed = None;
        let mut still = vec![];
        for one in open {
            match read(&one.1, &done) {
                Ok(formula) => done.push((one.0.as_str(), formula)),
                Err(found) => {
                    failed.get_or_insert((one, found));
                    still.push(one);
                }
            }
        }
        open = still;
        if let Some(((name, text), found)) = failed
            && open.len() == before
        {
            let waits = open
                .iter()
                .any(|(other, _)| found.what.contains(&format!("\"{other}\"")));
            let what = if waits {
                format!(
                    "the definition of {name} depends on itself, or on a definition that is wrong"
                )
            } else {
                found.what
            };
            return Err(error(text, found.at, what));
        }
    }
    read(torque, &done).map_err(|found| error(torque, found.at, found.what))
}

/// The definition in canonical form.
fn canonical(
    role: &str,
    torque: &str,
    texts: &[(String, Located<String>)],
    fingerprint: Option<&str>,
    parameters: &[ParameterText],
) -> String {
    let mut document = DocumentMut::new();
    document["role"] = value(role);
    document["torque"] = value(torque);
    for (name, text) in texts {
        document[name.as_str()] = value(text.value.as_str());
    }
    if let Some(fingerprint) = fingerprint {
        document["fingerprint"] = value(fingerprint);
    }
    let mut list = Table::new();
    list.set_implicit(true);
    for one in parameters {
        let mut entry = Table::new();
        entry["unit"] = value(one.unit.as_str());
        let starts: Array = one.starts.iter().map(|start| number(*start)).collect();
        entry["start"] = value(Value::Array(starts));
        if one.bounds.0.is_finite() || one.bounds.1.is_finite() {
            let bounds: Array = [one.bounds.0, one.bounds.1]
                .map(number)
                .into_iter()
                .collect();
            entry["bounds"] = value(Value::Array(bounds));
        }
        list.insert(&one.name, toml_edit::Item::Table(entry));
    }
    document.insert("parameters", toml_edit::Item::Table(list));
    document.to_string()
}
