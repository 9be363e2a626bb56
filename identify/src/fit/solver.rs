//! Nonlinear least squares over parameters that all windows share and nuisance parameters of each window, such as
//! its start.
//!
//! Levenberg–Marquardt (Marquardt, SIAM J. 11 (1963); damping scaled by the diagonal as in Moré
//! 1978) on the [`super::normal_equations`].

use nalgebra::{DMatrix, DVector};
use parallel::parallel_map;
use plant::{GRAVITY_TORQUE, Model, TORQUE_CONSTANT, TOTAL_INERTIA, WHEEL_INERTIA};

use super::effort::{Effort, Outcome, within_pace};
use super::normal_equations::{Damping, UNDAMPED, assemble, reduce, solve};
use super::sensitivity::window_cost;
use super::unknowns::{Nuisance, Unknowns, Window, is_of_wheel, relevant};
use crate::learned::penalty_of;
use crate::records::Record;

/// The result of a minimisation.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// All parameters, SI.
    pub values: Vec<f64>,
    /// The windows of each record.
    pub windows: Vec<Vec<Window>>,
    /// Sum of squared normalised residuals (χ²).
    pub cost: f64,
    /// Information about the free parameters after the windows' unknowns are eliminated, in the
    /// fit's coordinates; with what is known beforehand of learned curves.
    pub information: DMatrix<f64>,
    /// Which free parameters lie on a bound of their range, where the data pull them outwards.
    pub on_bound: Vec<bool>,
    /// The reason why the minimisation ended.
    pub outcome: Outcome,
    /// Number of evaluations of the normal equations.
    pub evaluations: usize,
}

/// The fit ends if a refused step promised less than this, in units of the mean squared residual. A tenth of a
/// standard error is below the roughness that the kinks of dry friction give the cost.
const ROUGHNESS: f64 = 1e-2;
/// For this many steps after a refused one, the next step is first tried without derivatives.
const DOUBTFUL: usize = 2;
/// Number of evaluations after which a slow fit ends: if together they gained less than one unknown's standard error
/// is worth, or less than [`CRUMB`] of the misfit. The remaining gain would not change a decision.
const CREEPING: usize = 8;
/// Share of the χ² beyond the noise. A model that misses much needs its minimum less precisely than its noise
/// would allow.
const CRUMB: f64 = 1e-2;

/// Minimises the sum of squared normalised residuals over the free parameters and the windows'
/// starts, from `values` and `windows`. What is known beforehand of learned curves
/// ([`plant::LearnedCurve::penalty`]) counts beside it, but is no part of the cost that is told.
pub fn minimise(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    windows: Vec<Vec<Window>>,
    unknowns: &Unknowns,
    effort: Effort,
) -> Minimum {
    let count = unknowns.free.len();
    let globals: Vec<Vec<usize>> = records
        .iter()
        .map(|record| relevant(record, model, unknowns))
        .collect();
    let observations: usize = records.iter().map(|record| record.observations()).sum();

    let mut values = values;
    let mut windows = windows;
    let mut assembled = assemble(records, &globals, &windows, model, &values, unknowns);
    let mut evaluations = 1;
    let mut damping = 1e-4;
    let mut since_refusal = DOUBTFUL;
    let mut outcome = Outcome::OutOfIterations;
    let mut on_bound = vec![false; count];
    let penalty = penalty_of(model, unknowns);
    let of_unknowns = |values: &[f64]| {
        DVector::from_iterator(
            count,
            unknowns.free.iter().map(|&position| values[position]),
        )
    };
    let beforehand = |values: &[f64]| -> f64 {
        penalty.as_ref().map_or(0.0, |penalty| {
            let own = of_unknowns(values);
            own.dot(&(penalty * &own))
        })
    };
    let mut costs = vec![assembled.cost + beforehand(&values)];
    let factors = factors(model);
    let inertias = inertias(model, unknowns);
    if !assembled.cost.is_finite() {
        outcome = Outcome::NotFinite;
    }
    while outcome == Outcome::OutOfIterations && evaluations < effort.evaluations {
        if (effort.cancelled)() {
            outcome = Outcome::Cancelled;
            break;
        }
        let mean_square = (assembled.cost / observations.max(1) as f64).max(1e-300);
        let ratios = ratios(&inertias, unknowns, &values);
        let damped = Damping {
            share: damping,
            ratios: &ratios,
        };
        let mut reduced = reduce(&assembled, &globals, count, &damped);
        if let Some(penalty) = &penalty {
            reduced.gradient -= penalty * of_unknowns(&values);
            reduced.matrix += penalty;
        }
        // An unknown on its bound is held there while the data pull it outwards.
        for (index, held) in on_bound.iter_mut().enumerate() {
            let value = values[unknowns.free[index]];
            let (low, high) = unknowns.bounds[index];
            let pull = reduced.gradient[index];
            *held = (value <= low && pull < 0.0) || (value >= high && pull > 0.0);
        }
        let Some(step) = solve(&reduced.matrix, &reduced.gradient, &on_bound) else {
            damping = (damping * 100.0).max(1e-6);
            if damping > 1e12 {
                outcome = Outcome::Stalled;
            }
            continue;
        };

        let mut next_values = values.clone();
        let mut taken = step.clone();
        for (index, &position) in unknowns.free.iter().enumerate() {
            let (low, high) = unknowns.bounds[index];
            // In a product a b, the step (da, db) promises the change b da + a db. The value b + a db/(a + da) gives exactly
            // that change. With b + db, the path between two equally taut cables would follow a hyperbola, a curved valley of
            // hundreds of steps.
            if let Some(factor) = factors[position]
                && next_values[factor] > 0.0
            {
                let share = values[factor] / next_values[factor];
                let next = values[position] + share * step[index];
                next_values[position] = next.clamp(low, high);
                if share > 0.0 {
                    taken[index] = (next_values[position] - values[position]) / share;
                }
                continue;
            }
            let next = if unknowns.logarithmic[index] {
                // A change by more than a factor of e² leaves the range in which the linearised step is valid.
                values[position] * step[index].clamp(-2.0, 2.0).exp()
            } else {
                values[position] + step[index]
            };
            next_values[position] = next.clamp(low, high);
            taken[index] = if unknowns.logarithmic[index] {
                (next_values[position] / values[position]).ln()
            } else {
                next_values[position] - values[position]
            };
        }
        // The windows' own steps follow from the step that is really taken.
        let mut next_windows = windows.clone();
        let mut promised = taken.dot(&reduced.gradient);
        for (((list, eliminated), globals), record) in next_windows
            .iter_mut()
            .zip(&reduced.windows)
            .zip(&globals)
            .zip(records)
        {
            let kinds = Nuisance::of(record);
            let shared = DVector::from_fn(globals.len(), |row, _| taken[globals[row]]);
            for (window, eliminated) in list.iter_mut().zip(eliminated) {
                let Some(eliminated) = eliminated else {
                    continue;
                };
                let own = eliminated
                    .inverse
                    .solve(&(&eliminated.gradient - &eliminated.coupling * &shared));
                // The gain from the windows' nuisance parameters, in addition to the gain of the shared step.
                promised += eliminated
                    .gradient
                    .dot(&eliminated.inverse.solve(&eliminated.gradient));
                for (&local, change) in eliminated.nuisances.iter().zip(own.iter()) {
                    let value = window.nuisances[local] + change;
                    let most = kinds[local].most();
                    window.nuisances[local] = value.clamp(-most, most);
                }
            }
        }
        // Among refusals a step is likely to be refused too: that costs no derivatives.
        let (before, after) = (beforehand(&values), beforehand(&next_values));
        let is_refused = since_refusal < DOUBTFUL
            && cost(records, model, &next_values, &next_windows) + after > assembled.cost + before;
        let next = (!is_refused).then(|| {
            assemble(
                records,
                &globals,
                &next_windows,
                model,
                &next_values,
                unknowns,
            )
        });
        evaluations += 1;
        let small = promised.abs() <= effort.tolerance * mean_square;
        since_refusal += 1;
        if let Some(next) = next.filter(|next| next.cost + after <= assembled.cost + before) {
            values = next_values;
            windows = next_windows;
            assembled = next;
            damping = (damping * 0.1).max(1e-12);
            if small {
                outcome = Outcome::Converged;
            }
        } else if promised.abs() <= ROUGHNESS.max(effort.tolerance) * mean_square {
            outcome = Outcome::Converged;
        } else {
            since_refusal = 0;
            damping = (damping * 10.0).max(1e-6);
            if damping > 1e10 {
                outcome = Outcome::Stalled;
            }
        }
        let objective = assembled.cost + beforehand(&values);
        costs.push(objective);
        if outcome == Outcome::OutOfIterations
            && within_pace(&costs, effort.evaluations.saturating_sub(evaluations)) > effort.goal
        {
            outcome = Outcome::Outclassed;
        }
        if outcome == Outcome::OutOfIterations
            && costs.len() > CREEPING
            && costs[costs.len() - 1 - CREEPING] - objective
                < mean_square.max(CRUMB * (assembled.cost - observations as f64))
        {
            outcome = Outcome::Stalled;
        }
    }
    let mut reduced = reduce(&assembled, &globals, count, &UNDAMPED);
    if let Some(penalty) = &penalty {
        reduced.matrix += penalty;
    }
    Minimum {
        values,
        windows,
        cost: assembled.cost,
        information: reduced.matrix,
        on_bound,
        outcome,
        evaluations,
    }
}

/// The cost that [`minimise`] lowers, computed without derivatives.
pub fn cost(records: &[&Record], model: &Model, values: &[f64], windows: &[Vec<Window>]) -> f64 {
    let jobs = records
        .iter()
        .zip(windows)
        .flat_map(|(record, list)| list.iter().map(move |window| (*record, window)));
    let costs = parallel_map(jobs, |(record, window)| {
        window_cost(record, window, model, values)
    });
    // Summed in the order of the windows, so that the result does not depend on the number of threads.
    costs.into_iter().sum()
}

/// For every free torque of `model`: the free inertia that it accelerates, as unknowns.
fn inertias(model: &Model, unknowns: &Unknowns) -> Vec<Option<usize>> {
    let infos = model.parameters();
    let of = |&position: &usize| {
        let inertia = match position {
            TOTAL_INERTIA | WHEEL_INERTIA => return None,
            GRAVITY_TORQUE => TOTAL_INERTIA,
            TORQUE_CONSTANT => WHEEL_INERTIA,
            _ if model.effect_at(position).is_some_and(is_of_wheel) => WHEEL_INERTIA,
            _ => TOTAL_INERTIA,
        };
        let at = unknowns.free.iter().position(|&free| free == inertia)?;
        infos[position].is_torque.then_some(at)
    };
    unknowns.free.iter().map(of).collect()
}

/// The inertia of every free torque, and the change of the torque that keeps their ratio while the inertia changes by
/// one, both in the fit's coordinates ([`Damping::ratios`]).
fn ratios(
    inertias: &[Option<usize>],
    unknowns: &Unknowns,
    values: &[f64],
) -> Vec<Option<(usize, f64)>> {
    // The relative change of a value is the change of its coordinate times this.
    let relative = |unknown: usize| {
        let value = values[unknowns.free[unknown]];
        unknowns.slope(unknown, value) / value
    };
    let of = |(torque, inertia): (usize, &Option<usize>)| {
        let inertia = (*inertia)?;
        Some((inertia, relative(inertia) / relative(torque)))
            .filter(|(_, change)| change.is_finite())
    };
    inertias.iter().enumerate().map(of).collect()
}

/// For every parameter b in whose product a b with another parameter a the torque is linear: the position of a
/// ([`plant::EffectInfo::product`]); `None` for all others.
fn factors(model: &Model) -> Vec<Option<usize>> {
    let mut factors = vec![None; model.parameter_count()];
    for &effect in model.effects() {
        if let (Some((a, b)), Some(at)) = (effect.info().product, model.position(effect)) {
            factors[at + b] = Some(at + a);
        }
    }
    factors
}
