//! A bench: `bench.toml` and the logs that it lists.

use crate::numbers::number;
use std::path::{Path, PathBuf};

use parallel::parallel_map;

use crate::error::{Error, Problem};
use crate::experiment::Experiment;
use crate::experiment_plan::ExperimentPlan;
use crate::files::{Files, FilesInMemory, ReadingWatch};
use crate::hardware::Hardware;
use crate::keys;
use crate::known::Known;
use crate::own_effect::OwnEffect;
use crate::toml_section::Section;
use crate::toml_source::TomlSource;

/// A bench with all its measurements, checked and in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Its name; the name of the folder if bench.toml does not give one.
    pub name: String,
    /// The folder of bench.toml; paths of logs are relative to it. Empty for a bench in memory.
    pub folder: PathBuf,
    /// The values that were measured directly.
    pub known: Known,
    /// The controller of the balance logs.
    pub controller: Option<Controller>,
    /// Its sensors and its drive, if bench.toml states them.
    pub hardware: Option<Hardware>,
    /// The experiments in the order of the file; at least one, names unique.
    pub experiments: Vec<Experiment>,
    /// The effects that the user has defined, by name.
    pub own_effects: Vec<OwnEffect>,
    /// Notes for the user that concern no single experiment, as sentences.
    pub notes: Vec<String>,
}

/// The controller under which balance logs were recorded: u = −K (α − π, α̇, φ̇), clipped to the
/// current limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Gains K for angle (A/rad), rate (A s/rad) and wheel speed (A s/rad).
    pub gains: [f64; 3],
    /// Largest current in either direction, A.
    pub current_limit_a: f64,
    /// Time between two commands, s.
    pub sample_time_s: f64,
}

impl Bench {
    /// Loads a bench and all its logs. `path` is the bench's folder or its bench.toml.
    ///
    /// # Errors
    /// The first error, see [`Problem`].
    pub fn load(path: &Path) -> Result<Bench, Error> {
        Bench::load_from(path, Files::Disk)
    }

    /// As [`Bench::load`], with progress reports and the possibility to cancel.
    ///
    /// # Errors
    /// As for [`Bench::load`]; [`Problem::Unreadable`] if the reading was cancelled.
    pub fn load_watched(path: &Path, watch: ReadingWatch) -> Result<Bench, Error> {
        watch.over(|watch| Bench::load_from(path, Files::Watched(watch)))
    }

    fn load_from(path: &Path, files: Files) -> Result<Bench, Error> {
        let file = bench_file(path)?;
        let folder = folder_of(&file);
        let source = TomlSource::read(files, &file)?;
        let document = source.parse()?;
        read_bench(files, &source, &source.root(&document), folder)
    }

    /// As [`Bench::load`], from files in memory, one of them `bench.toml`.
    ///
    /// # Errors
    /// As for [`Bench::load`].
    pub fn from_files(files: &FilesInMemory) -> Result<Bench, Error> {
        let files = Files::Memory(files);
        let source = TomlSource::read(files, Path::new("bench.toml"))?;
        let document = source.parse()?;
        read_bench(files, &source, &source.root(&document), PathBuf::new())
    }

    /// The experiment with this name.
    pub fn experiment(&self, name: &str) -> Option<&Experiment> {
        self.experiments
            .iter()
            .find(|experiment| experiment.name == name)
    }
}

/// The sections of bench.toml.
pub(crate) const SECTIONS: [&str; 8] = [
    "bench",
    "known",
    "controller",
    "experiment",
    "calibration",
    "hardware",
    "bring_up",
    // A section for other programs; its content is not read.
    "tool",
];

/// The path of bench.toml, from the path of a bench's folder or of that file.
pub(crate) fn bench_file(path: &Path) -> Result<PathBuf, Error> {
    if path.is_dir() {
        return Ok(path.join("bench.toml"));
    }
    if path.exists() {
        return Ok(path.to_path_buf());
    }
    Err(Error::in_file(path, Problem::NoBench))
}

/// The folder of a file.
pub(crate) fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn read_bench(
    files: Files,
    source: &TomlSource,
    root: &Section,
    folder: PathBuf,
) -> Result<Bench, Error> {
    root.allow_only(&SECTIONS)?;
    let mut name = None;
    if let Some(section) = root.section("bench")? {
        section.allow_only(&keys::names(keys::BENCH, "bench"))?;
        name = section.text("name")?.map(|name| name.value);
    }
    let (known, computed) = Known::read(root.section("known")?.as_ref())?;
    let mut notes = Vec::new();
    if let (Some(stated), Some(computed)) = (known.gravity_torque, computed) {
        notes.push(format!(
            "gravity_torque = {stated} N m is used; masses and lengths give {} N m",
            number(computed)
        ));
    }
    let controller = root
        .section("controller")?
        .map(|section| read_controller(&section))
        .transpose()?;

    let hardware = Hardware::read(source, root)?;

    let sections = root.sections("experiment")?;
    if sections.is_empty() {
        return Err(root.error(Problem::NoExperiment));
    }
    // The whole of bench.toml is checked before the first log is opened.
    let mut plans: Vec<ExperimentPlan> = Vec::new();
    for section in &sections {
        let plan = ExperimentPlan::read(section, &folder)?;
        if let Some(first) = plans.iter().find(|p| p.name.value == plan.name.value) {
            return Err(source.error(
                plan.name.span,
                Problem::DuplicateExperiment {
                    name: plan.name.value,
                    first_line: source.line(&first.name.span),
                },
            ));
        }
        plans.push(plan);
    }
    // The logs are read at the same time; of several errors, the first in the order of bench.toml is reported.
    let loaded = parallel_map(plans.into_iter().zip(&sections), |(plan, section)| {
        plan.load(files, source, section)
    });
    let experiments = loaded.into_iter().collect::<Result<Vec<_>, Error>>()?;
    Ok(Bench {
        own_effects: OwnEffect::all_of(files, &folder)?,
        name: name.unwrap_or_else(|| folder_name(&folder)),
        folder,
        known,
        controller,
        hardware,
        experiments,
        notes,
    })
}

fn folder_name(folder: &Path) -> String {
    folder
        .canonicalize()
        .ok()
        .as_deref()
        .and_then(Path::file_name)
        .map_or_else(
            || "bench".to_string(),
            |name| name.to_string_lossy().into_owned(),
        )
}

fn read_controller(section: &Section) -> Result<Controller, Error> {
    section.allow_only(&keys::names(keys::BENCH, "controller"))?;
    Ok(Controller {
        gains: section
            .required_three_numbers("gains", "gains = [-24.27, -2.13, -0.0226]")?
            .value,
        current_limit_a: section
            .required_positive_number("current_limit", "current_limit = 2.0 (A)")?,
        sample_time_s: section
            .required_positive_number("sample_time", "sample_time = 0.001 (s)")?,
    })
}
