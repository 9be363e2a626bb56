//! What a model would gain by further parameters, from one evaluation of its normal equations: the score test
//! (Rao, Proc. Cambridge Phil. Soc. 44 (1948)).

use nalgebra::{DMatrix, DVector};
use plant::Model;

use super::normal_equations::{assemble, reduce_record, solve};
use super::unknowns::{Unknowns, Window, moves_alike, relevant};
use crate::records::Record;

/// What a full Gauss–Newton step from a point promises, without taking it: the score test.
#[derive(Clone, Debug)]
pub struct ScoreTest {
    /// For each record its share.
    pub records: Vec<RecordScore>,
}

/// One record's share of a [`ScoreTest`].
#[derive(Clone, Debug)]
pub struct RecordScore {
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
pub struct ScoreStep {
    /// Cost that the quadratic model promises after the step.
    pub cost: f64,
    /// The step of the free parameters, in the fit's coordinates; 0 for those that stay.
    pub step: DVector<f64>,
}

/// A model with parameters at a point whose promise is known.
#[derive(Clone, Copy)]
pub struct KnownScore<'a> {
    /// The model.
    pub model: &'a Model,
    /// Its parameter vector.
    pub values: &'a [f64],
    /// Its unknowns.
    pub unknowns: &'a Unknowns,
    /// What it promises.
    pub score_test: &'a ScoreTest,
    /// Whether what the other model has more does not come into play in a record.
    pub leaves_no_trace: &'a (dyn Fn(&Record) -> bool + Sync),
}

/// Evaluates the normal equations once. Records in which the model moves as one whose promise is
/// `known` (with the same windows) are not simulated again: those in which nothing acts that differs,
/// and those for which [`KnownScore::leaves_no_trace`] says so.
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
                let part = reduce_record(list, &globals[index], count, 0.0);
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
    /// The same share among `count` unknowns of another model; `place` says where an unknown stands
    /// there.
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

/// Share of the cost at a point by which rounding may put what a step promises below nothing.
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

    /// The step of those free parameters that `moves` marks, and what it promises; the others stay
    /// where they are, as in a model without them. Unknowns on a bound that would leave their range
    /// are held there.
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
