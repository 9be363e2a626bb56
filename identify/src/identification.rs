//! The identification: from a bench to a fitted model with all statements about it.

use bench_files::numbers::number;
use nalgebra::DVector;
use parallel::{parallel_map, parallel_pair};
use plant::{
    BASE_PARAMETERS, EffectId, GRAVITY_TORQUE, Instant, LearnedCoordinate, Model, Smoothing,
    TOTAL_INERTIA, WHEEL_INERTIA,
};

use crate::bench::{FitProblem, IdentifyError};
use crate::errors::{Contradiction, Fit, body_inertia_contradiction, contradictions, finish};
use crate::extension::{carry_over, extend};
use crate::first_fit::{first_fit, other_period};
use crate::fit::{
    Effort, Minimum, PredictedSeries, Unknowns, Window, acts, cost, failed_series, joined, refit,
    traces,
};
use crate::learned::learn;
use crate::progress::Progress;
use crate::records::{Output, Record};
use crate::residuals::{FoundPush, PushModel, find_pushes};
use crate::statements::{OPEN_RELATIVE_STD, cautions, statements};

/// A fitted model with all statements about it.
#[derive(Clone, Debug)]
pub struct Identification {
    /// The fit.
    pub fit: Fit,
    /// For each record and channel: the prediction compared with the measurement.
    pub traces: Vec<Vec<PredictedSeries>>,
    /// For each record: the pushes that nobody recorded, sized with the fitted model.
    pub pushes: Vec<Vec<FoundPush>>,
    /// Experiments and known values that cannot all be right, one sentence each. These sentences are among the
    /// statements, too.
    pub contradictions: Vec<String>,
    /// What the logs do not determine, one sentence each.
    pub statements: Vec<String>,
}

/// Fits `model` to all experiments of the bench. `previous` may hold the values and windows of a neighbouring fit of the
/// same model, from which this fit then starts.
///
/// # Errors
/// [`IdentifyError::NotFinite`] if no start gives a finite simulation; [`IdentifyError::NoBetterThanMeans`] if no start
/// gives a fit that follows the logs; [`IdentifyError::InertiaOpen`] if they leave an inertia open.
pub fn identify(
    problem: &FitProblem,
    model: &Model,
    previous: Option<(Vec<f64>, Vec<Vec<Window>>)>,
) -> Result<Identification, IdentifyError> {
    identify_until(problem, model, previous, &Progress::silent())
}

/// As [`identify`], and can be cancelled: the work ends within one evaluation of the normal equations, or one pass over
/// the logs, after `progress` returns that it is cancelled.
///
/// # Errors
/// Those of [`identify`]; [`IdentifyError::Cancelled`].
pub fn identify_until(
    problem: &FitProblem,
    model: &Model,
    previous: Option<(Vec<f64>, Vec<Vec<Window>>)>,
    progress: &Progress,
) -> Result<Identification, IdentifyError> {
    let found = fit_until(problem, model, previous, progress)?;
    refuse_failed(problem, &found.fit)?;
    Ok(found)
}

/// Rejects a fit that has failed: one that predicts the logs no better than their means, or one that leaves an
/// inertia open, because its standard error is as large, or because a few rows are fitted as well by another period.
/// No motion can be computed without the inertias. An inertia that the logs do not show at all is not fitted and does
/// not count. Where the logs hide the wheel's inertia, the period of the body counts.
///
/// # Errors
/// [`IdentifyError::NoBetterThanMeans`], [`IdentifyError::InertiaOpen`].
pub fn refuse_failed(problem: &FitProblem, fit: &Fit) -> Result<(), IdentifyError> {
    let (model, windows) = (&fit.model, &fit.minimum.windows);
    let problem = problem.suited_to(model);
    let records = problem.all_records();
    let unknowns = Unknowns::new(model, &problem.free(model));
    let series = failed_series(&records, model, &fit.minimum.values, windows, &unknowns);
    if !series.is_empty() {
        return Err(IdentifyError::NoBetterThanMeans { series });
    }
    if let Some(error) = open_inertia(&problem, fit) {
        return Err(error);
    }
    if *model == Model::base()
        && let Some((position, other)) = other_period(&problem, &fit.minimum)
    {
        let value = fit.values[position];
        return Err(IdentifyError::InertiaOpen {
            parameter: BASE_PARAMETERS[position].name,
            value,
            std: Some((other - value).abs()),
        });
    }
    Ok(())
}

/// The error of a fit that leaves an inertia open: its standard error is as large as its value, or it lies on a bound.
/// Where the logs hide the wheel's inertia, the period of the body counts.
pub fn open_inertia(problem: &FitProblem, fit: &Fit) -> Option<IdentifyError> {
    if problem.hides_wheel_inertia() {
        return has_open_period(fit).then(|| inertia_open(fit, TOTAL_INERTIA));
    }
    let mut inertias = [TOTAL_INERTIA, WHEEL_INERTIA].into_iter();
    inertias.find_map(|position| open(fit, position))
}

/// The error of a fit in which the parameter at this position is fitted and not determined: it lies on a bound of its
/// range, or its standard error is as large as its value.
fn open(fit: &Fit, position: usize) -> Option<IdentifyError> {
    let index = fit.unknowns.free.iter().position(|&at| at == position)?;
    let (value, std) = (fit.values[position], fit.std(position));
    let is_open = std.is_some_and(|std| std >= OPEN_RELATIVE_STD * value.abs());
    (fit.minimum.on_bound[index] || is_open).then(|| inertia_open(fit, position))
}

fn inertia_open(fit: &Fit, position: usize) -> IdentifyError {
    IdentifyError::InertiaOpen {
        parameter: BASE_PARAMETERS[position].name,
        value: fit.values[position],
        std: fit.std(position),
    }
}

/// Whether logs that hide the wheel's inertia leave even G/(Θ − j_w) open, the square of the frequency at which the body
/// swings. They say next to nothing about the inertias themselves.
fn has_open_period(fit: &Fit) -> bool {
    let values = &fit.values;
    let free_body = values[TOTAL_INERTIA] - values[WHEEL_INERTIA];
    // The derivative of the logarithm of that ratio.
    let slope = |position: usize| match position {
        GRAVITY_TORQUE => 1.0 / values[position],
        TOTAL_INERTIA => -1.0 / free_body,
        WHEEL_INERTIA => 1.0 / free_body,
        _ => 0.0,
    };
    let slopes = fit.unknowns.free.iter().map(|&position| slope(position));
    let slopes = DVector::from_iterator(fit.unknowns.free.len(), slopes);
    let variance = fit
        .covariance
        .as_ref()
        .map(|of| slopes.dot(&(of * &slopes)));
    variance.is_some_and(|variance| variance.sqrt() >= OPEN_RELATIVE_STD)
}

/// As [`identify_until`], for a model that need not follow the logs. A diagnosis begins with such a model: the effect
/// that it lacks may dominate everything (such as a zero of the angle that is far off).
///
/// # Errors
/// [`IdentifyError::NotFinite`], [`IdentifyError::Cancelled`].
pub fn fit_until(
    problem: &FitProblem,
    model: &Model,
    previous: Option<(Vec<f64>, Vec<Vec<Window>>)>,
    progress: &Progress,
) -> Result<Identification, IdentifyError> {
    let effort = Effort::FULL.until(progress.cancelled);
    let suited = problem.suited_to(model);
    let problem = suited.as_ref();
    let records = problem.all_records();
    let learned: Vec<LearnedCoordinate> = model.learned().filter_map(coordinate_of).collect();
    let relearns = previous.is_none() || model.learned().any(|effect| !has_penalty(effect));
    let (model, minimum) = if learned.is_empty() || !relearns {
        let minimum = fitted(problem, &records, model, previous, effort, progress)?;
        (model.clone(), minimum)
    } else {
        // First everything that is not learned: a curve is what is left.
        let plain = model.without_learned();
        let previous = previous.map(|(values, windows)| {
            let start = vec![0.0; plain.parameter_count()];
            (carry_over(model, &values, &plain, &start), windows)
        });
        let minimum = fitted(problem, &records, &plain, previous, effort, progress)?;
        let mut so_far = (plain, minimum);
        for coordinate in learned {
            so_far = learn(problem, &so_far.0, &so_far.1, coordinate, progress)?;
        }
        so_far
    };
    let model = &model;
    progress.check()?;
    if !minimum.cost.is_finite() {
        if let Some(error) = not_finite(&records, model) {
            return Err(error);
        }
        let suspect = records
            .first()
            .map_or(String::new(), |record| record.name.clone());
        return Err(IdentifyError::NotFinite { suspect });
    }
    let found = identification(problem, model, minimum, None);
    progress.check()?;
    Ok(found)
}

/// The effect from outside the library whose torque is not finite at the start of its parameters, at the first sample of
/// the logs where that is so.
fn not_finite(records: &[&Record], model: &Model) -> Option<IdentifyError> {
    let outsiders = model
        .effects()
        .iter()
        .filter(|effect| matches!(effect, EffectId::External(_)));
    for &effect in outsiders {
        let p = effect.info().starts[0];
        for record in records.iter().filter(|record| acts(effect, record.kind)) {
            let of = |output: Output, k: usize| {
                record
                    .channel(output)
                    .map_or(0.0, |channel| channel.samples[k])
            };
            for k in 0..record.len() {
                let at = Instant {
                    angle_rad: of(Output::Angle, k),
                    rate_rad_s: of(Output::Rate, k),
                    wheel_angle_rad: record.wheel_angle_before(k),
                    wheel_speed_rad_s: of(Output::WheelSpeed, k),
                    current_a: record.current_a.get(k).copied().unwrap_or(0.0),
                    memory: 0.0,
                };
                let motion = [
                    ("angle", at.angle_rad, "rad"),
                    ("rate", at.rate_rad_s, "rad/s"),
                    ("wheel_angle", at.wheel_angle_rad, "rad"),
                    ("wheel_speed", at.wheel_speed_rad_s, "rad/s"),
                    ("current", at.current_a, "A"),
                ];
                let is_whole = motion.iter().all(|(_, value, _)| value.is_finite());
                if is_whole && !effect.torque(p, &at, &Smoothing::SIMULATION).is_finite() {
                    let words = motion
                        .map(|(name, value, unit)| format!("{name} {} {unit}", number(value)));
                    return Some(IdentifyError::EffectNotFinite {
                        effect: effect.name(),
                        experiment: record.name.clone(),
                        at: words.join(", "),
                    });
                }
            }
        }
    }
    None
}

/// A fit with the torque that its model lacks learned over these coordinates, one after the other.
///
/// # Errors
/// [`IdentifyError::NothingToLearn`], [`IdentifyError::Cancelled`].
pub fn with_curves(
    problem: &FitProblem,
    fit: &Fit,
    coordinates: &[LearnedCoordinate],
    progress: &Progress,
) -> Result<Identification, IdentifyError> {
    let problem = problem.suited_to(&fit.model);
    let mut so_far = (fit.model.without_learned(), fit.minimum.clone());
    for &coordinate in coordinates {
        so_far = learn(&problem, &so_far.0, &so_far.1, coordinate, progress)?;
    }
    Ok(identification(&problem, &so_far.0, so_far.1, None))
}

/// The minimum of a model, from a neighbouring fit of it or from the base model.
fn fitted(
    problem: &FitProblem,
    records: &[&Record],
    model: &Model,
    previous: Option<(Vec<f64>, Vec<Vec<Window>>)>,
    effort: Effort,
    progress: &Progress,
) -> Result<Minimum, IdentifyError> {
    if let Some((values, windows)) = previous {
        // The fit before may have been over other windows.
        let windows = joined(records, &values, &windows);
        let free = problem.free(model);
        return Ok(refit(records, model, values, windows, &free, effort));
    }
    // The base model first: effects are small against inertia and gravity.
    let base = Model::base();
    let first = first_fit(problem, effort);
    progress.check()?;
    Ok(if *model == base {
        first
    } else {
        extend(problem, records, &base, &first, model, effort)
    })
}

/// The coordinate of a learned effect.
pub(crate) fn coordinate_of(effect: EffectId) -> Option<LearnedCoordinate> {
    effect.info().learned.map(|curve| curve.coordinate)
}

/// Whether it is known how smooth the curve is to be: not of one that comes from a model.toml.
fn has_penalty(effect: EffectId) -> bool {
    let curve = effect.info().learned;
    curve.is_some_and(|curve| curve.penalty.is_some())
}

/// The results for the bench from a fit that was made before. `None` where it is not a fit of this bench as the model
/// reads it: where other windows or other samples counted.
pub fn describe(problem: &FitProblem, fit: &Fit) -> Option<Identification> {
    let problem = problem.suited_to(&fit.model);
    let records = problem.all_records();
    let minimum = &fit.minimum;
    let samples = |windows: &[Vec<Window>]| -> Vec<Vec<std::ops::Range<usize>>> {
        let of_record = |list: &Vec<Window>| list.iter().map(|w| w.samples.clone()).collect();
        windows.iter().map(of_record).collect()
    };
    let own = joined(&records, &fit.values, &minimum.windows);
    let again = cost(&records, &fit.model, &fit.values, &minimum.windows);
    let is_own = samples(&own) == samples(&minimum.windows)
        && (again - minimum.cost).abs() <= SAME_COST * minimum.cost;
    let (model, minimum) = (&fit.model, minimum.clone());
    is_own.then(|| identification(&problem, model, minimum, Some(fit.clone())))
}

/// Relative difference up to which two costs count as equal (rounding).
pub(crate) const SAME_COST: f64 = 1e-9;

/// All statements about a minimum, for a problem whose windows suit the model. `fit` is the minimum with its standard
/// errors, if they are known.
pub(crate) fn identification(
    problem: &FitProblem,
    model: &Model,
    minimum: Minimum,
    fit: Option<Fit>,
) -> Identification {
    let records = problem.all_records();
    let free = problem.free(model);
    // These parts are independent of each other; one long log alone would keep only one core busy.
    let ((fit, contradicted), (traces, pushes)) = parallel_pair(
        || {
            let on_bound: Vec<usize> = free
                .iter()
                .zip(&minimum.on_bound)
                .filter_map(|(&position, &on_bound)| on_bound.then_some(position))
                .collect();
            parallel_pair(
                || fit.unwrap_or_else(|| finish(&records, model, &free, minimum.clone())),
                || contradictions(problem, model, &minimum.values, &minimum.windows, &on_bound),
            )
        },
        || {
            let push_model = PushModel::of(model, &minimum.values);
            let each = records.iter().zip(&minimum.windows);
            let traces: Vec<Vec<PredictedSeries>> = parallel_map(each, |(record, windows)| {
                traces(record, windows, model, &minimum.values)
            });
            let pushes: Vec<Vec<FoundPush>> =
                parallel_map(&records, |record| find_pushes(record, &push_model));
            (traces, pushes)
        },
    );
    let mut statements = statements(problem, &fit);
    let mut contradictions: Vec<String> =
        contradicted.iter().map(Contradiction::sentence).collect();
    contradictions.extend(body_inertia_contradiction(problem, &fit));
    statements.extend(contradictions.iter().cloned());
    statements.extend(cautions(&records, &traces));
    Identification {
        fit,
        traces,
        pushes,
        contradictions,
        statements,
    }
}
