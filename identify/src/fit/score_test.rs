//! The score test (Rao, Proc. Cambridge Phil. Soc. 44 (1948)): the gain that further parameters promise, from one
//! evaluation of the normal equations.

use nalgebra::{DMatrix, DVector};
use plant::Model;

use super::normal_equations::{UNDAMPED, assemble, reduce_record, solve};
use super::unknowns::{Unknowns, Window, moves_alike, relevant};
use crate::records::Record;

/// The normal equations at a point, from which the gain of a full Gauss–Newton step follows without taking it.
#[derive(Clone, Debug)]
pub struct ScoreTest {
    /// The share of each record.
    pub records: Vec<RecordScore>,
}

/// One record's share of a [`ScoreTest`].
#[derive(Clone, Debug)]
pub struct RecordScore {
    /// Cost (χ²) at the point.
    pub cost: f64,
    /// Information matrix of the free parameters, in the fit's coordinates, with the windows' nuisance parameters
    /// eliminated.
    pub information: DMatrix<f64>,
    /// Gradient, with the same elimination and coordinates.
    pub gradient: DVector<f64>,
    /// Gain from the windows' nuisance parameters alone, with the free parameters held.
    own_promise: f64,
}

/// A step, and the cost that it promises.
#[derive(Clone, Debug)]
pub struct ScoreStep {
    /// Cost that the quadratic model predicts after the step.
    pub cost: f64,
    /// The step of the free parameters, in the fit's coordinates; 0 for those that are held.
    pub step: DVector<f64>,
}

/// A point whose score test is known.
#[derive(Clone, Copy)]
pub struct KnownScore<'a> {
    /// The model.
    pub model: &'a Model,
    /// All its parameters, SI.
    pub values: &'a [f64],
    /// Its free parameters.
    pub unknowns: &'a Unknowns,
    /// Its score test.
    pub score_test: &'a ScoreTest,
    /// Whether the additional effects of the other model have no influence in a record.
    pub leaves_no_trace: &'a (dyn Fn(&Record) -> bool + Sync),
}

/// Evaluates the normal equations once. Some records need no new simulation, because the model moves there as the
/// `known` one does with the same windows: records in which no differing effect acts, and those for which
/// [`KnownScore::leaves_no_trace`] returns `true`.
pub fn score_test(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: &[Vec<Window>],
    unknowns: &Unknowns,
    known: Option<KnownScore>,
) -> ScoreTest {
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
            Some(known) if is_known(records[index]) => known.score_test.records[index].reordered(
                known,
                |unknown| {
                    let name = known.model.parameters()[known.unknowns.free[unknown]].name;
                    unknowns.free.iter().position(|&at| infos[at].name == name)
                },
                count,
            ),
            _ => {
                let part = reduce_record(list, &globals[index], count, &UNDAMPED);
                let eliminated = part.windows.iter().flatten();
                RecordScore {
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
    ScoreTest { records }
}

impl RecordScore {
    /// The same share, reordered for the `count` unknowns of another model; `place` maps an unknown's index.
    fn reordered(
        &self,
        known: KnownScore,
        place: impl Fn(usize) -> Option<usize>,
        count: usize,
    ) -> RecordScore {
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
        RecordScore {
            cost: self.cost,
            information,
            gradient,
            own_promise: self.own_promise,
        }
    }
}

/// Share of the cost at a point by which rounding may push a promised cost below zero.
const ROUNDING: f64 = 1e-6;

impl ScoreTest {
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

    /// The step of the free parameters that `moves` marks, and the cost that it promises. The others are held, as in a
    /// model without them. An unknown that would leave its range is held on its bound.
    pub fn step(&self, values: &[f64], unknowns: &Unknowns, moves: &[bool]) -> ScoreStep {
        let count = unknowns.free.len();
        let total = self.information();
        let right = self.gradient();
        let own_promise: f64 = self.records.iter().map(|record| record.own_promise).sum();
        let mut held: Vec<bool> = moves.iter().map(|moves| !moves).collect();
        let mut promised = ScoreStep {
            cost: self.cost(),
            step: DVector::zeros(count),
        };
        // If a step leaves the range of an unknown, the step is computed again with that unknown held.
        for _ in 0..3 {
            let Some(step) = solve(&total, &right, &held) else {
                break;
            };
            let cost = self.cost() - own_promise - step.dot(&right);
            if cost < -ROUNDING * self.cost() {
                // A sum of squares cannot be negative. The derivatives of a chaotic motion are dominated by rounding errors, and
                // their promise is void.
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
