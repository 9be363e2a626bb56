//! `model.toml`: the parameters of a bench, the effects of its model, and the requirements of the design.
//!
//! A file that is read, changed and written keeps its comments, its order and the sections of other
//! tools. Numbers are written with the fewest digits that give the same number when read again.

use std::path::{Path, PathBuf};

use plant::{EffectId, LearnedCoordinate, Model, ParameterInfo};
use toml_edit::DocumentMut;

use crate::calibration::Calibration;
use crate::correlation::Correlation;
use crate::design_section::DesignSection;
use crate::effects_section::{self, EffectsSection, Tie};
use crate::error::{Error, Problem};
use crate::files::{Files, FilesInMemory};
use crate::hardware::Hardware;
use crate::learned_section;
use crate::own_effect::OwnEffect;
use crate::parameter::Parameter;
use crate::toml_source::TomlSource;
use crate::toml_writing::table_in;
use crate::verdict_section;
use crate::write::write_atomically;

/// The sections of a model.toml; `tool` belongs to other programs and is kept unchanged, except `[tool.flywheel]`.
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
    /// The effects that no log has shown upright; the linear model leaves them out.
    pub unseen_upright: Vec<EffectId>,
    /// The design's wishes, if the file has any.
    pub design: Option<DesignSection>,
    /// The results of the calibration, if the file has them.
    pub calibration: Option<Calibration>,
    /// The bench's sensors and its drive, as bench.toml states them.
    pub hardware: Option<Hardware>,
    /// The verdict of the last diagnosis in one sentence, if it found these parameters unable to explain the logs.
    /// Other parameters remove it.
    pub unexplained: Option<String>,
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
            && self.unexplained == other.unexplained
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
            unexplained: None,
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
            parameters.extend(Parameter::read(source, section, key, &own_effects)?);
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
            .map(|section| DesignSection::read(&section))
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
            unexplained: verdict_section::read(document.as_table()),
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
        self.unexplained = None;
        self.parameters.retain(Parameter::is_beside_the_motion);
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
            parameter.write(table_in(parameters, &parameter.name, false));
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
            Some(design) => design.write(table_in(root, "design", false)),
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
        verdict_section::write(root, self.unexplained.as_deref());
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
