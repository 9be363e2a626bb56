//! The first fit of a bench: the base model, started from what the samples show, and from other starts if that fit
//! does not follow the logs.

use plant::{GRAVITY_TORQUE, Kind, Model, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use crate::bench::FitProblem;
use crate::fit::{
    Effort, Minimum, cost, cost_of_means, fit_from_scratch, fit_in_stages, integrated_ratios,
    is_lost_swing, refit,
};
use crate::records::Record;

/// A fit may be stuck if it leaves more than this share of the squares about the mean (both beyond the noise). A model
/// that lacks an effect stays below it (0.1 is a fit of 68 %); a model that has lost the phase does not.
const DOUBTFUL: f64 = 0.1;
/// Logs with fewer samples in all are fitted from the other starts, too, if they leave more than noise. A part of a
/// period has local minima in which a strong friction imitates the motion, and leaves little of it; so few samples take
/// little time.
const FEW_SAMPLES: usize = 1000;
/// Standard deviations by which the cost of a fit to so few samples may exceed that of noise.
const MORE_THAN_NOISE: f64 = 4.0;
/// Lengths, in samples, of the windows for the other starts, over which the equations of motion are integrated. In a
/// coarse log, quadrature errors accumulate over longer windows; in a dense log, shorter windows contain too little
/// motion.
const WINDOW_SAMPLES: [usize; 3] = [24, 64, 256];
/// Factors by which an inertia (or, if that is known, the torque that acts on it) is changed for the other starts. In a
/// coarse log, the neighbouring local minimum is an oscillation of twice or half the frequency.
const FACTORS: [f64; 2] = [0.4, 2.5];

/// Logs of a body that swings with fewer samples than this in all are fitted from a whole range of inertias. Their
/// noise cannot be told from their motion, so that no cost shows that a fit is stuck; and with two samples in a
/// period, the guess from the samples may be wrong by any factor.
const SPARSE_SAMPLES: usize = 60;
/// Largest factor by which the guess of a sparse log may be wrong, to either side.
const FARTHEST: f64 = 32.0;
/// Step from one start to the next, in the logarithm of the inertia. Over the shortest windows, 8 samples at two samples in a
/// period, the phase is then off by at most a tenth of a turn.
const STEP: f64 = 0.05;

/// Fits the base model to all records of a problem.
pub fn first_fit(problem: &FitProblem, effort: Effort) -> Minimum {
    let records = problem.all_records();
    let base = Model::base();
    let free = problem.free(&base);
    let shown = problem.start_values(&base);
    // Over the first windows, each with its own start, a model follows the motion if its parameters are about right,
    // even if it lacks an effect.
    let mut doubtful = true;
    let mut look =
        |records: &[&Record], minimum: &Minimum| doubtful = is_doubtful(records, minimum);
    let first = fit_in_stages(&records, &base, shown.clone(), &free, effort, &mut look);
    let is_sparse = is_sparse(&records);
    let is_good = !doubtful
        && first.cost.is_finite()
        && !is_short_and_misses(&records, &first)
        && !loses_a_swing(&records, &base, &first);
    if is_good && !is_sparse {
        return first;
    }
    let mut starts: Vec<Vec<f64>> = WINDOW_SAMPLES
        .iter()
        .map(|&samples| problem.values_from(&integrated_ratios(&records, samples), &base))
        .collect();
    for (inertia, torque) in [
        (TOTAL_INERTIA, GRAVITY_TORQUE),
        (WHEEL_INERTIA, TORQUE_CONSTANT),
    ] {
        let moved = [inertia, torque].into_iter().find(|at| free.contains(at));
        for (position, factor) in moved.into_iter().flat_map(|at| FACTORS.map(|f| (at, f))) {
            let mut values = shown.clone();
            values[position] *= factor;
            starts.push(values);
        }
    }
    if is_sparse {
        starts.extend(all_periods(&shown, &free));
    }
    let mut best = first;
    let mut is_rough = false;
    for values in starts {
        if (effort.cancelled)() {
            return best;
        }
        let look = Effort::ROUGH.until(effort.cancelled);
        let found = fit_from_scratch(&records, &base, values, &free, look);
        if found.cost < best.cost {
            best = found;
            is_rough = true;
        }
    }
    if is_rough {
        best = refit(&records, &base, best.values, best.windows, &free, effort);
    }
    best
}

/// Starts for every period within [`FARTHEST`] of that of `values`: another inertia of the body, or another gravity
/// torque if the inertia is known.
fn all_periods(values: &[f64], free: &[usize]) -> Vec<Vec<f64>> {
    let Some(moved) = period_parameter(free) else {
        return vec![];
    };
    let steps = (FARTHEST.ln() / STEP) as i32;
    let scaled = |step: i32| {
        let mut values = values.to_vec();
        values[moved] *= (f64::from(step) * STEP).exp();
        values
    };
    (-steps..=steps).map(scaled).collect()
}

/// The position of the free parameter that decides the period of the body.
fn period_parameter(free: &[usize]) -> Option<usize> {
    let mut body = [TOTAL_INERTIA, GRAVITY_TORQUE].into_iter();
    body.find(|at| free.contains(at))
}

/// Odds up to which two periods fit a sparse log equally well (3 in their logarithm, as between effects that tie).
const TIE: f64 = 3.0;
/// Smallest difference of two inertias, in their logarithm, that belong to different periods of a sparse log.
const OTHER_PERIOD: f64 = 0.1;

/// The position of the parameter that decides the period of the body, and another value of it with which sparse logs
/// are fitted as well as with that of this fit of the base model. The noise is unknown there: the evidence of a mean
/// square is its power −n/2, with n the number of rows.
pub(crate) fn other_period(problem: &FitProblem, fit: &Minimum) -> Option<(usize, f64)> {
    let records = problem.all_records();
    if !is_sparse(&records) {
        return None;
    }
    let base = Model::base();
    let free = problem.free(&base);
    let at = period_parameter(&free)?;
    let rows: usize = records.iter().map(|record| record.len()).sum();
    let limit = fit.cost * (2.0 * TIE / rows as f64).exp();
    all_periods(&fit.values, &free)
        .into_iter()
        .find_map(|values| {
            let found = fit_from_scratch(&records, &base, values, &free, Effort::ROUGH);
            let away = (found.values[at] / fit.values[at]).ln().abs();
            (found.cost < limit && away > OTHER_PERIOD).then_some((at, found.values[at]))
        })
}

/// Whether logs of a swinging body have next to no samples.
fn is_sparse(records: &[&Record]) -> bool {
    let swings = |record: &&&Record| matches!(record.kind, Kind::FreeSwing | Kind::Driven);
    let samples = records.iter().filter(swings).map(|record| record.len());
    (1..SPARSE_SAMPLES).contains(&samples.sum())
}

/// Whether a fit to few samples leaves more than noise. A χ² of n samples has mean n and variance 2 n.
fn is_short_and_misses(records: &[&Record], minimum: &Minimum) -> bool {
    let samples: usize = records.iter().map(|record| record.len()).sum();
    let observed: usize = records.iter().map(|record| record.observations()).sum();
    let noise = observed as f64;
    samples < FEW_SAMPLES && minimum.cost > noise + MORE_THAN_NOISE * (2.0 * noise).sqrt()
}

/// Whether a fit predicts a free swing no better than by its mean. In a sum over all logs, that may not show.
fn loses_a_swing(records: &[&Record], model: &Model, minimum: &Minimum) -> bool {
    (0..records.len()).any(|at| {
        let (one, windows) = (&records[at..=at], &minimum.windows[at..=at]);
        one[0].kind == Kind::FreeSwing
            && is_lost_swing(
                one[0],
                &windows[0],
                cost(one, model, &minimum.values, windows),
            )
    })
}

/// Whether the residual of a fit is so large that the fit may be stuck.
fn is_doubtful(records: &[&Record], minimum: &Minimum) -> bool {
    let noise: usize = records.iter().map(|record| record.observations()).sum();
    let means: f64 = records
        .iter()
        .zip(&minimum.windows)
        .map(|(record, windows)| cost_of_means(record, windows))
        .sum();
    let beyond = |cost: f64| (cost - noise as f64).max(0.0);
    !minimum.cost.is_finite() || beyond(minimum.cost) > DOUBTFUL * beyond(means)
}
