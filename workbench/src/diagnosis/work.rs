//! The diagnosis of a session, and the change of the session's model by its result.

use bench_files::{ModelFile, Parameter, Tie};
use diagnose::{Diagnosis, Options, Step, Suspect, Unseen, Verdict};
use identify::{Fit, FitProblem, Identification, Progress};
use plant::{EffectId, Model};

use super::report::{
    AppliedDiagnosis, DiagnosisReport, DiagnosisStep, FinalModel, HeldOutBy, ParameterWithoutValue,
    SuspectEffect,
};
use super::sentence::{provisional_effects, sentence};
use crate::comparison::{
    ComparisonReport, correlation_of, effect_names, parameters_of, with_model,
};
use crate::control_design::ControlDesign;
use crate::design_change::DesignChange;
use crate::error::Error;
use crate::per_series::{PerSeries, SeriesName, per_series};
use crate::remains::RemainsReport;
use crate::session::Session;
use crate::swing_decay::swing_decays;

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
        // A learned curve explains nothing, so the torque that it follows is still to be explained.
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
            // If the diagnosis has left out pushes that it alone found in the logs, its fit does not match the
            // session's records, and is repeated.
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
                (progress.say)("looking for the coordinate that describes the missing torque best");
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
            file.unexplained =
                (report.verdict == Verdict::Unexplained).then(|| report.sentence.clone());
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

    /// Makes the refitted first model of the diagnosis the session's model, unless its fit has failed.
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
                        step.candidate
                            .traces
                            .iter()
                            .flatten()
                            .map(|trace| trace.fit_percent),
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
                .map(|suspect| {
                    let (parameters, without_value) =
                        own_parameters(session.problem(), parameters(&suspect.fit), suspect);
                    SuspectEffect {
                        effect: suspect.effect.name().to_owned(),
                        probability: suspect.probability,
                        model: effect_names(&suspect.model),
                        takes_away: per_series(records, suspect.takes_away.iter().copied()),
                        validation_fit_percent: suspect.validation_fit_percent,
                        parameters,
                        without_value,
                        rmse: per_series(records, suspect.rmse.iter().copied()),
                        fingerprint: suspect.fingerprint.clone(),
                    }
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

/// The parameters that belong to the suspected effect, and those of them that have no value by themselves.
fn own_parameters(
    problem: &FitProblem,
    mut parameters: Vec<Parameter>,
    suspect: &Suspect,
) -> (Vec<Parameter>, Vec<ParameterWithoutValue>) {
    let own = suspect.effect.info().parameters;
    parameters.retain(|parameter| own.iter().any(|info| info.name == parameter.name));
    let infos = suspect.fit.model.parameters();
    let mut without = vec![];
    for one in identify::without_value(problem, &suspect.fit) {
        let name = infos[one.position].name;
        let before = parameters.len();
        parameters.retain(|parameter| parameter.name != name);
        if parameters.len() < before {
            without.push(ParameterWithoutValue {
                name: name.to_owned(),
                why: one.why,
            });
        }
    }
    (parameters, without)
}

fn names_of(effects: &[EffectId]) -> Vec<String> {
    effects.iter().map(|one| one.name().to_owned()).collect()
}
