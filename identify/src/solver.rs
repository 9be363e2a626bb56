//! Nonlinear least squares over parameters that all windows share and starts that each window has
//! for itself.
//!
//! Levenberg–Marquardt (Marquardt, SIAM J. 11 (1963); damping scaled by the diagonal as in Moré
//! 1978) on the normal equations. They have the shape of an arrow: every window couples its own
//! few unknowns with the shared ones and with nothing else. The windows' unknowns are eliminated by
//! Schur complements (the structure of bundle adjustment; Triggs et al. 2000, section 6), so that
//! the cost is linear in the number of windows.

use nalgebra::{Cholesky, DMatrix, DVector};
use plant::Model;
use rayon::prelude::*;

use crate::record::Record;
use crate::sensitivity::{
    Unknowns, Window, WindowNormal, moves_alike, normal, relevant, window_cost,
};

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The last step was far below what the data can resolve.
    Converged,
    /// No smaller cost could be found in any direction tried, or only crumbs for many steps.
    Stalled,
    /// The number of iterations ran out.
    OutOfIterations,
    /// Ended before its minimum: at its pace it would not have come to where it matters
    /// ([`Effort::goal`]).
    Outclassed,
    /// The model could not be simulated from the given start.
    NotFinite,
}

impl Outcome {
    /// Whether the result is a minimum.
    pub fn was_successful(self) -> bool {
        matches!(self, Outcome::Converged | Outcome::Stalled)
    }
}

/// The records of a fit with their windows, and where the minimisation stands.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The whole parameter vector.
    pub values: Vec<f64>,
    /// For each record its windows.
    pub windows: Vec<Vec<Window>>,
    /// Sum of squared normalised residuals.
    pub cost: f64,
    /// Information about the free parameters after the windows' unknowns are eliminated, in the
    /// fit's coordinates.
    pub information: DMatrix<f64>,
    /// Which free parameters lie on a bound, so that the data pull them out of their range.
    pub on_bound: Vec<bool>,
    /// How it ended.
    pub outcome: Outcome,
    /// Number of evaluations of the normal equations.
    pub evaluations: usize,
}

/// Steps of the minimisation.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Most evaluations of the normal equations.
    pub evaluations: usize,
    /// The minimisation ends when a step promises to lower the cost by less than this, relative to
    /// the mean squared residual: 1 is the change that one unknown's own standard error makes.
    pub tolerance: f64,
    /// The cost at which the fit begins to matter. One that would not come there with the evaluations
    /// that are left, at the pace of its last ones, ends.
    pub goal: f64,
}

impl Effort {
    /// The same for a fit that matters only if its cost comes down to `goal`.
    pub fn towards(self, goal: f64) -> Effort {
        Effort { goal, ..self }
    }

    /// To a hundredth of a standard error.
    pub const FULL: Effort = Effort {
        evaluations: 30,
        tolerance: 1e-4,
        goal: f64::INFINITY,
    };
    /// The same for a minimum at the end of a long curved valley (the speed of Stribeck's curve and
    /// its levels), which takes many short steps.
    pub const PATIENT: Effort = Effort {
        evaluations: 200,
        tolerance: 1e-4,
        goal: f64::INFINITY,
    };
    /// To a third of a standard error: which of several starts or models is better.
    pub const SCORE: Effort = Effort {
        evaluations: 30,
        tolerance: 1e-1,
        goal: f64::INFINITY,
    };
    /// Enough to hand over to the next stage of a schedule.
    pub const ROUGH: Effort = Effort {
        evaluations: 12,
        tolerance: 1e-1,
        goal: f64::INFINITY,
    };
}

/// A step that promises less than this, in units of the mean squared residual, and is refused ends the fit:
/// a tenth of a standard error is below what the kinks of dry friction leave of a smooth cost.
const ROUGHNESS: f64 = 1e-2;
/// For so many steps after a refused one the next is first tried without derivatives.
const DOUBTFUL: usize = 2;
/// Evaluations over which the pace of a fit is taken. A fit that goes straight to its minimum needs no
/// more than these, and one that has lost its way refuses up to six steps before it finds it again.
const PACE: usize = 8;
/// Steps whose gains make a series: where the damping has gone, least squares converge at least linearly.
const SERIES: usize = 3;
/// A fit whose last so many evaluations together gained less than the standard error of one unknown
/// would, or less than [`CRUMB`] of what the model misses, is creeping, and ends: what is left to gain
/// decides nothing.
const CREEPING: usize = 8;
/// Share of the χ² beyond the noise: of a model that misses much, the minimum need not be known to what
/// its noise would allow.
const CRUMB: f64 = 1e-2;

/// The cost that a fit may still come down to in so many more evaluations: at the pace of its last [`PACE`],
/// or as a geometric series where its last [`SERIES`] steps all gained, each less than the one before. `costs`
/// has one entry for every evaluation; a refused step repeats the one before it.
fn within_pace(costs: &[f64], evaluations: usize) -> f64 {
    let Some(&cost) = costs.last() else {
        return f64::NEG_INFINITY;
    };
    let back = |steps: usize| costs.len().checked_sub(1 + steps).map(|at| costs[at]);
    let at_pace = match back(PACE) {
        Some(before) => cost - (before - cost) * evaluations as f64 / PACE as f64,
        None => f64::NEG_INFINITY,
    };
    let mut ratio = 0.0f64;
    let mut gain = f64::NAN;
    for step in (0..SERIES).rev() {
        let (Some(before), Some(after)) = (back(step + 1), back(step)) else {
            return at_pace;
        };
        let next = before - after;
        if next <= 0.0 || next >= gain {
            return at_pace;
        }
        if gain.is_finite() {
            ratio = ratio.max(next / gain);
        }
        gain = next;
    }
    at_pace.max(cost - gain * ratio / (1.0 - ratio))
}

struct Assembled {
    windows: Vec<Vec<WindowNormal>>,
    cost: f64,
}

fn assemble(
    records: &[&Record],
    globals: &[Vec<usize>],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
) -> Assembled {
    let jobs: Vec<(usize, usize)> = windows
        .iter()
        .enumerate()
        .flat_map(|(record, list)| (0..list.len()).map(move |window| (record, window)))
        .collect();
    let results: Vec<WindowNormal> = jobs
        .par_iter()
        .map(|&(record, window)| {
            normal(
                records[record],
                &windows[record][window],
                model,
                values,
                unknowns,
                &globals[record],
            )
        })
        .collect();
    // Summed in a fixed order, so that the result does not depend on the number of processors.
    let cost = results.iter().map(|result| result.cost).sum();
    let mut results = results.into_iter();
    let windows = windows
        .iter()
        .map(|list| results.by_ref().take(list.len()).collect())
        .collect();
    Assembled { windows, cost }
}

/// The reduced system in the free parameters, and for each window what gives its own unknowns back.
struct Reduced {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    windows: Vec<Vec<Option<Eliminated>>>,
}

struct Eliminated {
    /// The window's unknowns that act, as indices into [`Window::locals`].
    locals: Vec<usize>,
    inverse: Cholesky<f64, nalgebra::Dyn>,
    coupling: DMatrix<f64>,
    gradient: DVector<f64>,
}

fn damped(matrix: &mut DMatrix<f64>, damping: f64) {
    for index in 0..matrix.nrows() {
        let diagonal = matrix[(index, index)];
        // An unknown without any trace stays where it is.
        matrix[(index, index)] = if diagonal > 0.0 {
            diagonal * (1.0 + damping)
        } else {
            1.0
        };
    }
}

fn reduce(assembled: &Assembled, globals: &[Vec<usize>], count: usize, damping: f64) -> Reduced {
    let mut whole = Reduced {
        matrix: DMatrix::zeros(count, count),
        gradient: DVector::zeros(count),
        windows: vec![],
    };
    for (list, globals) in assembled.windows.iter().zip(globals) {
        let part = reduce_record(list, globals, count, damping);
        whole.matrix += part.matrix;
        whole.gradient += part.gradient;
        whole.windows.push(part.windows);
    }
    whole
}

/// One record's share of the reduced system.
struct ReducedRecord {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    windows: Vec<Option<Eliminated>>,
}

fn reduce_record(
    list: &[WindowNormal],
    globals: &[usize],
    count: usize,
    damping: f64,
) -> ReducedRecord {
    let mut matrix = DMatrix::zeros(count, count);
    let mut gradient = DVector::zeros(count);
    let mut windows = vec![];
    for normal in list {
        let p = globals.len();
        let l = normal.gradient.len() - p;
        let mut own = normal.hessian.view((p, p), (l, l)).into_owned();
        // A tiny relative damping keeps a window whose unknowns its few samples cannot tell apart
        // from spoiling the whole.
        damped(&mut own, damping.max(1e-10));
        let coupling = normal.hessian.view((p, 0), (l, p)).into_owned();
        let own_gradient = normal.gradient.rows(p, l).into_owned();
        let eliminated = Cholesky::new(own).map(|inverse| Eliminated {
            locals: normal.locals.clone(),
            inverse,
            coupling,
            gradient: own_gradient,
        });
        let mut block = normal.hessian.view((0, 0), (p, p)).into_owned();
        let mut right = normal.gradient.rows(0, p).into_owned();
        for (row, &global) in globals.iter().enumerate() {
            matrix[(global, global)] += damping * block[(row, row)];
        }
        if let Some(eliminated) = &eliminated {
            block -=
                eliminated.coupling.transpose() * eliminated.inverse.solve(&eliminated.coupling);
            right -=
                eliminated.coupling.transpose() * eliminated.inverse.solve(&eliminated.gradient);
        }
        for (row, &to_row) in globals.iter().enumerate() {
            gradient[to_row] += right[row];
            for (column, &to_column) in globals.iter().enumerate() {
                matrix[(to_row, to_column)] += block[(row, column)];
            }
        }
        windows.push(eliminated);
    }
    ReducedRecord {
        matrix,
        gradient,
        windows,
    }
}

/// Solves the reduced system for the unknowns that are not held, scaled to a unit diagonal.
fn solve(matrix: &DMatrix<f64>, gradient: &DVector<f64>, held: &[bool]) -> Option<DVector<f64>> {
    let count = gradient.len();
    let scale = DVector::from_fn(count, |index, _| {
        let diagonal = matrix[(index, index)];
        if held[index] || diagonal <= 0.0 {
            0.0
        } else {
            1.0 / diagonal.sqrt()
        }
    });
    let scaled = DMatrix::from_fn(count, count, |row, column| {
        if row == column {
            1.0 + if scale[row] == 0.0 { 0.0 } else { 1e-13 }
        } else {
            matrix[(row, column)] * scale[row] * scale[column]
        }
    });
    let right = gradient.component_mul(&scale);
    Cholesky::new(scaled).map(|cholesky| cholesky.solve(&right).component_mul(&scale))
}

/// Minimises the sum of squared normalised residuals over the free parameters and the windows'
/// starts, from `values` and `windows`.
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
    let mut costs = vec![assembled.cost];
    let factors = factors(model);
    if !assembled.cost.is_finite() {
        outcome = Outcome::NotFinite;
    }
    while outcome == Outcome::OutOfIterations && evaluations < effort.evaluations {
        let mean_square = (assembled.cost / observations.max(1) as f64).max(1e-300);
        let reduced = reduce(&assembled, &globals, count, damping);
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
            // Of a product a b the step (da, db) promises the change b da + a db; b + a db/(a + da) brings
            // just that. With b + db the way of a fit from one cable to another that is as taut would lie
            // along a hyperbola, a curved valley of hundreds of steps.
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
                // More than a factor of e² at once leaves the range where the step means anything.
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
        // The windows' own steps belong to the step that is really taken.
        let mut next_windows = windows.clone();
        let mut promised = taken.dot(&reduced.gradient);
        for ((list, eliminated), globals) in
            next_windows.iter_mut().zip(&reduced.windows).zip(&globals)
        {
            let shared = DVector::from_fn(globals.len(), |row, _| taken[globals[row]]);
            for (window, eliminated) in list.iter_mut().zip(eliminated) {
                let Some(eliminated) = eliminated else {
                    continue;
                };
                let own = eliminated
                    .inverse
                    .solve(&(&eliminated.gradient - &eliminated.coupling * &shared));
                // What the window's own unknowns take beside the shared step, whose gradient is reduced by it.
                promised += eliminated
                    .gradient
                    .dot(&eliminated.inverse.solve(&eliminated.gradient));
                for (&local, change) in eliminated.locals.iter().zip(own.iter()) {
                    window.locals[local] += change;
                }
            }
        }
        // Among refusals a step is likely to be refused too: that costs no derivatives.
        let is_refused = since_refusal < DOUBTFUL
            && cost(records, model, &next_values, &next_windows) > assembled.cost;
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
        if let Some(next) = next.filter(|next| next.cost <= assembled.cost) {
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
        costs.push(assembled.cost);
        if outcome == Outcome::OutOfIterations
            && within_pace(&costs, effort.evaluations.saturating_sub(evaluations)) > effort.goal
        {
            outcome = Outcome::Outclassed;
        }
        if outcome == Outcome::OutOfIterations
            && costs.len() > CREEPING
            && costs[costs.len() - 1 - CREEPING] - assembled.cost
                < mean_square.max(CRUMB * (assembled.cost - observations as f64))
        {
            outcome = Outcome::Stalled;
        }
    }
    let reduced = reduce(&assembled, &globals, count, 0.0);
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

/// The cost that [`minimise`] lowers, without derivatives.
pub fn cost(records: &[&Record], model: &Model, values: &[f64], windows: &[Vec<Window>]) -> f64 {
    let jobs: Vec<(&Record, &Window)> = records
        .iter()
        .zip(windows)
        .flat_map(|(record, list)| list.iter().map(move |window| (*record, window)))
        .collect();
    let costs: Vec<f64> = jobs
        .par_iter()
        .map(|&(record, window)| window_cost(record, window, model, values))
        .collect();
    // In the order of the windows, so that it does not depend on how the work was shared out.
    costs.into_iter().sum()
}

/// For every position of the parameter vector the position of the factor a with which it forms a product
/// a b, in which the torque is linear ([`plant::EffectInfo::product`]).
fn factors(model: &Model) -> Vec<Option<usize>> {
    let mut factors = vec![None; model.parameter_count()];
    for &effect in model.effects() {
        if let (Some((a, b)), Some(at)) = (effect.info().product, model.position(effect)) {
            factors[at + b] = Some(at + a);
        }
    }
    factors
}

/// What a full Gauss–Newton step from a point promises, without taking it: the score test.
#[derive(Clone, Debug)]
pub struct Promise {
    /// For each record its share.
    pub records: Vec<RecordPromise>,
}

/// One record's share of a [`Promise`].
#[derive(Clone, Debug)]
pub struct RecordPromise {
    /// Cost at the point.
    pub cost: f64,
    /// Information on the free parameters (the windows' unknowns eliminated), in the fit's
    /// coordinates.
    pub information: DMatrix<f64>,
    /// Gradient, likewise.
    pub gradient: DVector<f64>,
    /// What the windows' own unknowns take from the cost while the free parameters stay.
    own_promise: f64,
}

/// A step that is promised.
#[derive(Clone, Debug)]
pub struct PromisedStep {
    /// Cost that the quadratic model promises after the step.
    pub cost: f64,
    /// The step of the free parameters, in the fit's coordinates; 0 for those that stay.
    pub step: DVector<f64>,
}

/// A model with parameters at a point whose promise is known.
#[derive(Clone, Copy)]
pub struct KnownPromise<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its parameter vector.
    pub values: &'a [f64],
    /// Its unknowns.
    pub unknowns: &'a Unknowns,
    /// What it promises.
    pub promise: &'a Promise,
    /// Whether what the other model has more does not come into play in a record.
    pub leaves_no_trace: &'a (dyn Fn(&Record) -> bool + Sync),
}

/// Evaluates the normal equations once. Records in which the model moves as one whose promise is
/// `known` (with the same windows) are not simulated again: those in which nothing acts that differs,
/// and those for which [`KnownPromise::leaves_no_trace`] says so.
pub fn promise(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: &[Vec<Window>],
    unknowns: &Unknowns,
    known: Option<KnownPromise>,
) -> Promise {
    let count = unknowns.free.len();
    let globals: Vec<Vec<usize>> = records
        .iter()
        .map(|record| relevant(record, model, unknowns))
        .collect();
    let is_known = |record: &Record| {
        known.is_some_and(|known| {
            moves_alike(record.kind, (known.model, known.values), (model, values))
                || (known.leaves_no_trace)(record)
        })
    };
    let simulated: Vec<Vec<Window>> = records
        .iter()
        .zip(windows)
        .map(|(record, list)| {
            if is_known(record) {
                vec![]
            } else {
                list.clone()
            }
        })
        .collect();
    let assembled = assemble(records, &globals, &simulated, model, values, unknowns);
    let infos = model.parameters();
    let records = assembled
        .windows
        .iter()
        .enumerate()
        .map(|(index, list)| match known {
            Some(known) if is_known(records[index]) => known.promise.records[index].reordered(
                known,
                |unknown| {
                    let name = known.model.parameters()[known.unknowns.free[unknown]].name;
                    unknowns.free.iter().position(|&at| infos[at].name == name)
                },
                count,
            ),
            _ => {
                let part = reduce_record(list, &globals[index], count, 0.0);
                let eliminated = part.windows.iter().flatten();
                RecordPromise {
                    cost: list.iter().map(|window| window.cost).sum(),
                    own_promise: eliminated
                        .map(|window| window.gradient.dot(&window.inverse.solve(&window.gradient)))
                        .sum(),
                    information: part.matrix,
                    gradient: part.gradient,
                }
            }
        })
        .collect();
    Promise { records }
}

impl RecordPromise {
    /// The same share among `count` unknowns of another model; `place` says where an unknown stands
    /// there.
    fn reordered(
        &self,
        known: KnownPromise,
        place: impl Fn(usize) -> Option<usize>,
        count: usize,
    ) -> RecordPromise {
        let places: Vec<Option<usize>> = (0..known.unknowns.free.len()).map(place).collect();
        let mut information = DMatrix::zeros(count, count);
        let mut gradient = DVector::zeros(count);
        for (row, to_row) in places.iter().enumerate() {
            let Some(to_row) = *to_row else { continue };
            gradient[to_row] = self.gradient[row];
            for (column, to_column) in places.iter().enumerate() {
                if let Some(to_column) = *to_column {
                    information[(to_row, to_column)] = self.information[(row, column)];
                }
            }
        }
        RecordPromise {
            cost: self.cost,
            information,
            gradient,
            own_promise: self.own_promise,
        }
    }
}

/// Share of the cost at a point by which rounding may put what a step promises below nothing.
const ROUNDING: f64 = 1e-6;

impl Promise {
    /// Cost at the point.
    pub fn cost(&self) -> f64 {
        self.records.iter().map(|record| record.cost).sum()
    }

    /// Information on the free parameters from all records.
    pub fn information(&self) -> DMatrix<f64> {
        self.records.iter().map(|record| &record.information).sum()
    }

    /// Gradient from all records.
    pub fn gradient(&self) -> DVector<f64> {
        self.records.iter().map(|record| &record.gradient).sum()
    }

    /// The step of those free parameters that `moves` marks, and what it promises; the others stay
    /// where they are, as in a model without them. Unknowns on a bound that would leave their range
    /// are held there.
    pub fn step(&self, values: &[f64], unknowns: &Unknowns, moves: &[bool]) -> PromisedStep {
        let count = unknowns.free.len();
        let total = self.information();
        let right = self.gradient();
        let own_promise: f64 = self.records.iter().map(|record| record.own_promise).sum();
        let mut held: Vec<bool> = moves.iter().map(|moves| !moves).collect();
        let mut promised = PromisedStep {
            cost: self.cost(),
            step: DVector::zeros(count),
        };
        // A step that leaves the range of an unknown is taken again with that unknown held.
        for _ in 0..3 {
            let Some(step) = solve(&total, &right, &held) else {
                break;
            };
            let cost = self.cost() - own_promise - step.dot(&right);
            if cost < -ROUNDING * self.cost() {
                // A sum of squares is not negative: the derivatives of a wild motion have drowned in their
                // own rounding, and promise nothing.
                break;
            }
            promised.cost = cost.max(0.0);
            promised.step.copy_from(&step);
            let mut changed = false;
            for (index, &position) in unknowns.free.iter().enumerate() {
                let (low, high) = unknowns.bounds[index];
                let next = values[position] + step[index];
                let beyond = (values[position] <= low && next < low)
                    || (values[position] >= high && next > high);
                if !unknowns.logarithmic[index] && beyond && !held[index] {
                    held[index] = true;
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        promised
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_of_gains_that_shrink_is_summed() {
        // 100 + 50 + 25 + … of which 175 are gained: 25 are left.
        assert_eq!(within_pace(&[300.0, 200.0, 150.0, 125.0], 20), 100.0);
        // A refused step, or one that gains more than the one before, says nothing yet.
        for costs in [[300.0, 200.0, 200.0, 150.0], [300.0, 280.0, 200.0, 150.0]] {
            assert_eq!(within_pace(&costs, 20), f64::NEG_INFINITY);
        }
        // Over eight evaluations the pace says how far twenty more may lead.
        let costs: Vec<f64> = (0..=8).map(|k| 1000.0 - 10.0 * f64::from(k)).collect();
        assert_eq!(within_pace(&costs, 20), 720.0);
    }
}
