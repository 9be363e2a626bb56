//! Torques that are learned as curves: adding them to a model, removing them, and their place in a diagnosis.

use diagnose::Verdict;
use identify::{Identification, Progress};
use plant::{EffectId, LearnedCoordinate, LearnedCurve};

use crate::change::EffectChange;
use crate::comparison::{correlation_of, effect_names, parameters_of};
use crate::diagnosis::{DiagnosisReport, DiagnosisStep, FinalModel};
use crate::error::Error;
use crate::missing_torque::MissingTorque;
use crate::per_series::{PerSeries, per_series};
use crate::session::Session;

impl Session {
    /// Learns the torque that the model lacks over a coordinate (angle, rate, wheel_speed or wheel_angle) as a
    /// smooth curve, fitted together with all other parameters. A curve that the model already has is learned anew.
    ///
    /// # Errors
    /// [`Error::UnknownCoordinate`]; [`Error::Identify`] if the coordinate changes in no log; those of
    /// [`Session::identify`].
    pub fn add_learned(
        &mut self,
        coordinate: &str,
        progress: &Progress,
    ) -> Result<EffectChange, Error> {
        let placeholder = placeholder(named(coordinate)?);
        let before = self.structure();
        let after = before
            .learned()
            .filter(|curve| curve.name() == placeholder.name())
            .fold(before.clone(), |model, curve| model.without(curve))
            .with(placeholder);
        self.change(&before, &after, progress)
    }

    /// Removes a learned curve from the model and fits the model anew.
    ///
    /// # Errors
    /// [`Error::UnknownCoordinate`]; those of [`Session::remove_effect`].
    pub fn remove_learned(
        &mut self,
        coordinate: &str,
        progress: &Progress,
    ) -> Result<EffectChange, Error> {
        self.remove_effect(named(coordinate)?.effect_name(), progress)
    }

    /// The torque that the model of a fit lacks; `None` if no curve over a coordinate predicts a part of it.
    pub(crate) fn missing_torque(&self, found: &Identification) -> Option<MissingTorque> {
        let fit = &found.fit;
        let problem = self.problem().suited_to(&fit.model);
        let curve = identify::best_missing_curve(
            &problem.all_records(),
            &fit.minimum.windows,
            &fit.model,
            &fit.values,
            &problem.free(&fit.model),
        )?;
        Some(MissingTorque::new(self, &curve))
    }

    /// Adds the learned curves of the session's model to the last step of a diagnosis, if they are still needed.
    pub(crate) fn with_learned(
        &self,
        report: &mut DiagnosisReport,
        last_fit: &Identification,
        progress: &Progress,
    ) -> Result<(), Error> {
        let coordinates = self.learned_coordinates();
        let names: Vec<&str> = coordinates.iter().map(|one| one.effect_name()).collect();
        let names = names.join(" and ");
        if report.verdict != Verdict::Unexplained {
            report.statements.push(format!(
                "{names}: the model now accounts for this torque without the curve; applying the diagnosis removes the curve"
            ));
            return Ok(());
        }
        let found = identify::with_curves(self.problem(), &last_fit.fit, &coordinates, progress)
            .map_err(|source| self.not_identified(source))?;
        let records = &self.problem().records;
        let traces = || found.traces.iter().flatten();
        let parameters = parameters_of(self.problem(), &found.fit);
        let rmse = per_series(records, traces().map(|trace| trace.rmse));
        report.last_model = FinalModel {
            effects: effect_names(&found.fit.model),
            parameters: parameters.clone(),
            rmse: rmse.clone(),
        };
        report.sentence = format!(
            "{} The model follows this error with {names}; a learned curve explains nothing.",
            report.sentence
        );
        report.with_learned = Some(DiagnosisStep {
            effect: coordinates.first().map(|one| one.effect_name().to_owned()),
            replaces: vec![],
            provisional: false,
            held_out_worse: false,
            effects: effect_names(&found.fit.model),
            parameters,
            correlation: correlation_of(&found.fit),
            rmse,
            fit_percent: per_series(records, traces().map(|trace| trace.fit_percent)),
            validation_fit_percent: f64::NAN,
            validation_rmse: PerSeries::default(),
        });
        report.learned_model = Some(found.fit.model.clone());
        Ok(())
    }

    /// The coordinates over which the model has learned curves.
    pub fn learned_coordinates(&self) -> Vec<LearnedCoordinate> {
        let model = self.structure();
        let curves = model.learned();
        curves
            .filter_map(|curve| curve.info().learned.map(|curve| curve.coordinate))
            .collect()
    }
}

fn named(coordinate: &str) -> Result<LearnedCoordinate, Error> {
    LearnedCoordinate::from_name(coordinate)
        .or_else(|| LearnedCoordinate::from_effect_name(coordinate))
        .ok_or_else(|| Error::UnknownCoordinate {
            name: coordinate.to_owned(),
        })
}

/// A placeholder for a curve over the coordinate; the fit replaces its knots.
pub(crate) fn placeholder(coordinate: LearnedCoordinate) -> EffectId {
    LearnedCurve::effect(coordinate, &[0.0, 1.0, 2.0, 3.0], None)
        .expect("four increasing knots within a turn")
}
