//! Torques that are learned as curves: adding them to a model, removing them, and their place in a diagnosis.

use bench_files::numbers::number;
use diagnose::Verdict;
use identify::{Identification, Progress};
use plant::{EffectId, LearnedCoordinate, LearnedCurve};

use crate::change::EffectChange;
use crate::comparison::{correlation_of, effect_names, parameters_of};
use crate::diagnosis::{DiagnosisReport, DiagnosisStep, FinalModel};
use crate::error::Error;
use crate::missing_torque::MissingTorque;
use crate::per_series::{PerSeries, SeriesName, per_series};
use crate::session::Session;

/// Error of a series, in units of its sensor's noise, from which a curve has left something: the mark that the exam of
/// learned curves sets, too.
const LEFT_BY_CURVE: f64 = 1.5;

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
        let coordinate = named(coordinate)?;
        let placeholder = placeholder(coordinate);
        let before = self.structure();
        let after = before
            .learned()
            .filter(|curve| curve.name() == placeholder.name())
            .fold(before.clone(), |model, curve| model.without(curve))
            .with(placeholder);
        let mut change = self.change(&before, &after, progress)?;
        let remark = self.too_fine(coordinate, &change);
        change.after.statements.extend(remark);
        Ok(change)
    }

    /// What a curve leaves although it was fitted: either the torque is no function of the coordinate alone, or it
    /// changes more finely than the knots can follow. A spline's curve has one free value a knot, and so at most one
    /// bump in two knots (as a sampled signal, by Nyquist); it follows one well from four on.
    fn too_fine(&self, coordinate: LearnedCoordinate, change: &EffectChange) -> Option<String> {
        let after = &change.after;
        let over_noise = |(series, rmse): &(SeriesName, f64)| {
            let noise = after.sensor_noise.of(series)?;
            (*rmse > LEFT_BY_CURVE * noise && noise > 0.0)
                .then(|| (rmse / noise, series.to_string()))
        };
        let worst = after.rmse.iter().filter_map(over_noise);
        let (times, series) = worst.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let model = self.structure();
        let mut curves = model.learned().filter_map(|curve| curve.info().learned);
        let curve = curves.find(|curve| curve.coordinate == coordinate)?;
        let knots = curve.spline.knots();
        let count = knots.len();
        let spacing = match coordinate.period() {
            Some(period) => period / count as f64,
            None => (knots[count - 1] - knots[0]) / (count - 1).max(1) as f64,
        };
        let unit = coordinate.unit();
        Some(format!(
            "with the curve, the error of {series} is still {} times the sensor's noise: the torque is no function of {} \
             alone, or it changes more finely than the curve's {count} knots, {} {unit} apart on average, which follow \
             bumps of four knots well ({} {unit}) and none of fewer than two. An effect of the library (wheel-cogging has \
             any number of bumps a turn) or one of your own (effects/NAME.toml) has no such limit",
            number(times),
            coordinate.words(),
            number(spacing),
            number(4.0 * spacing)
        ))
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
