//! A session on a bench.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use ::data_check::Finding;
use bench_files::{
    Bench, DesignSection, FilesInMemory, ModelFile, OWN_PREFIX, OwnEffect, Problem, ReadingWatch,
    Tie,
};
use design::Settings;
use identify::{FitProblem, Identification, IdentifyError, Output, Progress, Record};
use plant::{EffectId, Instant, Model, Smoothing};

use crate::comparison::{ComparisonReport, correlation_of, parameters_of, with_model};
use crate::data_check;
use crate::error::Error;

/// A bench with its measurements, and the model that is being developed for it.
///
/// A session begins with the model in the bench's folder, or without one. Its methods change
/// the model in memory; [`Session::save_model`] writes it.
#[derive(Clone, Debug)]
pub struct Session {
    bench: Bench,
    /// Warnings about the data; the data are used nevertheless.
    findings: Vec<Finding>,
    problem: FitProblem,
    /// Path from which the model was read, or to which it would be written.
    model_path: PathBuf,
    /// Whether the bench is on the disk; otherwise it is in memory.
    on_disk: bool,
    model: Option<ModelFile>,
    /// The fit from which `model` comes, if it was made in this session.
    fitted: Option<Identification>,
}

impl Session {
    /// Opens a bench: its folder, or its bench.toml. The model is `model.toml` beside it.
    ///
    /// # Errors
    /// The first error in a file; [`Error::Data`] if a model from these data would be wrong;
    /// [`Error::Identify`] if no experiment can be used.
    pub fn open(path: &Path) -> Result<Session, Error> {
        Session::open_with_model(path, None)
    }

    /// Opens a bench like [`Session::open`]; `model` is another path for the model.
    ///
    /// # Errors
    /// The first error in a file; [`Error::Data`] if a model from these data would be wrong; [`Error::Identify`] if no
    /// experiment can be used.
    pub fn open_with_model(path: &Path, model: Option<&Path>) -> Result<Session, Error> {
        Session::open_reporting(path, model, &Progress::silent())
    }

    /// Opens a bench like [`Session::open_with_model`], and reports to `progress` how much of each log has been read.
    ///
    /// # Errors
    /// The first error in a file; [`Error::Data`] if a model from these data would be wrong; [`Error::Identify`] if no
    /// experiment can be used; [`Error::Cancelled`].
    pub fn open_reporting(
        path: &Path,
        model: Option<&Path>,
        progress: &Progress,
    ) -> Result<Session, Error> {
        let watch = ReadingWatch {
            read: &|file, read, of| (progress.say)(&reading(file, read, of)),
            cancelled: progress.cancelled,
        };
        let bench = match Bench::load_watched(path, watch) {
            Ok(bench) => bench,
            Err(error) => {
                progress.check()?;
                return Err(error.into());
            }
        };
        progress.check()?;
        (progress.say)("preparing the logs");
        let model_path = match model {
            Some(path) => path.to_path_buf(),
            None => bench.folder.join("model.toml"),
        };
        let mut session = Session::new(bench, model_path, true)?;
        session.model = match ModelFile::read(&session.model_path) {
            Ok(mut model) => {
                adopt_own_effects(&mut model, &session.bench);
                Some(session.with_hardware(model))
            }
            Err(error) if matches!(error.problem(), Problem::NotFound) => None,
            Err(error) => return Err(error.into()),
        };
        progress.check()?;
        Ok(session)
    }

    /// Opens a bench whose files are in memory: `bench.toml`, the logs that it lists and, if there is
    /// one, `model.toml`.
    ///
    /// # Errors
    /// The first error in a file; [`Error::Data`] if a model from these data would be wrong; [`Error::Identify`] if no
    /// experiment can be used.
    pub fn from_files(files: &FilesInMemory) -> Result<Session, Error> {
        let mut session = Session::from_bench(Bench::from_files(files)?)?;
        if files.contains("model.toml") {
            let mut model = ModelFile::from_files(files)?;
            adopt_own_effects(&mut model, &session.bench);
            session.model = Some(session.with_hardware(model));
        }
        Ok(session)
    }

    /// Opens a bench that the caller has built.
    ///
    /// # Errors
    /// [`Error::Data`] if a model from these data would be wrong; [`Error::Identify`] if no experiment can be used.
    pub fn from_bench(bench: Bench) -> Result<Session, Error> {
        Session::new(bench, PathBuf::from("model.toml"), false)
    }

    fn new(bench: Bench, model_path: PathBuf, on_disk: bool) -> Result<Session, Error> {
        let findings = data_check::usable(&bench)?;
        let problem = FitProblem::new(&bench).map_err(|source| Error::Identify {
            bench: place_of(&bench),
            source,
        })?;
        Ok(Session {
            bench,
            findings,
            problem,
            model_path,
            on_disk,
            model: None,
            fitted: None,
        })
    }

    /// The experiments as they are simulated.
    pub(crate) fn records(&self) -> &[Record] {
        &self.problem.records
    }

    /// The measurements.
    pub fn bench(&self) -> &Bench {
        &self.bench
    }

    /// Warnings about the data; the data are used nevertheless.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    pub(crate) fn set_own_effects(&mut self, effects: Vec<OwnEffect>) {
        self.bench.own_effects = effects;
        if let Some(mut model) = self.model.take() {
            adopt_own_effects(&mut model, &self.bench);
            self.model = Some(model);
        }
        self.fitted = None;
    }

    /// The measurements in the form that fits use, for work that the session does not offer.
    pub fn problem(&self) -> &FitProblem {
        &self.problem
    }

    /// The present model; `None` before the first identification.
    pub fn model(&self) -> Option<&ModelFile> {
        self.model.as_ref()
    }

    /// Path to which [`Session::save_model`] writes; `model.toml` for a bench in memory.
    pub fn model_path(&self) -> &Path {
        &self.model_path
    }

    /// Replaces the session's model.
    pub fn set_model(&mut self, model: ModelFile) {
        self.model = Some(self.with_hardware(model));
        self.fitted = None;
    }

    /// Sets which effects of the model are provisional.
    pub(crate) fn set_tie(&mut self, tie: Option<Tie>) {
        if let Some(file) = &mut self.model {
            file.tie = tie;
        }
    }

    /// A model, with the sensors and the drive that bench.toml states.
    fn with_hardware(&self, mut model: ModelFile) -> ModelFile {
        if let Some(hardware) = &self.bench.hardware {
            model.hardware = Some(hardware.clone());
        }
        model
    }

    /// Writes the model to the path from which it was read, completely or not at all; does nothing if there is
    /// no model.
    ///
    /// # Errors
    /// [`Error::NoPlace`] for a bench in memory; a path that cannot be written to.
    pub fn save_model(&self) -> Result<(), Error> {
        let Some(model) = &self.model else {
            return Ok(());
        };
        if !self.on_disk {
            return Err(Error::NoPlace);
        }
        if let Some(folder) = self.model_path.parent() {
            // An error here is reported by the write, which then fails, too.
            let _ = std::fs::create_dir_all(folder);
        }
        Ok(model.write(&self.model_path)?)
    }

    /// The effects of the model as it is; the base model where there is none.
    pub(crate) fn structure(&self) -> Model {
        self.model
            .as_ref()
            .map_or_else(Model::base, ModelFile::model)
    }

    pub(crate) fn required_model(&self) -> Result<&ModelFile, Error> {
        self.model.as_ref().ok_or_else(|| Error::NoModel {
            model: self.model_path.clone(),
            bench: place_of(&self.bench),
        })
    }

    /// The bench's folder, or its name if it is in memory.
    pub(crate) fn place(&self) -> PathBuf {
        place_of(&self.bench)
    }

    /// Fits `model` to all experiments, unless the last fit of this session was of the same model.
    pub(crate) fn fit(&self, model: &Model, progress: &Progress) -> Result<Identification, Error> {
        let found = self.fit_however(model, progress)?;
        self.refuse_failed(&found)?;
        Ok(found)
    }

    /// Whether the session holds a fit of this model.
    pub(crate) fn is_fitted(&self, model: &Model) -> bool {
        let fitted = self.fitted.as_ref();
        fitted.is_some_and(|found| found.fit.model == *model)
    }

    /// A fit that has failed, as an error.
    pub(crate) fn refuse_failed(&self, found: &Identification) -> Result<(), Error> {
        identify::refuse_failed(&self.problem, &found.fit)
            .map_err(|source| self.not_identified(source))
    }

    /// Fits `model` like [`Session::fit`], but accepts a model that does not follow the logs.
    pub(crate) fn fit_however(
        &self,
        model: &Model,
        progress: &Progress,
    ) -> Result<Identification, Error> {
        if let Some(found) = self
            .fitted
            .as_ref()
            .filter(|found| found.fit.model == *model)
        {
            return Ok(found.clone());
        }
        progress.check()?;
        (progress.say)("fitting the model to all experiments");
        let found = identify::fit_until(&self.problem, model, None, progress)
            .map_err(|source| self.not_identified(source))?;
        Ok(found)
    }

    /// The error for a bench that could not be identified; a cancelled fit is not an error of the bench.
    pub(crate) fn not_identified(&self, source: IdentifyError) -> Error {
        match source {
            IdentifyError::Cancelled(cancelled) => Error::Cancelled(cancelled),
            source => Error::Identify {
                bench: self.place(),
                source,
            },
        }
    }

    pub(crate) fn comparison_of(&self, found: &Identification) -> ComparisonReport {
        let path = self.model_path.clone();
        let findings = self.findings.clone();
        ComparisonReport::of_identification(&self.bench, &self.problem, path, found, findings)
    }

    /// Makes a fit the session's model.
    pub(crate) fn adopt(&mut self, found: Identification) {
        let fit = &found.fit;
        let parameters = parameters_of(&self.problem, fit);
        let mut file = with_model(
            self.file_or_new(),
            &fit.model,
            parameters,
            correlation_of(fit),
        );
        file.unseen_upright = self.unseen_upright(&fit.model, &fit.values);
        self.model = Some(file);
        self.fitted = Some(found);
    }

    /// The users' effects whose torque depends on the body's angle, if no log has the body upright: their torque there
    /// is a guess.
    pub(crate) fn unseen_upright(&self, model: &Model, values: &[f64]) -> Vec<EffectId> {
        let is_seen = self.problem.records.iter().any(|record| {
            let angle = record.channel(Output::Angle);
            let samples = || angle.iter().flat_map(|channel| &channel.samples);
            samples().any(|angle| *angle >= PI) && samples().any(|angle| *angle <= PI)
        });
        let own = model.ranges().filter(|(effect, own)| {
            effect.name().starts_with(OWN_PREFIX) && depends_on_angle(*effect, &values[own.clone()])
        });
        match is_seen {
            true => vec![],
            false => own.map(|(effect, _)| effect).collect(),
        }
    }

    /// The model's file as it is, or a new one, with a design in it.
    pub(crate) fn file_or_new(&self) -> ModelFile {
        let file = self.model.clone().unwrap_or_default();
        let mut file = self.with_hardware(file).named(&self.model_path);
        file.design.get_or_insert_with(|| self.usual_design());
        adopt_own_effects(&mut file, &self.bench);
        file
    }

    /// The requirements of a design for a model without a `[design]` section: the weights and the sample time of
    /// the thesis (1 ms, independent of the logs' sampling rate), and the current limit of the bench's
    /// own controller, if it has one.
    pub fn usual_design(&self) -> DesignSection {
        let controller = self.bench.controller;
        let usual = Settings::usual(controller.map(|own| own.current_limit_a));
        DesignSection {
            sample_time_s: usual.sample_time_s,
            state_weights: usual.weights.state.into(),
            current_weight: usual.weights.current,
            current_limit_a: usual.current_limit_a,
            friction_linearisation_speed_rad_s: None,
            bias_time_constant_s: None,
        }
    }

    /// The parameter vector of the file. Parameters that no log of this bench depends on may be missing.
    pub(crate) fn parameter_values(&self, file: &ModelFile) -> Result<Vec<f64>, Error> {
        let problem = &self.problem;
        let model = file.model();
        let free = problem.free(&model);
        let mut values = problem.start_values(&model);
        for (position, info) in model.parameters().iter().enumerate() {
            match file.parameter(info.name) {
                Some(parameter) => {
                    let unit = problem.unit(&model, position);
                    if parameter.is_per_inertia() != unit.ends_with("per kg m2") {
                        return Err(Error::ParameterUnit {
                            model: file.path().to_path_buf(),
                            bench: self.place(),
                            parameter: info.name.to_owned(),
                            found: parameter.unit.clone(),
                            unit,
                        });
                    }
                    values[position] = parameter.value;
                }
                None if free.contains(&position) => {
                    return Err(Error::ParameterMissing {
                        model: file.path().to_path_buf(),
                        bench: self.place(),
                        parameter: info.name.to_owned(),
                    });
                }
                None => {}
            }
        }
        Ok(values)
    }
}

/// "reading swing.csv: 12 of 500 MB".
fn reading(file: &Path, read: u64, of: u64) -> String {
    const MEGABYTE: f64 = 1e6;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let (read, of) = (read as f64 / MEGABYTE, of as f64 / MEGABYTE);
    format!("reading {name}: {read:.0} of {of:.0} MB")
}

/// Adds the user's effects of the bench to a model. If the model file defines an effect of the same name
/// differently, the definition in the bench is used.
fn adopt_own_effects(file: &mut ModelFile, bench: &Bench) {
    for own in &bench.own_effects {
        let name = own.effect.name();
        let old = file
            .own_effects
            .iter()
            .position(|old| old.effect.name() == name);
        match old {
            Some(index) => file.own_effects[index] = own.clone(),
            None => file.own_effects.push(own.clone()),
        }
        for effect in &mut file.effects {
            if effect.name() == name {
                *effect = own.effect;
            }
        }
    }
}

/// The name of a bench in errors: its folder, or its name if it is in memory.
fn place_of(bench: &Bench) -> PathBuf {
    if bench.folder.as_os_str().is_empty() {
        PathBuf::from(&bench.name)
    } else {
        bench.folder.clone()
    }
}

/// Whether a torque changes with the angle of the body, at any of a few instants.
fn depends_on_angle(effect: EffectId, p: &[f64]) -> bool {
    (1..=12).any(|point| {
        let spread = |k: f64| (f64::from(point) * (0.618 + 0.1 * k)).fract() * 2.0 - 1.0;
        let at = |angle_rad: f64| {
            let instant = Instant {
                angle_rad,
                rate_rad_s: 5.0 * spread(1.0),
                wheel_angle_rad: 3.0 * spread(2.0),
                wheel_speed_rad_s: 100.0 * spread(3.0),
                current_a: 2.0 * spread(6.0),
                memory: 0.0,
            };
            effect.torque(p, &instant, &Smoothing::SIMULATION)
        };
        at(PI * spread(4.0)) != at(PI * spread(5.0))
    })
}
