//! The diagnosis: which physical effects a model lacks.

use ::data_check::Finding;
use bench_files::{Correlation, ModelFile, Parameter, Tie};
use diagnose::{Diagnosis, Options, Recipe, Step, Suspect, Unseen, Verdict};
use identify::{Contradiction, Fit, Identification, PredictedSeries, Progress, Record};
use plant::{EffectId, Model};
use serde::{Deserialize, Serialize};

use crate::comparison::{
    BenchNote, ComparisonReport, FailurePlace, PushInLog, correlation_of, effect_names,
    parameters_of, with_model,
};
use crate::control_design::ControlDesign;
use crate::design_change::DesignChange;
use crate::error::Error;
use crate::learned::MissingTorque;
use crate::named;
use crate::numbers::significant;
use crate::per_series::{PerSeries, SeriesName};
use crate::remains::RemainsReport;
use crate::session::Session;
use crate::swing_decay::{SwingDecay, swing_decays};
use crate::words;

/// The verdict on a model, with the evidence for it: the result of
/// [`Session::diagnose`](crate::Session::diagnose).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosisReport {
    /// The bench.
    pub bench: String,
    /// The verdict: whether an effect is missing, and whether it could be named.
    #[serde(with = "named")]
    pub verdict: Verdict,
    /// The verdict as a sentence or two.
    pub sentence: String,
    /// The diagnosed model, then one step for each change, in order.
    pub steps: Vec<DiagnosisStep>,
    /// The model of the last step.
    #[serde(rename = "final")]
    pub last_model: FinalModel,
    /// The provisional effects among them: an experiment must decide about them.
    pub provisional: Vec<String>,
    /// Which data were held out from the fit for the held-out predictions.
    pub held_out_by: HeldOutBy,
    /// The effects that could be missing, the most probable first.
    pub suspects: Vec<SuspectEffect>,
    /// The sets of effects that tie; empty if none do.
    pub ambiguous_between: Vec<Vec<String>>,
    /// The experiment that would settle an open question; empty if no question is open.
    pub next_experiment: String,
    /// The torque that is missing, over the coordinate in which it stands best; `None` where nothing is unexplained,
    /// or no curve predicts anything of it.
    #[serde(default)]
    pub missing_torque: Option<MissingTorque>,
    /// The last model with the learned curves that the model had before; `None` where it had none, or they are no
    /// longer needed. A curve explains nothing: the verdict is that on the model without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_learned: Option<DiagnosisStep>,
    /// The same step by step, with what each explanation would show; `None` where no experiment
    /// tells them apart. Not part of the JSON, which has the sentence.
    #[serde(skip)]
    pub recipe: Option<Recipe>,
    /// How large what no effect explains is, and whether it matters; `None` where nothing is unexplained.
    pub remains: Option<RemainsReport>,
    /// Where the model of the last step fails, the most significant place first.
    #[serde(rename = "where")]
    pub places: Vec<FailurePlace>,
    /// The largest structured remainder of the last step, in units of its sensor's noise.
    #[serde(with = "named::gap")]
    pub remainder: f64,
    /// Standard deviation of each sensor's noise, SI units.
    pub sensor_noise: PerSeries,
    /// Pushes that no column records.
    pub pushes: Vec<PushInLog>,
    /// The measured decay of each free swing.
    pub decay: Vec<SwingDecay>,
    /// Warnings about the data; the data are used nevertheless.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// What the logs do not determine, and contradictions, as sentences.
    pub statements: Vec<String>,
    /// Notes on the files, as sentences.
    pub notes: Vec<BenchNote>,
    /// Whether the diagnosed model predicts no better than the means of the series. Its numbers are then not usable.
    pub has_failed_at_first: bool,
    /// The model of the last step compared with the measurements, with its curves. It can be serialised by itself.
    #[serde(skip)]
    pub last: ComparisonReport,
    /// The structure of the model of [`DiagnosisReport::with_learned`].
    #[serde(skip)]
    pub(crate) learned_model: Option<Model>,
}

/// A step of the diagnosis: the diagnosed model, or the model after one more effect, refitted to all experiments.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct DiagnosisStep {
    /// The effect that was added; `None` for the diagnosed model and for a step that only removes effects.
    pub effect: Option<String>,
    /// The effects of the previous model that the step removed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub replaces: Vec<String>,
    /// Whether the step is provisional: an experiment must decide between explanations that tie.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub provisional: bool,
    /// Whether the previous step predicts the held-out data plainly better.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub held_out_worse: bool,
    /// All effects of the model.
    pub effects: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// The correlations of their errors; `None` if they are independent.
    pub correlation: Option<Correlation>,
    /// Root mean square errors, SI units.
    pub rmse: PerSeries,
    /// The fit, %.
    pub fit_percent: PerSeries,
    /// Mean fit on held-out data, %; NaN (null) if there are none.
    #[serde(with = "named::gap")]
    pub validation_fit_percent: f64,
    /// Root mean square errors on held-out data, SI units.
    pub validation_rmse: PerSeries,
}

/// The model of the last step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FinalModel {
    /// All of its effects.
    pub effects: Vec<String>,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Root mean square errors, SI units.
    pub rmse: PerSeries,
}

/// Which data were held out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HeldOutBy {
    /// Whole experiments, each predicted by the others.
    Experiments,
    /// The second half of every log, predicted by the first halves.
    SecondHalves,
}

/// An effect that could be missing.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SuspectEffect {
    /// The effect.
    pub effect: String,
    /// Probability that the model lacks it.
    pub probability: f64,
    /// All effects of the best model that has it. All other fields belong to that model.
    pub model: Vec<String>,
    /// For every series, the share of the error that this effect removes: 1 − with/without, where
    /// "without" is the same model, fitted again without the effect.
    pub takes_away: PerSeries,
    /// Mean fit on held-out data, %; NaN (null) if there are none.
    #[serde(with = "named::gap")]
    pub validation_fit_percent: f64,
    /// The effect's own parameters in that model.
    pub parameters: Vec<Parameter>,
    /// Root mean square errors with that model, SI units.
    pub rmse: PerSeries,
    /// One sentence: what the effect looks like in the data, and how far the error falls with it.
    pub fingerprint: String,
}

/// The changes that [`Session::apply`](crate::Session::apply) has made.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct AppliedDiagnosis {
    /// The effects that were added.
    pub added: Vec<String>,
    /// The provisional effects among them.
    pub provisional: Vec<String>,
    /// The effects that were removed.
    pub taken_out: Vec<String>,
    /// The changes in the controller; `None` if nothing was added, or no controller could be designed.
    pub design_change: Option<DesignChange>,
    /// The reason why no controller could be designed, if so.
    pub no_controller: Option<String>,
}

impl Session {
    /// Finds the physical effects that the model lacks. Its parameters are refitted first, since wrong parameter values
    /// are not a missing effect. Provisional effects of the model do not count as present, so that a tie is found
    /// again. The session's model is not changed; see [`Session::apply`].
    ///
    /// # Errors
    /// Those of [`Session::identify`], if the last model fails and not only the first;
    /// [`Error::Cancelled`] soon after the work was cancelled.
    pub fn diagnose(&self, progress: &Progress) -> Result<DiagnosisReport, Error> {
        let whole = self
            .model()
            .map_or_else(Model::base, ModelFile::certain_model);
        // A learned curve explains nothing: what it follows is still to be explained.
        let model = whole.without_learned();
        let identified = self.fit_however(&model, progress)?;
        let fit = &identified.fit;
        // Users' effects are suspects like those of the library.
        let suspects: Vec<EffectId> = EffectId::ALL
            .iter()
            .copied()
            .chain(self.bench().own_effects.iter().map(|own| own.effect))
            .collect();
        let options = Options {
            suspects: &suspects,
            ..Options::default()
        };
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
            // The diagnosis may have read the logs differently, without pushes that only it found.
            let start = (step.fit.values.clone(), step.fit.minimum.windows.clone());
            identify::fit_until(self.problem(), &step.fit.model, Some(start), progress)
                .map_err(|source| self.not_identified(source))?
        };
        progress.check()?;
        self.refuse_failed(&last_fit)?;
        let last = self.comparison_of(&last_fit);
        progress.check()?;
        let mut report = DiagnosisReport::new(self, &found, &last_fit, last);
        if found.verdict == Verdict::Unexplained {
            let file = report.steps.last().map(|step| self.model_of(step));
            let design = file.and_then(|file| ControlDesign::of(file).ok());
            let remains = RemainsReport::new(&found.remains, self.problem(), design.as_ref());
            report.remains = Some(remains);
            if found.contradictions.is_empty() {
                (progress.say)(
                    "looking for the coordinate over which the missing torque stands best",
                );
                report.missing_torque = self.missing_torque(&last_fit);
            }
        }
        if let Some(missing) = &report.missing_torque {
            report.sentence = format!("{} {}", report.sentence, missing.sentence());
        }
        if whole != model {
            self.with_learned(&mut report, &last_fit, progress)?;
        }
        report.has_failed_at_first = self.refuse_failed(&identified).is_err();
        Ok(report)
    }

    /// Makes the last step of a diagnosis the session's model, and returns the changes in
    /// the controller. If explanations tie, the model records which of its effects are provisional and which
    /// could replace them. Effects that were certain before stay certain.
    pub fn apply(&mut self, report: &DiagnosisReport) -> AppliedDiagnosis {
        let had_learned = self.learned_coordinates();
        let before = report.steps.first().map(|step| self.model_of(step));
        let mut applied = AppliedDiagnosis {
            added: report.added(),
            provisional: vec![],
            taken_out: report.taken_out(),
            design_change: None,
            no_controller: None,
        };
        let last = report.with_learned.as_ref().or(report.steps.last());
        if let (Some(before), Some(step)) = (&before, last) {
            let mut file = self.model_of(step);
            if let Some(model) = &report.learned_model {
                // The curves have new knots.
                file.effects = model.effects().to_vec();
            }
            file.tie = report.tie(self).filter(|tie| {
                let was_certain = before.certain_model();
                tie.provisional
                    .iter()
                    .any(|effect| !was_certain.has(*effect))
            });
            let provisional = file.tie.iter().flat_map(|tie| &tie.provisional);
            applied.provisional = provisional.map(|one| one.name().to_owned()).collect();
            self.set_model(file);
        }
        if report.with_learned.is_none() {
            let gone = had_learned.iter().map(|one| one.effect_name().to_owned());
            applied.taken_out.extend(gone);
        }
        let is_changed = report.steps.len() > 1;
        if let (true, Some(before), Some(after)) = (is_changed, before, self.model()) {
            match DesignChange::between(before, after.clone()) {
                Ok(change) => applied.design_change = Some(change),
                Err(error) => applied.no_controller = Some(error.to_string()),
            }
        }
        applied
    }

    /// Makes the first model of the diagnosis, refitted, the session's model; unless its fit has failed.
    pub fn keep_first_step(&mut self, report: &DiagnosisReport) {
        if let (Some(step), false) = (report.steps.first(), report.has_failed_at_first) {
            self.set_model(self.model_of(step));
        }
    }

    /// The session's model file with the model of a step.
    fn model_of(&self, step: &DiagnosisStep) -> ModelFile {
        let effects = step.effects.iter();
        let effects: Vec<EffectId> = effects.filter_map(|name| self.effect_named(name)).collect();
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
        let final_step = found.last();
        DiagnosisReport {
            bench: session.bench().name.clone(),
            verdict: found.verdict,
            sentence: sentence(found, &last),
            steps: found
                .steps
                .iter()
                .map(|step| DiagnosisStep {
                    effect: step.effect.map(|effect| effect.name().to_owned()),
                    replaces: names_of(&step.replaces),
                    provisional: step.is_provisional,
                    held_out_worse: step.is_held_out_worse,
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
            last_model: FinalModel {
                effects: final_step.map_or(vec![], |step| effect_names(&step.fit.model)),
                parameters: final_step.map_or(vec![], |step| parameters(&step.fit)),
                rmse: per_series(
                    records,
                    final_step.map_or(vec![], |step| step.candidate.rmse()),
                ),
            },
            provisional: provisional_effects(found),
            held_out_by: match final_step.map(|step| step.unseen) {
                Some(Unseen::SecondHalves) => HeldOutBy::SecondHalves,
                Some(Unseen::Experiments) | None => HeldOutBy::Experiments,
            },
            suspects: found
                .suspects
                .iter()
                .map(|suspect| SuspectEffect {
                    effect: suspect.effect.name().to_owned(),
                    probability: suspect.probability,
                    model: effect_names(&suspect.model),
                    takes_away: per_series(records, suspect.takes_away.iter().copied()),
                    validation_fit_percent: suspect.validation_fit_percent,
                    parameters: own_parameters(parameters(&suspect.fit), suspect),
                    rmse: per_series(records, suspect.rmse.iter().copied()),
                    fingerprint: suspect.fingerprint.clone(),
                })
                .collect(),
            ambiguous_between: found
                .ambiguous_between
                .iter()
                .map(|set| names_of(set))
                .collect(),
            missing_torque: None,
            with_learned: None,
            learned_model: None,
            remains: None,
            next_experiment: found.next_experiment.clone(),
            recipe: found.recipe.clone(),
            places: last.places.clone(),
            remainder: found.remainder,
            sensor_noise: last.sensor_noise.clone(),
            pushes: last.pushes.clone(),
            decay: swing_decays(records, &last_fit.traces),
            findings: last.findings.clone(),
            statements: last.statements.clone(),
            notes: last.notes.clone(),
            has_failed_at_first: false,
            last,
        }
    }

    /// The effects that the steps add, in order; both a refinement and the effect that it replaces.
    pub fn added(&self) -> Vec<String> {
        let last = &self.last_model.effects;
        let steps = self.steps.iter();
        let added = steps.filter_map(|step| step.effect.clone());
        added.filter(|effect| last.contains(effect)).collect()
    }

    /// The effects of the first step that the last one does not have.
    pub fn taken_out(&self) -> Vec<String> {
        let first = self.steps.first().map_or(&[][..], |step| &step.effects);
        let last = &self.last_model.effects;
        let gone = first.iter().filter(|effect| !last.contains(effect));
        gone.cloned().collect()
    }

    /// The open tie, as model.toml states it: the provisional effects of the last model, and the other sets
    /// that could replace them.
    fn tie(&self, session: &Session) -> Option<Tie> {
        if self.provisional.is_empty() {
            return None;
        }
        let effects = |names: &[String]| -> Vec<EffectId> {
            let effects = names.iter();
            effects
                .filter_map(|name| session.effect_named(name))
                .collect()
        };
        let kept: Vec<&String> = self
            .last_model
            .effects
            .iter()
            .filter(|effect| !self.provisional.contains(effect))
            .collect();
        let rivals = self.ambiguous_between.iter().map(|set| {
            let mut set = set.clone();
            set.retain(|effect| !kept.contains(&effect));
            effects(&set)
        });
        let provisional = effects(&self.provisional);
        Some(Tie {
            rivals: rivals
                .filter(|set| !set.is_empty() && *set != provisional)
                .collect(),
            provisional,
        })
    }

    /// The suspects with a probability above one half.
    pub fn likely_suspects(&self) -> impl Iterator<Item = &SuspectEffect> {
        self.suspects
            .iter()
            .filter(|suspect| suspect.probability > 0.5)
    }
}

impl DiagnosisStep {
    /// "as it was", or the changes: "+ body-presliding-friction − body-coulomb-friction".
    pub fn name(&self) -> String {
        let taken_out: String = self
            .replaces
            .iter()
            .map(|one| format!(" − {one}"))
            .collect();
        let name = match &self.effect {
            None if self.replaces.is_empty() => "as it was".to_owned(),
            None => taken_out.trim_start().to_owned(),
            Some(effect) => format!("+ {effect}{taken_out}"),
        };
        if self.provisional {
            format!("{name} (provisional)")
        } else {
            name
        }
    }
}

pub(crate) fn fit_percent(trace: &PredictedSeries) -> f64 {
    trace.fit_percent
}

/// Numbers in the order of the records and their channels, with the names of the series.
pub(crate) fn per_series(records: &[Record], values: impl IntoIterator<Item = f64>) -> PerSeries {
    let names = records.iter().flat_map(|record| {
        record.channels.iter().map(|channel| SeriesName {
            experiment: record.name.clone(),
            channel: channel.output,
        })
    });
    names.zip(values).collect()
}

/// The step's root mean square errors on held-out data.
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

fn names_of(effects: &[EffectId]) -> Vec<String> {
    effects.iter().map(|one| one.name().to_owned()).collect()
}

/// The effects of the last model that are not certain.
fn provisional_effects(found: &Diagnosis) -> Vec<String> {
    let effects = found
        .last()
        .map_or(&[][..], |step| step.fit.model.effects());
    let open = effects.iter().filter(|one| !found.certain.has(**one));
    open.map(|one| one.name().to_owned()).collect()
}

/// The verdict as one or two sentences; `last` is the model of the last step.
fn sentence(found: &Diagnosis, last: &ComparisonReport) -> String {
    let first = found.steps.first();
    let was_there = |effect: &EffectId| first.is_some_and(|step| step.fit.model.has(*effect));
    let added: Vec<&str> = found
        .certain
        .effects()
        .iter()
        .filter(|effect| !was_there(effect))
        .map(|effect| effect.name())
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
    let text = match found.verdict {
        Verdict::NothingMissing => {
            format!("Nothing is missing: what the model leaves in the measurements is {noise}.")
        }
        Verdict::Explained => format!(
            "Explained: the model lacks {added}. What remains in the measurements is then \
             {noise}."
        ),
        Verdict::Ambiguous => {
            let beside = match added.as_str() {
                "" => String::new(),
                added => format!(" What all of them share was added: {added}."),
            };
            format!(
                "Ambiguous: something is missing, but these logs cannot tell {}.{beside}",
                alternatives(found)
            )
        }
        Verdict::Unexplained if !found.contradictions.is_empty() => {
            let with = match added.as_str() {
                "" => String::new(),
                added => format!(" with {added}"),
            };
            let sentences = found.contradictions.iter();
            let sentences: Vec<String> = sentences.map(Contradiction::sentence).collect();
            format!(
                "Unexplained: the model{with} follows every log, but what it is made of does not agree: {}.",
                sentences.join("; ")
            )
        }
        Verdict::Unexplained => {
            let missing = match (added.as_str(), found.ambiguous_between.is_empty()) {
                ("", true) => "something".to_owned(),
                (added, true) => format!("the model lacks {added}, and beyond that something"),
                ("", false) => format!(
                    "the model lacks one of several effects that these logs cannot tell apart ({}), and beyond \
                     that something",
                    alternatives(found)
                ),
                (added, false) => format!(
                    "the model lacks {added} and one of several effects that these logs cannot tell apart ({}), \
                     and beyond that something",
                    alternatives(found)
                ),
            };
            format!(
                "Unexplained: {missing} remains{}: {} times the noise of the sensor. No effect \
                 in the library accounts for it.",
                last.places.first().map_or(String::new(), remains_at),
                significant(found.remainder, 2)
            )
        }
    };
    text + &until_decided(found)
}

/// "body-presliding-friction from body-coulomb-friction + body-softening-spring".
fn alternatives(found: &Diagnosis) -> String {
    let sets = found.ambiguous_between.iter();
    let sets: Vec<String> = sets
        .map(|set| words::set(set.iter().map(|effect| effect.name())))
        .collect();
    sets.join(" from ")
}

/// The model that is used while a tie is open, and the reason.
fn until_decided(found: &Diagnosis) -> String {
    let names = provisional_effects(found);
    let reasons: Vec<&str> = names
        .iter()
        .filter_map(|name| Some(EffectId::from_name(name)?.info().prior.reason))
        .collect();
    if names.is_empty() {
        return String::new();
    }
    format!(
        " Until an experiment decides, the model predicts with {}, the most common of them ({}).",
        names.join(" + "),
        reasons.join("; ")
    )
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
