//! A model compared with the measurements of a bench.

use std::path::PathBuf;

use ::data_check::Finding;
use bench_files::{Bench, Correlation, ModelFile, Parameter};
use identify::{
    Coordinate, Fit, FitProblem, FoundPush, Identification, Output, PredictedSeries, Record,
    ResidualBreakdown, ResidualKind, Window,
};
use plant::Model;
use serde::{Deserialize, Serialize};

use crate::named;
use crate::per_series::{PerSeries, SeriesName};

/// The predictions of a model for every experiment of a bench, and where the model fails: the result of
/// [`Session::identify`](crate::Session::identify) and [`Session::compare`](crate::Session::compare).
///
/// The JSON does not contain the curves; each [`ExperimentCurves`] can be serialised by itself.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ComparisonReport {
    /// The bench.
    pub bench: String,
    /// The file of the model.
    pub model: PathBuf,
    /// The effects of the model.
    pub effects: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// The correlations of the errors of the parameters; `None` if they are independent.
    pub correlation: Option<Correlation>,
    /// Root mean square of measured − simulated, SI units.
    pub rmse: PerSeries,
    /// Fit: 100·(1 − ‖y − ŷ‖/‖y − mean y‖), %.
    pub fit_percent: PerSeries,
    /// Standard deviation of each sensor's noise, SI units.
    pub sensor_noise: PerSeries,
    /// Where the model fails, the most significant place first.
    #[serde(rename = "where")]
    pub places: Vec<FailurePlace>,
    /// Pushes that no column records; they are left out of the fit.
    pub pushes: Vec<PushInLog>,
    /// Warnings about the data; the data are used nevertheless.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// Experiments and direct measurements that cannot all be right, as sentences. The statements contain them,
    /// too.
    #[serde(default)]
    pub contradictions: Vec<String>,
    /// Sentences about parameters that the logs do not determine, and about contradictions.
    pub statements: Vec<String>,
    /// Notes on the files, as sentences.
    pub notes: Vec<BenchNote>,
    /// The experiments.
    pub experiments: Vec<LoggedExperiment>,
    /// Whether torques on the body, and therefore the impulses of pushes, are known only per unit of inertia.
    pub per_unit_of_inertia: bool,
    /// Measured and simulated curves, experiment by experiment.
    #[serde(skip)]
    pub curves: Vec<ExperimentCurves>,
    /// The residuals over every coordinate, from which the places are taken.
    #[serde(skip)]
    pub breakdowns: Vec<ResidualBreakdown>,
}

/// A place where a model fails: a range of a coordinate in one series of residuals.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailurePlace {
    /// The experiment.
    pub experiment: String,
    /// Its channel.
    pub channel: String,
    /// The coordinate.
    #[serde(with = "named")]
    pub coordinate: Coordinate,
    /// Lower end of the range, in the coordinate's unit.
    pub from: f64,
    /// Upper end of the range, in the coordinate's unit.
    pub to: f64,
    /// The stretches of the log's time in which the coordinate lies in the range: first and last instant, s, in rising
    /// order. The JSON does not contain them.
    #[serde(skip)]
    pub stretches_s: Vec<[f64; 2]>,
    /// Share of the residual's squared error that lies in the range.
    pub share_of_error: f64,
    /// The residual in which it was found.
    #[serde(with = "named")]
    pub residual: ResidualKind,
    /// Whether the residual there is larger than noise explains.
    pub significant: bool,
}

/// A push on the body that no column records.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PushInLog {
    /// The experiment.
    pub experiment: String,
    /// Time of the push, s of the log.
    pub time_s: f64,
    /// Impulse on the body, N m s (or per kg m², see [`ComparisonReport::per_unit_of_inertia`]).
    pub impulse_nms: f64,
    /// Its standard error; NaN (null) if it is unknown.
    #[serde(with = "named::gap")]
    pub impulse_std_nms: f64,
}

/// A note on the files of a bench.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BenchNote {
    /// The experiment; `None` if the note concerns the whole bench.
    pub experiment: Option<String>,
    /// The note, as one sentence.
    pub note: String,
}

/// An experiment as it was read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoggedExperiment {
    /// Its name.
    pub name: String,
    /// `free-swing`, `spin-up`, `balance` or `driven`.
    pub kind: String,
    /// Number of samples that are used.
    pub samples: usize,
    /// Time from the first sample to the last, s.
    pub duration_s: f64,
    /// The channels that are compared with the model.
    pub channels: Vec<String>,
}

/// Measured and simulated curves of one experiment.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ExperimentCurves {
    /// The experiment.
    pub experiment: String,
    /// Time of the samples, s.
    pub time_s: Vec<f64>,
    /// Whether the sample is fitted: `false` around an unrecorded push.
    pub counts: Vec<bool>,
    /// The channels.
    pub channels: Vec<ChannelCurves>,
}

/// One channel of an experiment, measured and simulated; SI units.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ChannelCurves {
    /// The channel.
    #[serde(with = "named")]
    pub channel: Output,
    /// The samples; NaN (null in JSON) for a missing one.
    #[serde(with = "named::gaps")]
    pub measured: Vec<f64>,
    /// A free-running simulation of the model; for balance logs, over windows of 0.25 s, each with its own start.
    /// NaN (null) where nothing was simulated.
    #[serde(with = "named::gaps")]
    pub simulated: Vec<f64>,
    /// Standard deviation of the sensor's noise, SI unit of the channel.
    pub noise_std: f64,
    /// Root mean square of measured − simulated, SI unit of the channel.
    #[serde(with = "named::gap")]
    pub rmse: f64,
    /// Fit: 100·(1 − ‖y − ŷ‖/‖y − mean y‖), %.
    #[serde(with = "named::gap")]
    pub fit_percent: f64,
}

/// The data for a comparison.
pub(crate) struct Compared<'a> {
    /// The structure of the model.
    pub model: &'a Model,
    /// Its parameter vector.
    pub values: &'a [f64],
    /// The windows of every log, with their starts.
    pub windows: &'a [Vec<Window>],
    /// For each record and channel: the prediction compared with the measurement.
    pub traces: &'a [Vec<PredictedSeries>],
    /// The unrecorded pushes of each record.
    pub pushes: &'a [Vec<FoundPush>],
}

/// The sentences of a report, in addition to its numbers.
pub(crate) struct Said {
    pub findings: Vec<Finding>,
    pub contradictions: Vec<String>,
    pub statements: Vec<String>,
}

impl ComparisonReport {
    /// The unit of a missing torque in the residual of this channel: per kg m² if the bench does not determine the inertia
    /// on which the torque acts.
    pub fn torque_unit(&self, channel: &str) -> &'static str {
        let inertia = match channel {
            "wheel_speed" => "wheel_inertia",
            _ => "total_inertia",
        };
        let mut parameters = self.parameters.iter();
        let is_open = parameters.any(|one| one.name == inertia && one.is_per_inertia());
        if is_open { "N m per kg m2" } else { "N m" }
    }

    pub(crate) fn new(
        bench: &Bench,
        problem: &FitProblem,
        model_path: PathBuf,
        compared: &Compared,
        parameters: Vec<Parameter>,
        correlation: Option<Correlation>,
        said: Said,
    ) -> ComparisonReport {
        let records = &problem.records;
        let failure = identify::breakdown(
            records,
            compared.windows,
            compared.traces,
            compared.model,
            compared.values,
        );
        let curves: Vec<ExperimentCurves> = records
            .iter()
            .zip(compared.traces)
            .map(|(record, traces)| ExperimentCurves::new(record, traces))
            .collect();
        let per_series = |value: fn(&ChannelCurves) -> f64| per_series(&curves, value);
        ComparisonReport {
            bench: bench.name.clone(),
            model: model_path,
            effects: effect_names(compared.model),
            parameters,
            correlation,
            rmse: per_series(|channel| channel.rmse),
            fit_percent: per_series(|channel| channel.fit_percent),
            sensor_noise: per_series(|channel| channel.noise_std),
            places: failure.regions.iter().map(FailurePlace::of).collect(),
            pushes: records
                .iter()
                .zip(compared.pushes)
                .flat_map(|(record, pushes)| {
                    pushes.iter().map(|push| PushInLog {
                        experiment: record.name.clone(),
                        time_s: push.time_s,
                        impulse_nms: push.impulse_nms,
                        impulse_std_nms: push.impulse_std_nms,
                    })
                })
                .collect(),
            findings: said.findings,
            contradictions: said.contradictions,
            statements: said.statements,
            notes: notes(bench),
            experiments: records.iter().map(LoggedExperiment::of).collect(),
            per_unit_of_inertia: !problem.body_scale_known,
            curves,
            breakdowns: failure.breakdowns,
        }
    }

    /// The report on an identification.
    pub(crate) fn of_identification(
        bench: &Bench,
        problem: &FitProblem,
        model_path: PathBuf,
        found: &Identification,
        findings: Vec<Finding>,
    ) -> ComparisonReport {
        let fit = &found.fit;
        ComparisonReport::new(
            bench,
            problem,
            model_path,
            &Compared {
                model: &fit.model,
                values: &fit.values,
                windows: &fit.minimum.windows,
                traces: &found.traces,
                pushes: &found.pushes,
            },
            parameters_of(problem, fit),
            correlation_of(fit),
            Said {
                findings,
                contradictions: found.contradictions.clone(),
                statements: found.statements.clone(),
            },
        )
    }

    /// Number of samples of all experiments.
    pub fn samples(&self) -> usize {
        self.experiments.iter().map(|one| one.samples).sum()
    }

    /// The parameter with this name.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.name == name)
    }
}

impl FailurePlace {
    fn of(region: &identify::FailureRegion) -> FailurePlace {
        FailurePlace {
            experiment: region.experiment.clone(),
            channel: region.channel.to_owned(),
            coordinate: region.coordinate,
            from: region.from,
            to: region.to,
            stretches_s: region.stretches_s.clone(),
            share_of_error: region.share_of_error,
            residual: region.quantity,
            significant: region.is_significant,
        }
    }
}

impl LoggedExperiment {
    pub(crate) fn of(record: &Record) -> LoggedExperiment {
        let span = (record.time_s.first(), record.time_s.last());
        LoggedExperiment {
            name: record.name.clone(),
            kind: record.kind.name().to_owned(),
            samples: record.len(),
            duration_s: match span {
                (Some(first), Some(last)) => last - first,
                _ => 0.0,
            },
            channels: record
                .channels
                .iter()
                .map(|channel| channel.output.name().to_owned())
                .collect(),
        }
    }
}

impl ExperimentCurves {
    pub(crate) fn new(record: &Record, traces: &[PredictedSeries]) -> ExperimentCurves {
        ExperimentCurves {
            experiment: record.name.clone(),
            time_s: record.time_s.clone(),
            counts: record.weight.iter().map(|weight| *weight > 0.0).collect(),
            channels: record
                .channels
                .iter()
                .zip(traces)
                .map(|(channel, trace)| ChannelCurves {
                    channel: trace.output,
                    measured: channel.samples.clone(),
                    simulated: trace.predicted.clone(),
                    noise_std: channel.noise_std,
                    rmse: trace.rmse,
                    fit_percent: trace.fit_percent,
                })
                .collect(),
        }
    }

    /// The curves of this channel.
    pub fn channel(&self, channel: Output) -> Option<&ChannelCurves> {
        self.channels
            .iter()
            .find(|curves| curves.channel == channel)
    }
}

/// One number for each channel of each experiment.
pub(crate) fn per_series(
    curves: &[ExperimentCurves],
    value: impl Fn(&ChannelCurves) -> f64,
) -> PerSeries {
    let all = curves.iter().flat_map(|experiment| {
        let channels = experiment.channels.iter();
        channels.map(|channel| {
            let name = SeriesName {
                experiment: experiment.experiment.clone(),
                channel: channel.channel,
            };
            (name, channel)
        })
    });
    all.map(|(name, channel)| (name, value(channel))).collect()
}

pub(crate) fn effect_names(model: &Model) -> Vec<String> {
    let effects = model.effects().iter();
    effects.map(|effect| effect.name().to_owned()).collect()
}

/// The notes from reading the files.
pub(crate) fn notes(bench: &Bench) -> Vec<BenchNote> {
    let general = bench.notes.iter().map(|note| BenchNote {
        experiment: None,
        note: note.clone(),
    });
    let special = bench.experiments.iter().flat_map(|experiment| {
        experiment.report.notes.iter().map(|note| BenchNote {
            experiment: Some(experiment.name.clone()),
            note: note.to_string(),
        })
    });
    general.chain(special).collect()
}

/// The parameters of a fit for model.toml: the given ones and the identified ones. Parameters that no log depends
/// on are left out.
pub(crate) fn parameters_of(problem: &FitProblem, fit: &Fit) -> Vec<Parameter> {
    let infos = fit.model.parameters();
    // A negative inertia is a contradiction, which the statements report, and not a parameter.
    let derived = identify::body_inertia(problem, fit).filter(|(value, _)| *value > 0.0);
    let derived = derived.map(|(value, std)| Parameter {
        name: "body_inertia".to_owned(),
        value,
        std,
        unit: "kg m2".to_owned(),
        source: "total_inertia less wheel, masses, lengths".to_owned(),
    });
    (0..infos.len())
        .filter_map(|position| {
            let free = fit.unknowns.free.iter().position(|&at| at == position);
            let given = problem.known.get(position).is_some_and(Option::is_some);
            let unit = problem.unit(&fit.model, position);
            let source = match free {
                Some(unknown) => problem
                    .records
                    .iter()
                    .filter(|record| {
                        identify::relevant(record, &fit.model, &fit.unknowns).contains(&unknown)
                    })
                    .map(|record| record.name.as_str())
                    .collect::<Vec<_>>()
                    .join(", "),
                None if given && unit == "kg m2 per kg m2" => {
                    "set to 1: torques are per unit of inertia".to_owned()
                }
                None if given => "[known] in bench.toml".to_owned(),
                None if infos[position].is_whole => "chosen: a whole number".to_owned(),
                None => return None,
            };
            Some(Parameter {
                name: infos[position].name.to_owned(),
                value: fit.values[position],
                std: fit.std(position),
                unit,
                source,
            })
        })
        .chain(derived)
        .collect()
}

/// The correlations of a fit for model.toml. Parameters that were given or derived have none.
pub(crate) fn correlation_of(fit: &Fit) -> Option<Correlation> {
    let infos = fit.model.parameters();
    let (positions, matrix) = fit.correlation()?;
    Some(Correlation {
        parameters: positions
            .iter()
            .map(|&position| infos[position].name.to_owned())
            .collect(),
        matrix: matrix
            .row_iter()
            .map(|row| row.iter().copied().collect())
            .collect(),
    })
}

/// A model file with another model in it.
pub(crate) fn with_model(
    mut file: ModelFile,
    model: &Model,
    parameters: Vec<Parameter>,
    correlation: Option<Correlation>,
) -> ModelFile {
    file.replace_model_parameters(parameters, correlation);
    file.effects = model.effects().to_vec();
    // A tie stays open as long as the model has the effects that it concerns.
    file.tie = file
        .tie
        .filter(|tie| tie.provisional.iter().all(|effect| model.has(*effect)));
    file
}
