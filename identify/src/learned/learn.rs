//! The fit of a model with a learned curve.

use plant::{EffectId, LearnedCoordinate, LearnedCurve, Model};

use super::knots::{final_knots, samples_of};
use super::missing::missing_curve;
use super::own_terms::{apart_from, own_terms};
use super::shows;
use super::smoothing::smoothed;
use crate::bench::{FitProblem, IdentifyError};
use crate::extension::carry_over;
use crate::fit::{Effort, Minimum, Unknowns, fit_from_scratch, refit, score_test};
use crate::progress::Progress;

/// Largest number of times that the penalty is chosen anew, each time at the minimum of the last choice.
const CHOICES: usize = 3;
/// If a new choice differs from the last one by less than this factor, it counts as the same: the curve hardly changes.
const SAME_CHOICE: f64 = 4.0;

/// A fit whose mean squared residual is below this value follows the logs. No further start is then tried.
const GOOD: f64 = 1.2;

/// Learns the torque that `model` lacks over a coordinate, and fits it together with everything else. `minimum`
/// is that of `model`, which has no curve over this coordinate.
///
/// # Errors
/// [`IdentifyError::NothingToLearn`] where the logs do not move over the coordinate; [`IdentifyError::Cancelled`].
pub(crate) fn learn(
    problem: &FitProblem,
    model: &Model,
    minimum: &Minimum,
    coordinate: LearnedCoordinate,
    progress: &Progress,
) -> Result<(Model, Minimum), IdentifyError> {
    let nothing = || IdentifyError::NothingToLearn { coordinate };
    let records = problem.all_records();
    let free = problem.free(model);
    progress.check()?;
    (progress.say)("looking for the missing torque");
    let (windows, values) = (&minimum.windows, &minimum.values);
    let missing =
        missing_curve(&records, windows, model, values, &free, coordinate).ok_or_else(nothing)?;
    let samples: Vec<f64> = records
        .iter()
        .filter(|record| shows(coordinate, record.kind))
        .flat_map(|record| samples_of(record, coordinate))
        .collect();
    let knots = final_knots(
        &samples,
        coordinate,
        &missing.spline,
        missing.torque_nm.as_slice(),
    )
    .ok_or_else(nothing)?;
    let bare = LearnedCurve::effect(coordinate, &knots, None).ok_or_else(nothing)?;
    let curve = bare.info().learned.ok_or_else(nothing)?;
    let terms = own_terms(model, values, &free, coordinate, &curve.spline, &samples);

    // A first guess of the curve and the parameters, from the missing torque alone.
    let mut shifted = values.clone();
    let infos = model.parameters();
    for &(position, shift) in &missing.shifts {
        let (low, high) = infos[position].bounds;
        shifted[position] = (values[position] + shift).clamp(low, high);
    }
    let torque: Vec<f64> = knots
        .iter()
        .map(|&knot| missing.spline.value(missing.torque_nm.as_slice(), knot))
        .collect();

    progress.check()?;
    (progress.say)("fitting the curve together with everything else");
    let starts = |larger: &Model, effect: EffectId, base: &[f64]| -> Vec<f64> {
        let mut start = vec![0.0; larger.parameter_count()];
        if let Some(own) = larger.range_of(effect) {
            start[own].copy_from_slice(&torque);
        }
        carry_over(model, base, larger, &start)
    };
    // The penalty of the first fit, which follows from the missing torque.
    let with_bare = model.with(bare);
    let unknowns = Unknowns::new(&with_bare, &problem.free(&with_bare));
    let at = starts(&with_bare, bare, values);
    let information = score_test(&records, &with_bare, &at, windows, &unknowns, None).information();
    let apart = match curve_range(&with_bare, bare, &unknowns) {
        Some(range) if information.iter().all(|entry| entry.is_finite()) => {
            apart_from(&terms, &information, range)
        }
        _ => nalgebra::DMatrix::zeros(knots.len(), knots.len()),
    };
    let first = curve.spline.roughness() * missing.smoothing + apart;
    let mut effect = LearnedCurve::effect(coordinate, &knots, Some(first)).ok_or_else(nothing)?;
    let mut larger = model.with(effect);
    let rough = Effort::ROUGH.until(progress.cancelled);
    let free = problem.free(&larger);
    let observations: usize = records.iter().map(|record| record.observations()).sum();
    let is_good = |found: &Option<Minimum>| {
        let found = found.as_ref();
        found.is_some_and(|found| found.cost < GOOD * observations as f64)
    };
    let mut found: Option<Minimum> = None;
    if coordinate == LearnedCoordinate::WheelAngle {
        // The wheel's angle must match the curve in every turn.
        let start = starts(&larger, effect, &shifted);
        keep_better(
            &mut found,
            fit_from_scratch(&records, &larger, start, &free, rough),
        );
        progress.check()?;
    }
    for base in [&shifted, values] {
        if !is_good(&found) {
            let start = starts(&larger, effect, base);
            let windows = windows.clone();
            keep_better(
                &mut found,
                refit(&records, &larger, start, windows, &free, rough),
            );
        }
        progress.check()?;
    }
    if !is_good(&found) && coordinate != LearnedCoordinate::WheelAngle {
        // Over whole logs the cost has many minima: the windows grow from short ones.
        let start = starts(&larger, effect, &shifted);
        keep_better(
            &mut found,
            fit_from_scratch(&records, &larger, start, &free, rough),
        );
    }
    if found
        .as_ref()
        .is_none_or(|found| found.cost >= minimum.cost)
    {
        // No start led to a lower cost than the model without the curve. That model is therefore the start, and its
        // cost can only fall.
        let start = carry_over(model, values, &larger, &vec![0.0; larger.parameter_count()]);
        let windows = windows.clone();
        keep_better(
            &mut found,
            refit(&records, &larger, start, windows, &free, rough),
        );
    }
    let mut found = found.ok_or_else(nothing)?;

    let mut factor = missing.smoothing;
    for choice in 0..CHOICES {
        progress.check()?;
        let free = problem.free(&larger);
        let chosen = smoothed(
            &records,
            &found.windows,
            &larger,
            &found.values,
            &free,
            effect,
            &terms,
        );
        let Some((chosen, next)) = chosen else { break };
        let ratio = next / factor;
        if choice > 0 && (1.0 / SAME_CHOICE..=SAME_CHOICE).contains(&ratio) {
            break;
        }
        factor = next;
        effect = chosen;
        larger = model.with(effect);
        let effort = Effort::PATIENT.until(progress.cancelled);
        let free = problem.free(&larger);
        found = refit(
            &records,
            &larger,
            found.values,
            found.windows,
            &free,
            effort,
        );
    }
    progress.check()?;
    Ok((larger, found))
}

/// The positions of a curve's parameters among the unknowns.
fn curve_range(
    model: &Model,
    effect: EffectId,
    unknowns: &Unknowns,
) -> Option<std::ops::Range<usize>> {
    let own = model.range_of(effect)?;
    let place = unknowns.free.iter().position(|&at| at == own.start)?;
    Some(place..place + own.len())
}

fn keep_better(best: &mut Option<Minimum>, next: Minimum) {
    let is_better = best.as_ref().is_none_or(|best| next.cost < best.cost);
    if next.cost.is_finite() && is_better {
        *best = Some(next);
    }
}
