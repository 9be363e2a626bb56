//! A fit that also starts from the minimum of a neighbouring model: one with an effect more or less.

use plant::{EffectId, LearnedCoordinate, Model};

use crate::bench::{FitProblem, IdentifyError};
use crate::errors::Fit;
use crate::extension::{carry_over, extend};
use crate::fit::{Effort, Minimum, joined};
use crate::identification::{
    Identification, SAME_COST, coordinate_of, fit_until, identification, with_curves,
};
use crate::progress::Progress;

/// As [`fit_until`] without a previous fit, and a second time from the minimum of a neighbouring model. Returns the fit
/// with the lower cost. A larger model then never costs more than the smaller one that it contains.
///
/// # Errors
/// Those of [`fit_until`], if neither way succeeds.
pub fn fit_from_neighbour(
    problem: &FitProblem,
    neighbour: &Fit,
    model: &Model,
    progress: &Progress,
) -> Result<Identification, IdentifyError> {
    let alone = fit_until(problem, model, None, progress);
    progress.check()?;
    let near = near(problem, neighbour, model, progress);
    progress.check()?;
    match (alone, near) {
        // Both may have found the same minimum. The fit that depends on no neighbour then goes first, so that an effect
        // that is added and removed again leaves every digit as it was.
        (Ok(alone), Some(near))
            if alone.fit.minimum.cost * (1.0 - SAME_COST) <= near.fit.minimum.cost =>
        {
            Ok(alone)
        }
        (Ok(alone), None) => Ok(alone),
        (_, Some(near)) => Ok(near),
        (Err(error), None) => Err(error),
    }
}

/// The fit from the neighbour's minimum. `None` if neither model contains the other, if the neighbour has a learned curve
/// (its knots belong to that fit), or if no finite simulation starts there.
fn near(
    problem: &FitProblem,
    neighbour: &Fit,
    model: &Model,
    progress: &Progress,
) -> Option<Identification> {
    let from = &neighbour.model;
    if from.learned().next().is_some() {
        return None;
    }
    let curves: Vec<LearnedCoordinate> = model.learned().filter_map(coordinate_of).collect();
    if !curves.is_empty() {
        let is_same = model.without_learned() == *from;
        let found = is_same.then(|| with_curves(problem, neighbour, &curves, progress));
        return found.and_then(Result::ok);
    }
    let suited = problem.suited_to(model);
    let records = suited.all_records();
    let (values, windows) = (&neighbour.values, &neighbour.minimum.windows);
    let windows = joined(&records, values, windows);
    if contains(from, model) {
        let start = vec![0.0; model.parameter_count()];
        let values = carry_over(from, values, model, &start);
        let found = fit_until(problem, model, Some((values, windows)), progress);
        return found.ok();
    }
    if !contains(model, from) {
        return None;
    }
    let minimum = Minimum {
        windows,
        ..neighbour.minimum.clone()
    };
    let effort = Effort::FULL.until(progress.cancelled);
    let found = extend(&suited, &records, from, &minimum, model, effort);
    (found.cost.is_finite() && found.values.len() == model.parameter_count())
        .then(|| identification(&suited, model, found, None))
}

/// Whether `large` has every effect of `small`, or one that contains it.
fn contains(large: &Model, small: &Model) -> bool {
    let is_there = |effect: &EffectId| {
        let mut effects = large.effects().iter();
        large.has(*effect) || effects.any(|larger| larger.info().replaces.contains(&effect.name()))
    };
    small.effects().iter().all(is_there)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_contains_what_its_effects_replace() {
        let coulomb = Model::base().with(EffectId::BodyCoulombFriction);
        let presliding = coulomb.with(EffectId::BodyPreslidingFriction);
        let drag = Model::base().with(EffectId::WheelQuadraticDrag);
        assert!(contains(&coulomb, &Model::base()));
        assert!(contains(&presliding, &coulomb));
        assert!(!contains(&coulomb, &presliding));
        assert!(!contains(&coulomb, &drag) && !contains(&drag, &coulomb));
    }
}
