//! `model.toml`: the parameters of a bench, the effects of its model, and the requirements of the design.
//!
//! A file that is read, changed and written keeps its comments, its order and the sections of other
//! tools. Numbers are written with the fewest digits that give the same number when read again.

use std::path::{Path, PathBuf};

use plant::{BASE_PARAMETERS, EffectId, LearnedCoordinate, Model, ParameterInfo};
use serde::{Deserialize, Serialize};
use toml_edit::{Array, DocumentMut, Value};

use crate::calibration::Calibration;
use crate::correlation::Correlation;
use crate::effects_section::{self, EffectsSection, Tie};
use crate::error::{Error, Names, Problem};
use crate::files::{Files, FilesInMemory};
use crate::hardware::Hardware;
use crate::keys;
use crate::learned_section;
use crate::own_effect::OwnEffect;
use crate::toml_source::{Section, TomlSource};
use crate::toml_writing::{number, set, table_in};
use crate::write::write_atomically;

/// The end of a parameter's unit if torques are known only per unit of inertia.
pub(crate) const PER_INERTIA: &str = " per kg m2";
/// Quantities that are no parameters of the motion but may stand here, with unit and range: j_b,
/// which follows from Θ (thesis, after 1.29), and l from plumb lines (thesis 3.4).
const BESIDE_THE_MOTION: [(&str, &str, (f64, f64)); 2] = [
    ("body_inertia", "kg m2", (0.0, 1e3)),
    ("pivot_to_com", "m", (-10.0, 10.0)),
];

/// The sections of a model.toml; `tool` belongs to other programs and is kept unchanged.
const SECTIONS: [&str; 9] = [
    "parameters",
    "correlation",
    "effects",
    "design",
    "calibration",
    "hardware",
    "learned",
    "own",
    "tool",
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
}

/// The requirements for the design of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignSection {
    /// Time between two commands, s.
    pub sample_time_s: f64,
    /// Diagonal of Q: weights of angle (1/rad²), rate (s²/rad²) and wheel speed (s²/rad²).
    pub state_weights: [f64; 3],
    /// R: weight of the current, 1/A².
    pub current_weight: f64,
    /// Largest current in either direction, A.
    pub current_limit_a: f64,
    /// ι in rad/s: Coulomb friction of the body enters the linear model as μ/ι; `None` to leave it out.
    pub friction_linearisation_speed_rad_s: Option<f64>,
    /// Time constant in s of an observer of a constant bias of the measured angle; such a bias
    /// would keep the wheel turning (thesis 5.1). Key `bias_time_constant`; `None` for no observer.
    pub bias_time_constant_s: Option<f64>,
}

/// A model.toml.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// The parameters, in the order of the file. Names are unique and known to the library.
    pub parameters: Vec<Parameter>,
    /// The correlations of the errors of the parameters; `None` if they are independent.
    pub correlation: Option<Correlation>,
    /// The effects of the model, in the order of the file.
    pub effects: Vec<EffectId>,
    /// The provisional effects and their rivals, if there is a tie between explanations.
    pub tie: Option<Tie>,
    /// Users' effects that the file itself defines; those of the model are written with it.
    pub own_effects: Vec<OwnEffect>,
    /// Those of the effects that no log has shown upright: the linear model does without them.
    pub unseen_upright: Vec<EffectId>,
    /// The design's wishes, if the file has any.
    pub design: Option<DesignSection>,
    /// The results of the calibration, if the file has them.
    pub calibration: Option<Calibration>,
    /// The bench's sensors and its drive, as bench.toml states them.
    pub hardware: Option<Hardware>,
    /// Where the file was read from.
    path: Option<PathBuf>,
    /// The text as it was read; it holds everything that the fields above do not.
    document: DocumentMut,
}

impl Default for ModelFile {
    fn default() -> Self {
        ModelFile::new()
    }
}

/// Two files are equal if their content is equal; comments and sections of other tools do not count.
impl PartialEq for ModelFile {
    fn eq(&self, other: &Self) -> bool {
        self.parameters == other.parameters
            && self.correlation == other.correlation
            && self.effects == other.effects
            && self.tie == other.tie
            && self.unseen_upright == other.unseen_upright
            && self.design == other.design
            && self.calibration == other.calibration
            && self.hardware == other.hardware
    }
}

impl ModelFile {
    /// A file without parameters and without design, with the effects of the base model.
    pub fn new() -> ModelFile {
        ModelFile {
            parameters: Vec::new(),
            correlation: None,
            effects: Model::base().effects().to_vec(),
            tie: None,
            own_effects: Vec::new(),
            unseen_upright: Vec::new(),
            design: None,
            calibration: None,
            hardware: None,
            path: None,
            document: DocumentMut::new(),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The first error, see [`Problem`].
    pub fn read(path: &Path) -> Result<ModelFile, Error> {
        ModelFile::from_source(&TomlSource::read(Files::Disk, path)?)
    }

    /// The `model.toml` among files that are in memory.
    ///
    /// # Errors
    /// As for [`ModelFile::read`].
    pub fn from_files(files: &FilesInMemory) -> Result<ModelFile, Error> {
        ModelFile::from_source(&TomlSource::read(
            Files::Memory(files),
            Path::new("model.toml"),
        )?)
    }

    /// Reads a text; `path` is the name of the file in errors.
    ///
    /// # Errors
    /// As for [`ModelFile::read`].
    pub fn parse(text: &str, path: &Path) -> Result<ModelFile, Error> {
        ModelFile::from_source(&TomlSource::new(path, text.to_string()))
    }

    fn from_source(source: &TomlSource) -> Result<ModelFile, Error> {
        let document = source.parse()?;
        let root = source.root(&document);
        root.allow_only(&SECTIONS)?;

        let mut own_effects = Vec::new();
        if let Some(section) = root.section("own")? {
            for key in section.keys() {
                if let Some(own) = section.section(&key.value)? {
                    own_effects.push(OwnEffect::read(source, &own, &key.value)?);
                }
            }
        }

        // A file that holds only a calibration has no effects yet.
        let section = root.section("parameters")?;
        let mut parameters = Vec::new();
        for (section, key) in section
            .iter()
            .flat_map(|section| section.keys().into_iter().map(move |key| (section, key)))
        {
            let info = unit_and_bounds(&key.value, &own_effects).ok_or_else(|| {
                source.error(
                    key.span.clone(),
                    Problem::UnknownName {
                        what: "parameter".to_string(),
                        name: key.value.clone(),
                        names: Names::new(parameter_names()),
                    },
                )
            })?;
            if let Some(entry) = section.section(&key.value)? {
                parameters.push(read_parameter(key.value, info, &entry)?);
            }
        }

        let (learned, of_curves) = learned_section::read(&root)?;
        let with_std: Vec<&str> = parameters
            .iter()
            .filter(|parameter| parameter.std.is_some())
            .map(|parameter| parameter.name.as_str())
            .collect();
        let correlation = root
            .section("correlation")?
            .map(|section| Correlation::read(&section, &with_std))
            .transpose()?;

        let missing_effects =
            "[effects] with present = [\"body-viscous-friction\", \"wheel-viscous-friction\"]";
        let section = root
            .section("effects")?
            .ok_or_else(|| root.error(root.missing("effects", missing_effects)))?;
        let EffectsSection {
            present: effects,
            tie,
            unseen_upright,
        } = EffectsSection::read(source, &section, &own_effects, &parameters, &learned)?;
        // What hangs together with a curve is not told.
        parameters.extend(of_curves);

        let design = root
            .section("design")?
            .map(|section| read_design(&section))
            .transpose()?;
        let calibration = root
            .section("calibration")?
            .map(|section| Calibration::read(&section))
            .transpose()?;
        Ok(ModelFile {
            parameters,
            correlation,
            effects,
            tie,
            own_effects,
            unseen_upright,
            design,
            calibration,
            hardware: Hardware::read(source, &root)?,
            path: Some(source.path().to_path_buf()),
            document: source.parse()?.into_mut(),
        })
    }

    /// The parameter with this name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.name == name)
    }

    /// Adds a parameter; a parameter with the same name is replaced, and its correlations are removed.
    pub fn set_parameter(&mut self, parameter: Parameter) {
        let others = self.correlation.take();
        self.correlation = others.and_then(|all| all.among(|name| name != parameter.name));
        match self
            .parameters
            .iter_mut()
            .find(|old| old.name == parameter.name)
        {
            Some(old) => *old = parameter,
            None => self.parameters.push(parameter),
        }
    }

    /// Replaces the parameters of the model and the correlations of their errors. Quantities that are not parameters of
    /// the motion (such as a centre of mass from plumb lines) are kept.
    pub fn replace_model_parameters(
        &mut self,
        parameters: Vec<Parameter>,
        correlation: Option<Correlation>,
    ) {
        self.correlation = correlation;
        let beside = |old: &Parameter| {
            BESIDE_THE_MOTION
                .iter()
                .any(|(name, _, _)| *name == old.name)
        };
        self.parameters.retain(beside);
        let beside = std::mem::replace(&mut self.parameters, parameters);
        for parameter in beside {
            if self.parameter(&parameter.name).is_none() {
                self.parameters.push(parameter);
            }
        }
    }

    /// The structure of the model: its effects in the order of the library.
    pub fn model(&self) -> Model {
        Model::with_effects(&self.effects)
    }

    /// The model about upright, as far as the logs have shown it there: without the effects of users that they have
    /// not. (A learned curve knows its own range: [`plant::has_seen`].)
    pub fn model_upright(&self) -> Model {
        let unseen = self.unseen_upright.iter();
        unseen.fold(self.model(), |model, &effect| model.without(effect))
    }

    /// The structure without what holds only until an experiment has decided.
    pub fn certain_model(&self) -> Model {
        let provisional = self.tie.iter().flat_map(|tie| &tie.provisional);
        provisional.fold(self.model(), |model, &effect| model.without(effect))
    }

    /// The parameter vector of [`ModelFile::model`], in SI units (or per unit of
    /// inertia, see [`Parameter::is_per_inertia`]).
    ///
    /// # Errors
    /// [`Problem::MissingParameter`] for the first parameter that the file does not contain.
    pub fn parameter_vector(&self) -> Result<Vec<f64>, Error> {
        self.model()
            .parameters()
            .iter()
            .map(|info| match self.parameter(info.name) {
                Some(parameter) => Ok(parameter.value),
                None => Err(self.missing_parameter(info)),
            })
            .collect()
    }

    fn missing_parameter(&self, info: &ParameterInfo) -> Error {
        let effect = self
            .effects
            .iter()
            .find(|effect| effect.info().parameters.iter().any(|p| p.name == info.name));
        Error::in_file(
            self.path(),
            Problem::MissingParameter {
                name: info.name,
                unit: info.unit,
                meaning: info.meaning,
                needed_by: match effect {
                    Some(effect) => format!("the effect \"{}\"", effect.name()),
                    None => "every model".to_string(),
                },
            },
        )
    }

    /// The requirements of the design.
    ///
    /// # Errors
    /// [`Problem::MissingKey`] if the file has none.
    pub fn require_design(&self) -> Result<DesignSection, Error> {
        self.design.ok_or_else(|| {
            Error::in_file(
                self.path(),
                Problem::MissingKey {
                    section: "the file".to_string(),
                    key: "design".to_string(),
                    example: "[design] with sample_time = 0.001, state_weights = [25.0, 0.5, 5e-4], current_weight = 1.0, current_limit = 2.0",
                },
            )
        })
    }

    /// The same file under the name `path`, where it is to be written; errors use this name.
    pub fn named(self, path: &Path) -> ModelFile {
        ModelFile {
            path: Some(path.to_path_buf()),
            ..self
        }
    }

    /// Where the file was read from, or is to be written; `model.toml` if that is not known.
    pub fn path(&self) -> &Path {
        self.path.as_deref().unwrap_or(Path::new("model.toml"))
    }

    /// The file's text.
    pub fn to_toml(&self) -> String {
        let mut document = self.document.clone();
        let root = document.as_table_mut();

        let parameters = table_in(root, "parameters", true);
        let gone: Vec<String> = parameters
            .iter()
            .map(|(name, _)| name.to_string())
            .filter(|name| self.parameter(name).is_none() || is_of_curve(name))
            .collect();
        for name in gone {
            parameters.remove(&name);
        }
        for parameter in &self.parameters {
            if is_of_curve(&parameter.name) {
                continue;
            }
            let entry = table_in(parameters, &parameter.name, false);
            set(entry, "value", number(parameter.value));
            match parameter.std {
                Some(std) => set(entry, "std", number(std)),
                None => {
                    entry.remove("std");
                }
            }
            for (key, text) in [("unit", &parameter.unit), ("source", &parameter.source)] {
                if text.is_empty() {
                    entry.remove(key);
                } else {
                    set(entry, key, Value::from(text.as_str()));
                }
            }
        }

        let has_std = |name: &str| {
            !is_of_curve(name) && self.parameter(name).is_some_and(|p| p.std.is_some())
        };
        match self.correlation.as_ref().and_then(|all| all.among(has_std)) {
            None => {
                root.remove("correlation");
            }
            Some(correlation) => correlation.write(root),
        }

        let effects = table_in(root, "effects", false);
        let unseen: Vec<EffectId> = self
            .unseen_upright
            .iter()
            .copied()
            .filter(|effect| self.effects.contains(effect))
            .collect();
        effects_section::write(effects, &self.effects, self.tie.as_ref(), &unseen);
        learned_section::write(root, &self.effects, &|name| self.parameter(name).cloned());

        root.remove("own");
        for own in &self.own_effects {
            if self.effects.contains(&own.effect) {
                let section = table_in(root, "own", true);
                section.insert(own.bare_name(), toml_edit::Item::Table(own.table()));
            }
        }

        match &self.design {
            None => {
                root.remove("design");
            }
            Some(design) => {
                let section = table_in(root, "design", false);
                set(section, "sample_time", number(design.sample_time_s));
                let weights: Array = design.state_weights.iter().map(|w| number(*w)).collect();
                set(section, "state_weights", Value::Array(weights));
                set(section, "current_weight", number(design.current_weight));
                set(section, "current_limit", number(design.current_limit_a));
                let optional = [
                    (
                        "friction_linearisation_speed",
                        design.friction_linearisation_speed_rad_s,
                    ),
                    ("bias_time_constant", design.bias_time_constant_s),
                ];
                for (key, value) in optional {
                    match value {
                        Some(value) => set(section, key, number(value)),
                        None => {
                            section.remove(key);
                        }
                    }
                }
            }
        }
        match &self.calibration {
            None => {
                root.remove("calibration");
            }
            Some(calibration) => calibration.write(root),
        }
        match &self.hardware {
            None => {
                root.remove("hardware");
            }
            Some(hardware) => hardware.write(root),
        }
        document.to_string()
    }

    /// Writes the file in one step. If the write is interrupted, the old file is unchanged.
    ///
    /// # Errors
    /// [`Problem::Unwritable`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        write_atomically(path, self.to_toml().as_bytes())
    }
}

/// Whether the parameter is a torque of a learned curve, which stands in `[learned]`.
fn is_of_curve(name: &str) -> bool {
    name.strip_prefix("learned_").is_some_and(|rest| {
        LearnedCoordinate::ALL
            .iter()
            .any(|coordinate| rest.starts_with(coordinate.name()))
    })
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

fn read_parameter(
    name: String,
    (si, (low, high)): (&'static str, (f64, f64)),
    entry: &Section,
) -> Result<Parameter, Error> {
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
    if !unit.is_empty() && plain_unit(bare) != plain_unit(si) {
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
    Ok(Parameter {
        name,
        value,
        std,
        unit,
        source: entry
            .text("source")?
            .map_or(String::new(), |source| source.value),
    })
}

/// A unit in one spelling: `kg m2`, `kg·m²` and `kg*m^2` are the same.
fn plain_unit(unit: &str) -> String {
    unit.replace('²', "2")
        .replace('³', "3")
        .replace(['·', '*', ' ', '^'], "")
}

fn read_design(section: &Section) -> Result<DesignSection, Error> {
    section.allow_only(&keys::names(keys::MODEL, "design"))?;
    let weights =
        section.required_three_numbers("state_weights", "state_weights = [25.0, 0.5, 5e-4]")?;
    if let Some(negative) = weights.value.iter().find(|weight| **weight < 0.0) {
        return Err(section.error_at(
            "state_weights",
            Problem::OutOfRange {
                key: "state_weights".to_string(),
                value: *negative,
                must_be: "zero or positive".to_string(),
            },
        ));
    }
    Ok(DesignSection {
        sample_time_s: section
            .required_positive_number("sample_time", "sample_time = 0.001 (s)")?,
        state_weights: weights.value,
        current_weight: section
            .required_positive_number("current_weight", "current_weight = 1.0")?,
        current_limit_a: section
            .required_positive_number("current_limit", "current_limit = 2.0 (A)")?,
        friction_linearisation_speed_rad_s: section
            .positive_number("friction_linearisation_speed")?
            .map(|speed| speed.value),
        bias_time_constant_s: section
            .positive_number("bias_time_constant")?
            .map(|time| time.value),
    })
}
