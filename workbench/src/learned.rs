//! Torques as curves: the one that a model lacks, and those that were learned.

use diagnose::Verdict;
use identify::{Identification, MissingCurve, Progress};
use plant::{EffectId, LearnedCoordinate, LearnedCurve, Role};
use serde::{Deserialize, Serialize};

use crate::change::EffectChange;
use crate::comparison::{correlation_of, effect_names, parameters_of};
use crate::diagnosis::{DiagnosisReport, DiagnosisStep, FinalModel, fit_percent, per_series};
use crate::error::Error;
use crate::per_series::PerSeries;
use crate::session::Session;

/// The torque that a model lacks, over the coordinate in which it stands best.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissingTorque {
    /// angle, rate, wheel_speed or wheel_angle.
    pub coordinate: String,
    /// SI unit of the coordinate.
    pub unit: String,
    /// "body" or "wheel": on which it acts.
    pub acts_on: String,
    /// SI unit of the torque; "N m per kg m2" where the scale of the torques is not known.
    pub torque_unit: String,
    /// The experiments that show it.
    pub experiments: Vec<String>,
    /// Share of the missing torque beyond the noise that the curve predicts in experiments that it was not made
    /// from, 0 to 1.
    pub share: f64,
    /// The curve, by increasing coordinate.
    pub points: Vec<TorquePoint>,
    /// The command that puts it into the model.
    pub command: String,
}

/// A point of a torque curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorquePoint {
    /// The coordinate, SI.
    pub at: f64,
    /// The torque as it acts, positive towards positive angles.
    pub torque: f64,
    /// Its standard error.
    pub std: f64,
}

impl MissingTorque {
    pub(crate) fn new(session: &Session, curve: &MissingCurve) -> MissingTorque {
        let coordinate = curve.coordinate;
        let problem = session.problem();
        let (acts_on, is_known) = match coordinate.role() {
            Role::Wheel => ("wheel", problem.wheel_scale_known),
            _ => ("body", problem.body_scale_known),
        };
        let points = curve.points().into_iter().map(|point| TorquePoint {
            at: point.at,
            torque: point.torque_nm,
            std: point.std_nm,
        });
        MissingTorque {
            coordinate: coordinate.name().to_owned(),
            unit: coordinate.unit().to_owned(),
            acts_on: acts_on.to_owned(),
            torque_unit: if is_known { "N m" } else { "N m per kg m2" }.to_owned(),
            experiments: curve.experiments.clone(),
            share: curve.share,
            points: points.collect(),
            command: format!(
                "flywheel add --learned {} --bench {}",
                coordinate.name(),
                session.place().display()
            ),
        }
    }

    /// "It stands best over the angle: `flywheel add --learned angle` puts it into the model as a curve."
    pub fn sentence(&self) -> String {
        let coordinate = LearnedCoordinate::from_name(&self.coordinate);
        let words = coordinate.map_or("the coordinate", LearnedCoordinate::words);
        format!(
            "What is missing stands best as a torque on the {} over {words}: a curve over it predicts {:.0} % of \
             the missing torque. `add --learned {}` puts the curve into the model; it explains nothing, but the \
             error falls.",
            self.acts_on,
            100.0 * self.share,
            self.coordinate
        )
    }
}

impl Session {
    /// Learns the torque that the model lacks over a coordinate (angle, rate, wheel_speed or wheel_angle) as a
    /// smooth curve, fitted together with everything else. One that the model has already is learned anew.
    ///
    /// # Errors
    /// [`Error::UnknownCoordinate`]; [`Error::Identify`] where no log moves over the coordinate; those of
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

    /// Takes a learned curve out of the model and fits it anew.
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

    /// The torque that the model of a fit lacks, where a curve over a coordinate predicts something of it.
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

    /// Puts the learned curves that the model has into the last step of a diagnosis, where they are still needed.
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
                "{names}: what the curve followed is accounted for without it; --apply takes it out"
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
            "{} The model follows it with {names}, which explains nothing.",
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
            fit_percent: per_series(records, traces().map(fit_percent)),
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

/// Stands for a curve over the coordinate whose knots the fit finds.
pub(crate) fn placeholder(coordinate: LearnedCoordinate) -> EffectId {
    LearnedCurve::effect(coordinate, &[0.0, 1.0, 2.0, 3.0], None)
        .expect("four increasing knots within a turn")
}
