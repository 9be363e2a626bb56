//! The experiments of a bench, simulated with other values of the model's parameters.

use identify::{Effort, FitProblem, Minimum, PredictedSeries, Progress, Record, Window};
use parallel::parallel_map;
use plant::Model;

use crate::comparison::ExperimentCurves;
use crate::error::Error;
use crate::session::Session;
use crate::swing_decay::{SwingDecay, swing_decays};

impl Session {
    /// Prepares the experiments for sliders: the starts of all logs are fitted once to the present model.
    /// [`Predictor::curves`] then simulates the experiments with other parameter values.
    ///
    /// # Errors
    /// [`Error::NoModel`]; a parameter that is missing or has another unit; [`Error::Cancelled`].
    pub fn predictor(&self, progress: &Progress) -> Result<Predictor, Error> {
        self.started(progress).map(Predictor)
    }

    /// The starts of all logs, fitted to the present model.
    pub(crate) fn started(&self, progress: &Progress) -> Result<Started, Error> {
        let file = self.required_model()?;
        let values = self.parameter_values(file)?;
        let model = file.model();
        let problem = self.problem().suited_to(&model).into_owned();
        let records = problem.all_records();
        progress.check()?;
        (progress.say)("simulating all experiments");
        let windows = records
            .iter()
            .map(|record| identify::final_windows(record, &values))
            .collect();
        let effort = Effort::FULL.until(progress.cancelled);
        let minimum = identify::refit(&records, &model, values, windows, &[], effort);
        progress.check()?;
        Ok(Started {
            problem,
            model,
            minimum,
        })
    }
}

/// A model with the fitted starts of all logs.
#[derive(Clone, Debug)]
pub(crate) struct Started {
    /// The bench, with the windows that suit the model.
    pub(crate) problem: FitProblem,
    pub(crate) model: Model,
    pub(crate) minimum: Minimum,
}

impl Started {
    pub(crate) fn traces(&self, values: &[f64]) -> Vec<Vec<PredictedSeries>> {
        let traces = |(record, windows): (&Record, &Vec<Window>)| {
            identify::traces(record, windows, &self.model, values)
        };
        parallel_map(
            self.problem.records.iter().zip(&self.minimum.windows),
            traces,
        )
    }
}

/// The experiments of a bench, ready to be simulated with other values of the model's parameters.
#[derive(Clone, Debug)]
pub struct Predictor(Started);

impl Predictor {
    /// The parameters of the model by name, with their values in the model; SI units, or per
    /// unit of inertia if the bench does not determine more.
    pub fn parameters(&self) -> Vec<(String, f64)> {
        let infos = self.0.model.parameters();
        let values = &self.0.minimum.values;
        infos
            .iter()
            .zip(values)
            .map(|(info, value)| (info.name.to_owned(), *value))
            .collect()
    }

    /// The decay of the free swings, measured and according to the model.
    pub fn decays(&self) -> Vec<SwingDecay> {
        let traces = self.0.traces(&self.0.minimum.values);
        swing_decays(&self.0.problem.records, &traces)
    }

    /// Simulates every experiment from its start, with these parameters changed. Without changes, the curves are those
    /// of [`Session::compare`].
    ///
    /// # Errors
    /// [`Error::UnknownParameter`].
    pub fn curves(&self, changes: &[(&str, f64)]) -> Result<Vec<ExperimentCurves>, Error> {
        let values = with_changes(&self.0.model, &self.0.minimum.values, changes)?;
        let traces = self.0.traces(&values);
        let records = self.0.problem.records.iter();
        Ok(records
            .zip(&traces)
            .map(|(record, traces)| ExperimentCurves::new(record, traces))
            .collect())
    }

    /// Simulates the experiment at this place in the list, with these parameters changed; `None` if there is no such
    /// experiment. This is fast enough for a curve that follows a slider.
    ///
    /// # Errors
    /// [`Error::UnknownParameter`].
    pub fn curves_of(
        &self,
        experiment: usize,
        changes: &[(&str, f64)],
    ) -> Result<Option<ExperimentCurves>, Error> {
        let started = &self.0;
        let values = with_changes(&started.model, &started.minimum.values, changes)?;
        let record = started.problem.records.get(experiment);
        let windows = started.minimum.windows.get(experiment);
        Ok(record.zip(windows).map(|(record, windows)| {
            let traces = identify::traces(record, windows, &started.model, &values);
            ExperimentCurves::new(record, &traces)
        }))
    }
}

/// The parameter vector of a model with some parameters changed by name.
pub(crate) fn with_changes(
    model: &Model,
    values: &[f64],
    changes: &[(&str, f64)],
) -> Result<Vec<f64>, Error> {
    let mut values = values.to_vec();
    for (name, value) in changes {
        let position = model.position_of(name).ok_or_else(|| {
            let infos = model.parameters();
            Error::UnknownParameter {
                name: (*name).to_owned(),
                present: infos.iter().map(|info| info.name.to_owned()).collect(),
            }
        })?;
        values[position] = *value;
    }
    Ok(values)
}
