//! The result of a diagnosis, as the library returns it and as JSON states it.

use ::data_check::Finding;
use bench_files::{Correlation, Parameter};
use diagnose::{Recipe, Verdict};
use plant::Model;
use serde::{Deserialize, Serialize};

use crate::comparison::{BenchNote, ComparisonReport, FailurePlace, PushInLog};
use crate::design_change::DesignChange;
use crate::missing_torque::MissingTorque;
use crate::named;
use crate::per_series::PerSeries;
use crate::remains::RemainsReport;
use crate::swing_decay::SwingDecay;

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
    /// The provisional effects of the last model: an experiment must decide about them.
    pub provisional: Vec<String>,
    /// Which data were held out from the fit for the held-out predictions.
    pub held_out_by: HeldOutBy,
    /// The effects that could be missing, the most probable first.
    pub suspects: Vec<SuspectEffect>,
    /// The sets of effects that tie; empty if none do.
    pub ambiguous_between: Vec<Vec<String>>,
    /// The experiment that would settle an open question; empty if no question is open.
    pub next_experiment: String,
    /// The torque that the last model lacks, over the coordinate that describes it best. `None` if nothing is
    /// unexplained, or if no curve predicts a part of this torque.
    #[serde(default)]
    pub missing_torque: Option<MissingTorque>,
    /// The last model with the learned curves that the diagnosed model had; `None` if it had none, or if they are no
    /// longer needed. A curve explains nothing, so the verdict is about the model without curves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub with_learned: Option<DiagnosisStep>,
    /// The next experiment as a recipe: its steps, and the result that each explanation predicts. `None` if no
    /// experiment tells the explanations apart. The JSON has only the sentence [`DiagnosisReport::next_experiment`].
    #[serde(skip)]
    pub recipe: Option<Recipe>,
    /// The size of the unexplained residual and its effect on the controlled pendulum; `None` if nothing is
    /// unexplained.
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
    /// The effect's own parameters in that model, without those that have no value by themselves.
    pub parameters: Vec<Parameter>,
    /// Those that have none, because the logs determine them only together with another parameter.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_value: Vec<ParameterWithoutValue>,
    /// Root mean square errors with that model, SI units.
    pub rmse: PerSeries,
    /// One sentence: what the effect looks like in the data, and how far the error falls with it.
    pub fingerprint: String,
}

/// A parameter of a suspect that the logs determine only together with another one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ParameterWithoutValue {
    /// Its name.
    pub name: String,
    /// Why it has no value by itself, and what would give it one.
    pub why: String,
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

impl DiagnosisReport {
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
