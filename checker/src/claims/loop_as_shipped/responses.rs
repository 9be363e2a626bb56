//! The largest effect of starts and inputs on each quantity of the loop, over all time.
//!
//! Inputs and start are carried forward as columns, v, F v, F² v, …, in units of 2⁻¹⁴⁴. With weights W and ‖·‖ the
//! largest sum of a row's magnitudes, q = ‖W Fᵐ W⁻¹‖ < 1 for some m, and K = Σ_{i<m} ‖W Fⁱ W⁻¹‖. Then
//! Σ_j ‖W Fʲ W⁻¹‖ ≤ K/(1 − q), so that
//!
//! - after J steps all later terms of a row C together are at most ‖C W⁻¹‖₁ K/(1 − q) ‖W Fᴶ v‖;
//! - what rounding one step adds, at most δ in each entry, stays below δ K/(1 − q) in the weighted norm, whatever follows.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::plant::{Loop, PARTS, SquareGrid, product};
use crate::exact::grid::{BITS, Grid, above, exactly, on_grid, times};
use crate::exact::rational::{half, integer, power_of_two};

/// The quantities: the three states, what the drive holds, its change since the last step, the body's acceleration with
/// what was held before and after the command, and the current that the law asks for.
pub const ROWS: usize = 8;
/// Place of what the drive holds.
pub const HELD: usize = 3;
/// Place of its change.
pub const CHANGE: usize = 4;
/// Places of the accelerations.
pub const ACCELERATIONS: [usize; 2] = [5, 6];
/// Place of the current that the law asks for.
pub const ASKED: usize = 7;

/// Longest m that is tried, as a power of two.
const DOUBLINGS: usize = 17;
/// Steps that are added up, in multiples of m.
const LENGTHS: usize = 16;

/// Worst responses, for each row, all rounded up.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Largest |C Fʲ e₁|: the largest value of each quantity after a start at rest at 1 rad. The same for the change of
    /// what the drive holds, from the second step on.
    pub start: [BigRational; ROWS],
    /// The change of what the drive holds in the first step, for a start at 1 rad.
    pub first_change: BigRational,
    /// Σ of what a current of 1 A, an acceleration of 1 rad/s² and a torque of 1 N m on the wheel do.
    pub sums: [[BigRational; ROWS]; 3],
    /// The largest of the terms of the current.
    pub kick: [BigRational; ROWS],
}

impl Responses {
    /// The responses of one loop.
    ///
    /// # Errors
    /// [`NoBounds::NotShown`] where the loop is not stable.
    pub fn of(model: &Loop) -> Result<Responses, NoBounds> {
        let decay = Decay::of(model)?;
        let rows = rows(model);
        let order = model.f.len();
        let mut tilted = vec![Grid::zero(); order];
        tilted[0] = BigInt::one() << BITS;
        let mut columns: Vec<Vec<Grid>> = vec![tilted];
        columns.extend(model.inputs.iter().flatten().cloned());
        let mut start: [Grid; ROWS] = Default::default();
        let mut first_change = Grid::zero();
        let mut sums: [[Grid; ROWS]; 3] = Default::default();
        let mut kick: [Grid; ROWS] = Default::default();
        let steps = decay.m * LENGTHS;
        // Nothing acts on the wheel in most models: then nothing of it is carried along.
        let is_acting = [true, true, !model.wheel_dry.is_zero()];
        if !is_acting[2] {
            columns.truncate(1 + 2 * PARTS);
        }
        let entries = rows.each_ref().map(|row| Sparse::of(row));
        let next: Vec<Sparse> = model.f.iter().map(|row| Sparse::of(row)).collect();
        for step in 0..steps {
            for (index, row) in entries.iter().enumerate() {
                let of = |column: &Vec<Grid>| -> Grid { row.times(column).abs() };
                let from_start = of(&columns[0]);
                if index == CHANGE && step == 0 {
                    first_change = from_start;
                } else if from_start > start[index] {
                    start[index] = from_start;
                }
                for input in (0..3).filter(|input| is_acting[*input]) {
                    let parts = &columns[1 + input * PARTS..1 + (input + 1) * PARTS];
                    let term: Grid = parts.iter().map(of).sum();
                    if input == 0 && term > kick[index] {
                        kick[index].clone_from(&term);
                    }
                    sums[input][index] += term;
                }
            }
            for column in &mut columns {
                *column = next.iter().map(|row| row.times(column)).collect();
            }
        }
        let size = |column: &Vec<Grid>| -> BigRational {
            let weighted = decay.weights.iter().zip(column);
            let sizes = weighted.map(|(weight, entry)| weight * exactly(&entry.abs()));
            sizes.max().unwrap_or_default()
        };
        // One step rounds a sum of at most twenty products of numbers below 2³⁰, with entries of F off by a unit.
        let off = power_of_two(40 - 144);
        let weight = decay.weights.iter().max().cloned().unwrap_or_default();
        let drift = &off * &weight * &decay.total;
        let norms: Vec<BigRational> = rows.iter().map(|row| decay.row_norm(row)).collect();
        let late: Vec<BigRational> = (0..4)
            .map(|group| {
                let own = match group {
                    0 => &columns[..1],
                    _ if !is_acting[group - 1] => &columns[..0],
                    _ => &columns[1 + (group - 1) * PARTS..1 + group * PARTS],
                };
                own.iter().map(size).sum::<BigRational>() + &drift
            })
            .collect();
        let count = integer(steps as i128);
        let parts = integer(PARTS as i128);
        let settled = |index: usize, group: usize, sum: &Grid| -> BigRational {
            let norm = &norms[index];
            // The terms of the exponential that are not kept apart.
            let beyond = if group == 0 {
                BigRational::zero()
            } else {
                &model.later[group - 1] * &weight * norm * &decay.total
            };
            exactly(sum)
                + norm * &late[group] * &decay.total
                + norm * &drift * &count * &parts
                + beyond
        };
        let peak = |index: usize, group: usize, value: &Grid| -> BigRational {
            settled(index, group, value)
        };
        let t = &model.t;
        let result = Responses {
            start: std::array::from_fn(|index| peak(index, 0, &start[index])),
            first_change: peak(CHANGE, 0, &first_change),
            sums: [0, 1, 2].map(|input| {
                std::array::from_fn(|index| t * settled(index, input + 1, &sums[input][index]))
            }),
            kick: std::array::from_fn(|index| t * peak(index, 1, &kick[index])),
        };
        Ok(result)
    }
}

/// The rows on the grid.
fn rows(model: &Loop) -> [Vec<Grid>; ROWS] {
    let order = model.f.len();
    let on_the_grid = |row: &[BigRational]| -> Vec<Grid> { row.iter().map(on_grid).collect() };
    let state = |place: usize| -> Vec<Grid> {
        let mut row = vec![Grid::zero(); order];
        row[place] = BigInt::one() << BITS;
        row
    };
    let push = &model.b[1];
    let mut before = model.a[1].to_vec();
    before.resize_with(order, BigRational::zero);
    let after: Vec<BigRational> = before
        .iter()
        .zip(&model.held)
        .map(|(fall, held)| fall + push * held)
        .collect();
    before[3] = push.clone();
    let held = on_the_grid(&model.held);
    let mut change = held.clone();
    change[3] -= BigInt::one() << BITS;
    [
        state(0),
        state(1),
        state(2),
        held,
        change,
        on_the_grid(&before),
        on_the_grid(&after),
        on_the_grid(&model.asked),
    ]
}

/// The entries of a row that are not zero, with their places; `None` for a one.
struct Sparse(Vec<(usize, Option<Grid>)>);

impl Sparse {
    fn of(row: &[Grid]) -> Sparse {
        let one = BigInt::one() << BITS;
        let entries = row.iter().enumerate();
        let entries = entries.filter(|(_, entry)| !entry.is_zero());
        Sparse(
            entries
                .map(|(place, entry)| (place, (*entry != one).then(|| entry.clone())))
                .collect(),
        )
    }

    fn times(&self, column: &[Grid]) -> Grid {
        let mut sum = Grid::zero();
        for (place, entry) in &self.0 {
            match entry {
                Some(entry) => sum += times(entry, &column[*place]),
                None => sum += &column[*place],
            }
        }
        sum
    }
}

/// How fast everything dies away.
struct Decay {
    /// W.
    weights: Vec<BigRational>,
    m: usize,
    /// K/(1 − q).
    total: BigRational,
}

impl Decay {
    fn of(model: &Loop) -> Result<Decay, NoBounds> {
        // A state's share of the command makes the states comparable.
        let weights = weights(model);
        let ratios: SquareGrid = weights
            .iter()
            .map(|own| weights.iter().map(|other| above(&(own / other))).collect())
            .collect();
        let norm = |matrix: &SquareGrid| -> BigRational {
            let rows = matrix.iter().zip(&ratios).map(|(row, ratios)| -> Grid {
                let entries = row.iter().zip(ratios);
                entries
                    .map(|(entry, ratio)| times(&entry.abs(), ratio))
                    .sum()
            });
            // Far above what the grid rounds.
            let slack = BigRational::one() + power_of_two(-40);
            exactly(&rows.max().unwrap_or_default()) * slack + power_of_two(-60)
        };
        let mut matrix = model.f.clone();
        let mut m = 1;
        let mut q = norm(&matrix);
        for _ in 0..DOUBLINGS {
            if q <= half() {
                break;
            }
            matrix = product(&matrix, &matrix);
            m *= 2;
            q = norm(&matrix);
        }
        if q > half() {
            return Err(NoBounds::NotShown(
                "with viscous friction alone and a delayed drive the loop is not stable, or too slow"
                    .to_owned(),
            ));
        }
        let mut power: SquareGrid = vec![vec![Grid::zero(); model.f.len()]; model.f.len()];
        for (i, row) in power.iter_mut().enumerate() {
            row[i] = BigInt::one() << BITS;
        }
        let mut sum = BigRational::zero();
        for _ in 0..m {
            // In few digits, so that the sum stays short.
            sum += exactly(&above(&norm(&power)));
            power = product(&power, &model.f);
        }
        Ok(Decay {
            total: sum / (BigRational::one() - q),
            weights,
            m,
        })
    }

    /// ‖C W⁻¹‖₁.
    fn row_norm(&self, row: &[Grid]) -> BigRational {
        let entries = row.iter().zip(&self.weights);
        entries
            .map(|(entry, weight)| exactly(&entry.abs()) / weight)
            .sum()
    }
}

/// A state's share of what the drive holds makes the states comparable. The wheel's speed counts as much as the speed that
/// an encoder shows, and each turn as the turn over the window.
fn weights(model: &Loop) -> Vec<BigRational> {
    let share = |place: usize| model.held.get(place).map(Signed::abs).unwrap_or_default();
    let order = model.f.len();
    let of_turn = share(4);
    let speed = match order > 4 {
        true => &of_turn * &model.t * integer(order as i128 - 4),
        false => share(2),
    };
    let mut weights = vec![share(0), share(1), speed, BigRational::one()];
    weights.resize(order, of_turn);
    for weight in weights.iter_mut().filter(|weight| weight.is_zero()) {
        *weight = BigRational::one();
    }
    weights
}
