//! The conclusions of a session from its measurements: whether they agree, the model that is fitted to them, and the
//! comparison of the model with them.

use ::data_check::Finding;
use identify::{Contradiction, Identification, Progress, PushModel};
use plant::Model;
use serde::{Deserialize, Serialize};

use crate::comparison::{BenchNote, Compared, ComparisonReport, LoggedExperiment, Said, notes};
use crate::error::Error;
use crate::predictor::{Started, with_changes};
use crate::session::Session;

/// The condition of the data, before anything is concluded from them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchCheck {
    /// The bench.
    pub bench: String,
    /// The experiments as they were read.
    pub experiments: Vec<LoggedExperiment>,
    /// The notes from reading the files.
    pub notes: Vec<BenchNote>,
    /// Warnings about the data; the data are used nevertheless.
    pub findings: Vec<Finding>,
    /// Experiments and direct measurements that cannot all be right; sentences.
    pub contradictions: Vec<String>,
}

impl Session {
    /// Checks the data: how the files were read, and which results contradict each other. The
    /// contradictions need a fit of the model (of the base model if there is none yet).
    ///
    /// # Errors
    /// [`Error::Identify`] if no start gives a finite simulation; [`Error::Cancelled`].
    pub fn check(&self, progress: &Progress) -> Result<BenchCheck, Error> {
        let found = self.fit(&self.structure(), progress)?;
        (progress.say)("looking for contradictions");
        let minimum = &found.fit.minimum;
        let contradictions = identify::contradictions(
            self.problem(),
            &found.fit.model,
            &minimum.values,
            &minimum.windows,
            &[],
        );
        Ok(BenchCheck {
            bench: self.bench().name.clone(),
            experiments: self.records().iter().map(LoggedExperiment::of).collect(),
            notes: notes(self.bench()),
            findings: self.findings().to_vec(),
            contradictions: contradictions.iter().map(Contradiction::sentence).collect(),
        })
    }

    /// Fits the base model, with the effects of the session's model, to all experiments.
    ///
    /// # Errors
    /// [`Error::Identify`] if no start gives a finite simulation; [`Error::Cancelled`].
    pub fn identify(&mut self, progress: &Progress) -> Result<ComparisonReport, Error> {
        self.identify_as(&self.structure(), progress)
    }

    /// Fits the base model alone, with viscous friction and no other effect, to all experiments.
    ///
    /// # Errors
    /// [`Error::Identify`] if no start gives a finite simulation; [`Error::Cancelled`].
    pub fn identify_base(&mut self, progress: &Progress) -> Result<ComparisonReport, Error> {
        self.identify_as(&Model::base(), progress)
    }

    /// Fits the session's model to all experiments, started from these values of its parameters and from the model's
    /// values of the others. It is for users who have moved parameters by hand to the neighbourhood of the minimum.
    ///
    /// # Errors
    /// Those of [`Session::predictor`] and of [`Session::identify`].
    pub fn identify_from(
        &mut self,
        start: &[(&str, f64)],
        progress: &Progress,
    ) -> Result<ComparisonReport, Error> {
        let started = self.started(progress)?;
        let values = with_changes(&started.model, &started.minimum.values, start)?;
        (progress.say)("fitting the model to all experiments");
        let previous = Some((values, started.minimum.windows));
        let found = identify::identify_until(self.problem(), &started.model, previous, progress)
            .map_err(|source| self.not_identified(source))?;
        let comparison = self.comparison_of(&found);
        self.adopt(found);
        Ok(comparison)
    }

    /// Sets parameters of the model to other values, without standard errors; `source` states where the values
    /// come from. The correlations of the errors are removed, and so are quantities that were derived from a
    /// changed parameter.
    ///
    /// # Errors
    /// [`Error::NoModel`], [`Error::UnknownParameter`].
    pub fn set_parameters(&mut self, values: &[(&str, f64)], source: &str) -> Result<(), Error> {
        let file = self.required_model()?;
        let model = file.model();
        // The names are checked before anything changes.
        with_changes(&model, &vec![0.0; model.parameters().len()], values)?;
        let mut file = file.clone();
        let mut parameters = file.parameters.clone();
        parameters.retain(|parameter| parameter.name != "body_inertia");
        for (name, value) in values {
            let old = parameters.iter_mut().find(|old| old.name == *name);
            if let Some(old) = old {
                old.value = *value;
                old.std = None;
                source.clone_into(&mut old.source);
            }
        }
        file.replace_model_parameters(parameters, None);
        self.set_model(file);
        Ok(())
    }

    /// Fits this model to all experiments and makes it that of the session.
    pub(crate) fn identify_as(
        &mut self,
        model: &Model,
        progress: &Progress,
    ) -> Result<ComparisonReport, Error> {
        let found = self.fit(model, progress)?;
        let comparison = self.comparison_of(&found);
        progress.check()?;
        self.adopt(found);
        Ok(comparison)
    }

    /// The fit of the session's model. It continues from the values of the model file, if this file has them: the fit
    /// that a diagnosis has found is not lost.
    pub(crate) fn present_fit(
        &self,
        model: &Model,
        progress: &Progress,
    ) -> Result<Identification, Error> {
        let is_stored = self.model().is_some_and(|file| file.model() == *model);
        let has_curve = model.learned().next().is_some();
        if !is_stored || has_curve || self.is_fitted(model) {
            return self.fit(model, progress);
        }
        let Started { minimum, .. } = match self.started(progress) {
            Ok(started) => started,
            Err(Error::Cancelled(cancelled)) => return Err(Error::Cancelled(cancelled)),
            // The file lacks a value that this bench needs.
            Err(_) => return self.fit(model, progress),
        };
        let previous = Some((minimum.values, minimum.windows));
        (progress.say)("fitting the model to all experiments");
        let found = identify::fit_until(self.problem(), model, previous, progress);
        let is_good = |found: &Identification| self.refuse_failed(found).is_ok();
        match found.map_err(|source| self.not_identified(source)) {
            Ok(found) if is_good(&found) => Ok(found),
            Err(Error::Cancelled(cancelled)) => Err(Error::Cancelled(cancelled)),
            _ => self.fit(model, progress),
        }
    }

    /// As [`Session::identify_as`], and also from the fit of a neighbouring model.
    pub(crate) fn identify_beside(
        &mut self,
        neighbour: &Identification,
        model: &Model,
        progress: &Progress,
    ) -> Result<ComparisonReport, Error> {
        (progress.say)("fitting the model to all experiments");
        let found = identify::fit_from_neighbour(self.problem(), &neighbour.fit, model, progress)
            .map_err(|source| self.not_identified(source))?;
        self.refuse_failed(&found)?;
        let comparison = self.comparison_of(&found);
        progress.check()?;
        self.adopt(found);
        Ok(comparison)
    }

    /// Compares the present model with every experiment. Only the start of each log (its angle, its speed)
    /// is fitted, since no log states it.
    ///
    /// # Errors
    /// [`Error::NoModel`]; a parameter that is missing or has another unit; [`Error::Cancelled`].
    pub fn compare(&self, progress: &Progress) -> Result<ComparisonReport, Error> {
        let file = self.required_model()?;
        let started = self.started(progress)?;
        let (model, minimum) = (&started.model, &started.minimum);
        let push_model = PushModel::of(model, &minimum.values);
        let records = started.problem.all_records();
        let traces = started.traces(&minimum.values);
        let pushes: Vec<_> = records
            .iter()
            .map(|record| identify::find_pushes(record, &push_model))
            .collect();
        progress.check()?;
        (progress.say)("looking for contradictions");
        let found = identify::contradictions(
            self.problem(),
            model,
            &minimum.values,
            &minimum.windows,
            &[],
        );
        let contradictions: Vec<String> = found.iter().map(Contradiction::sentence).collect();
        progress.check()?;
        let compared = Compared {
            model,
            values: &minimum.values,
            windows: &minimum.windows,
            traces: &traces,
            pushes: &pushes,
        };
        Ok(ComparisonReport::new(
            self.bench(),
            self.problem(),
            self.model_path().to_path_buf(),
            &compared,
            file.parameters.clone(),
            file.correlation.clone(),
            Said {
                findings: self.findings().to_vec(),
                contradictions: contradictions.clone(),
                statements: contradictions,
            },
        ))
    }
}
