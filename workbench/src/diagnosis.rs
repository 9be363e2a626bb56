//! Which physical effects a model lacks.

use ::data_check::Finding;
use bench_files::{Correlation, ModelFile, Parameter};
use diagnose::{Diagnosis, Options, Step, Suspect, Verdict};
use identify::{Fit, Identification, PredictedSeries, Progress, Record};
use plant::{EffectId, Model};
use serde::{Deserialize, Serialize};

use crate::comparison::{
    BenchNote, ComparisonReport, FailurePlace, PushInLog, correlation_of, effect_names,
    parameters_of, with_model,
};
use crate::design_change::DesignChange;
use crate::error::Error;
use crate::named;
use crate::numbers::significant;
use crate::per_series::{PerSeries, SeriesName};
use crate::session::Session;
use crate::swing_decay::{SwingDecay, swing_decays};
use crate::words;

/// The verdict on a model, and what it rests on: the result of
/// [`Session::diagnose`](crate::Session::diagnose).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosisReport {
    /// The bench.
    pub bench: String,
    /// Whether something is missing, and whether it could be named.
    #[serde(with = "named")]
    pub verdict: Verdict,
    /// The verdict as a sentence or two.
    pub sentence: String,
    /// The model as it was, then each effect that was added, in order.
    pub steps: Vec<DiagnosisStep>,
    /// The effects that could be missing, the most probable first.
    pub suspects: Vec<SuspectEffect>,
    /// The sets of effects that tie; empty where none do.
    pub ambiguous_between: Vec<Vec<String>>,
    /// The experiment that would settle what is open; empty where nothing is.
    pub next_experiment: String,
    /// Where the model of the last step fails, the plainest place first.
    #[serde(rename = "where")]
    pub places: Vec<FailurePlace>,
    /// The largest structured remainder of the last step, in units of its sensor's noise.
    #[serde(with = "named::gap")]
    pub remainder: f64,
    /// Standard deviation of each sensor's noise, SI units.
    pub sensor_noise: PerSeries,
    /// Pushes that no column records.
    pub pushes: Vec<PushInLog>,
    /// How each free swing dies out, as measured.
    pub decay: Vec<SwingDecay>,
    /// What is wrong with the data, but does not keep them from being used.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// What the logs leave open, or contradict; sentences.
    pub statements: Vec<String>,
    /// What is to be known about the files; sentences.
    pub notes: Vec<BenchNote>,
    /// The model of the last step beside the measurements, with its curves. It serialises by itself.
    #[serde(skip)]
    pub last: ComparisonReport,
}

/// The model as it was, or after one effect more; refitted to all experiments.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosisStep {
    /// The effect that was added; `None` for the model as it was.
    pub effect: Option<String>,
    /// All effects of the model.
    pub effects: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// How their errors hang together; `None`: they are independent.
    pub correlation: Option<Correlation>,
    /// Root mean square errors, SI units.
    pub rmse: PerSeries,
    /// The fit, %.
    pub fit_percent: PerSeries,
    /// Mean fit of experiments that the parameters have not seen, %; NaN (null) where there is none.
    #[serde(with = "named::gap")]
    pub validation_fit_percent: f64,
    /// Root mean square errors of experiments that the parameters have not seen, SI units.
    pub validation_rmse: PerSeries,
}

/// An effect that could be missing.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SuspectEffect {
    /// The effect.
    pub effect: String,
    /// Probability that the model lacks it.
    pub probability: f64,
    /// Mean fit of experiments that the fit has not seen, %; NaN (null) where there is none.
    #[serde(with = "named::gap")]
    pub validation_fit_percent: f64,
    /// The effect's own parameters in the best model that has it.
    pub parameters: Vec<Parameter>,
    /// Root mean square errors with that model, SI units.
    pub rmse: PerSeries,
    /// One sentence: what to look for, and what the fit gains by it.
    pub fingerprint: String,
}

/// What [`Session::apply`](crate::Session::apply) has done.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AppliedDiagnosis {
    /// The effects that were added.
    pub added: Vec<String>,
    /// What they change in the controller; `None` where nothing was added, or no controller can be had.
    pub design_change: Option<DesignChange>,
    /// Why no controller can be had, where that is so.
    pub no_controller: Option<String>,
}

impl Session {
    /// Which physical effects the model lacks. Its parameters are refitted first: wrong numbers are
    /// not a missing effect. The session's model stays as it is; see [`Session::apply`].
    ///
    /// # Errors
    /// Those of [`Session::identify`]; [`Error::Cancelled`] soon after the work was called off.
    pub fn diagnose(&self, progress: &Progress) -> Result<DiagnosisReport, Error> {
        let model = self.model().map_or_else(Model::base, ModelFile::model);
        let identified = self.fit(&model, progress)?;
        let fit = &identified.fit;
        let options = Options::default();
        let minimum = fit.minimum.clone();
        let found =
            diagnose::diagnose_with(self.problem(), &fit.model, minimum, &options, progress)?;
        let Some(step) = found.last() else {
            return Err(Error::NoStep {
                bench: self.place(),
            });
        };
        (progress.say)("locating what remains");
        let last_fit = if found.steps.len() == 1 {
            identified.clone()
        } else if let Some(known) = identify::describe(self.problem(), &step.fit) {
            known
        } else {
            // The diagnosis has read the logs differently: without pushes that only it found.
            let start = (step.fit.values.clone(), step.fit.minimum.windows.clone());
            identify::identify(self.problem(), &step.fit.model, Some(start)).map_err(|source| {
                Error::Identify {
                    bench: self.place(),
                    source,
                }
            })?
        };
        progress.check()?;
        let last = self.comparison_of(&last_fit);
        progress.check()?;
        Ok(DiagnosisReport::new(self, &found, &last_fit, last))
    }

    /// Makes the last step of a diagnosis the session's model, and says what its effects change in
    /// the controller.
    pub fn apply(&mut self, report: &DiagnosisReport) -> AppliedDiagnosis {
        let before = report.steps.first().map(|step| self.model_of(step));
        let added: Vec<String> = report
            .steps
            .iter()
            .filter_map(|step| step.effect.clone())
            .collect();
        if let Some(step) = report.steps.last() {
            self.set_model(self.model_of(step));
        }
        let (mut design_change, mut no_controller) = (None, None);
        if let (false, Some(before), Some(after)) = (added.is_empty(), before, self.model()) {
            match DesignChange::between(before, after.clone()) {
                Ok(change) => design_change = Some(change),
                Err(error) => no_controller = Some(error.to_string()),
            }
        }
        AppliedDiagnosis {
            added,
            design_change,
            no_controller,
        }
    }

    /// Makes the model that the diagnosis began with, refitted, the session's model.
    pub fn keep_first_step(&mut self, report: &DiagnosisReport) {
        if let Some(step) = report.steps.first() {
            self.set_model(self.model_of(step));
        }
    }

    /// The session's model file with the model of a step in it.
    fn model_of(&self, step: &DiagnosisStep) -> ModelFile {
        let effects = step.effects.iter();
        let effects: Vec<EffectId> = effects
            .filter_map(|name| EffectId::from_name(name))
            .collect();
        with_model(
            self.file_or_new(),
            &Model::with_effects(&effects),
            step.parameters.clone(),
            step.correlation.clone(),
        )
    }
}

impl DiagnosisReport {
    fn new(
        session: &Session,
        found: &Diagnosis,
        last_fit: &Identification,
        last: ComparisonReport,
    ) -> DiagnosisReport {
        let records = &session.problem().records;
        let parameters = |fit: &Fit| parameters_of(session.problem(), fit);
        DiagnosisReport {
            bench: session.bench().name.clone(),
            verdict: found.verdict,
            sentence: sentence(found, &last),
            steps: found
                .steps
                .iter()
                .map(|step| DiagnosisStep {
                    effect: step.effect.map(|effect| effect.name().to_owned()),
                    effects: effect_names(&step.fit.model),
                    parameters: parameters(&step.fit),
                    correlation: correlation_of(&step.fit),
                    rmse: per_series(records, step.candidate.rmse()),
                    fit_percent: per_series(
                        records,
                        step.candidate.traces.iter().flatten().map(fit_percent),
                    ),
                    validation_fit_percent: step.validation_fit_percent,
                    validation_rmse: held_out(step),
                })
                .collect(),
            suspects: found
                .suspects
                .iter()
                .map(|suspect| SuspectEffect {
                    effect: suspect.effect.name().to_owned(),
                    probability: suspect.probability,
                    validation_fit_percent: suspect.validation_fit_percent,
                    parameters: own_parameters(parameters(&suspect.fit), suspect),
                    rmse: per_series(records, suspect.rmse.iter().copied()),
                    fingerprint: suspect.fingerprint.clone(),
                })
                .collect(),
            ambiguous_between: found
                .ambiguous_between
                .iter()
                .map(|set| set.iter().map(|effect| effect.name().to_owned()).collect())
                .collect(),
            next_experiment: found.next_experiment.clone(),
            places: last.places.clone(),
            remainder: found.remainder,
            sensor_noise: last.sensor_noise.clone(),
            pushes: last.pushes.clone(),
            decay: swing_decays(records, &last_fit.traces),
            findings: last.findings.clone(),
            statements: last.statements.clone(),
            notes: last.notes.clone(),
            last,
        }
    }

    /// The suspects that are more probable than not.
    pub fn likely_suspects(&self) -> impl Iterator<Item = &SuspectEffect> {
        self.suspects
            .iter()
            .filter(|suspect| suspect.probability > 0.5)
    }
}

impl DiagnosisStep {
    /// "as it was", or "+ " and the effect.
    pub fn name(&self) -> String {
        match &self.effect {
            None => "as it was".to_owned(),
            Some(effect) => format!("+ {effect}"),
        }
    }
}

fn fit_percent(trace: &PredictedSeries) -> f64 {
    trace.fit_percent
}

/// Numbers in the order of the records and their channels, with the names of the series.
fn per_series(records: &[Record], values: impl IntoIterator<Item = f64>) -> PerSeries {
    let names = records.iter().flat_map(|record| {
        record.channels.iter().map(|channel| SeriesName {
            experiment: record.name.clone(),
            channel: channel.output,
        })
    });
    names.zip(values).collect()
}

/// The root mean square errors of experiments that the step's parameters have not seen.
fn held_out(step: &Step) -> PerSeries {
    let series = step.held_out.iter();
    series
        .map(|series| {
            let name = SeriesName {
                experiment: series.experiment.clone(),
                channel: series.output,
            };
            (name, series.rmse)
        })
        .collect()
}

/// The parameters that are the suspect's own.
fn own_parameters(mut parameters: Vec<Parameter>, suspect: &Suspect) -> Vec<Parameter> {
    let own = suspect.effect.info().parameters;
    parameters.retain(|parameter| own.iter().any(|info| info.name == parameter.name));
    parameters
}

/// The verdict as a sentence or two; `last` is the model of the last step.
fn sentence(found: &Diagnosis, last: &ComparisonReport) -> String {
    let added: Vec<&str> = found
        .steps
        .iter()
        .filter_map(|step| Some(step.effect?.name()))
        .collect();
    let added = added.join(" and ");
    let noise = if found.remainder > 0.0 {
        format!(
            "noise, with structure of at most {} of a sensor's noise",
            significant(found.remainder, 2)
        )
    } else {
        "nothing but noise".to_owned()
    };
    match found.verdict {
        Verdict::NothingMissing => {
            format!("Nothing is missing: what the model leaves in the measurements is {noise}.")
        }
        Verdict::Explained => format!(
            "Explained: the model lacks {added}. What remains in the measurements is then \
             {noise}."
        ),
        Verdict::Ambiguous => {
            let sets: Vec<String> = found
                .ambiguous_between
                .iter()
                .map(|set| words::set(set.iter().map(|effect| effect.name())))
                .collect();
            let beside = match added.as_str() {
                "" => String::new(),
                added => format!(" What all of them share was added: {added}."),
            };
            format!(
                "Ambiguous: something is missing, but these logs cannot tell {}.{beside}",
                sets.join(" from ")
            )
        }
        Verdict::Unexplained => {
            let missing = match added.as_str() {
                "" => "something".to_owned(),
                added => format!("the model lacks {added}, and beyond that something"),
            };
            format!(
                "Unexplained: {missing} remains{}: {} times the noise of the sensor. No effect \
                 in the library accounts for it.",
                last.places.first().map_or(String::new(), remains_at),
                significant(found.remainder, 2)
            )
        }
    }
}

/// " at about 0.15 rad (angle 0.1 to 0.2 rad in free swing 52 deg)".
fn remains_at(place: &FailurePlace) -> String {
    format!(
        " at about {} {} ({} in {})",
        significant(place.middle(), 2),
        place.coordinate.unit(),
        words::place(place),
        place.experiment
    )
}
