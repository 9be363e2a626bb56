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
use crate::claims::loop_as_shipped::plant::{Loop, ORDER, PARTS, product};
use crate::exact::grid::{BITS, Grid, above, exactly, on_grid, times};
use crate::exact::rational::{half, integer, power_of_two};

/// The quantities: the three states, the command, its change since the last step, and the body's acceleration with the
/// current before and after the command.
pub const ROWS: usize = 7;
/// Place of the command.
pub const COMMAND: usize = 3;
/// Place of its change.
pub const CHANGE: usize = 4;
/// Places of the accelerations.
pub const ACCELERATIONS: [usize; 2] = [5, 6];

/// Longest m that is tried, as a power of two.
const DOUBLINGS: usize = 17;
/// Steps that are added up, in multiples of m.
const LENGTHS: usize = 16;

/// Worst responses, for each row, all rounded up.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Largest |C Fʲ e₁|: the largest value of each quantity after a start at rest at 1 rad. The same for the change of
    /// the command, from the second step on.
    pub start: [BigRational; ROWS],
    /// The change of the command in the first step, for a start at 1 rad.
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
        let mut columns: Vec<[Grid; ORDER]> = Vec::new();
        let one = BigInt::one() << BITS;
        columns.push([one, Grid::zero(), Grid::zero(), Grid::zero()]);
        for input in &model.inputs {
            for part in input {
                let [a, b, c] = part.clone();
                columns.push([a, b, c, Grid::zero()]);
            }
        }
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
        let one = BigInt::one() << BITS;
        let entries = rows.each_ref().map(|row| {
            let of_row = row.iter().enumerate();
            let nonzero = of_row.filter(|(_, entry)| !entry.is_zero());
            let entries = nonzero.map(|(i, entry)| (i, (*entry != one).then_some(entry)));
            entries.collect::<Vec<_>>()
        });
        for step in 0..steps {
            for (index, row) in entries.iter().enumerate() {
                let of = |column: &[Grid; ORDER]| -> Grid {
                    let mut sum = Grid::zero();
                    for (i, entry) in row {
                        match entry {
                            Some(entry) => sum += times(entry, &column[*i]),
                            None => sum += &column[*i],
                        }
                    }
                    sum.abs()
                };
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
                let next: [Grid; ORDER] = [0, 1, 2, 3]
                    .map(|i| (0..ORDER).map(|j| times(&model.f[i][j], &column[j])).sum());
                *column = next;
            }
        }
        let size = |column: &[Grid; ORDER]| -> BigRational {
            let weighted = (0..ORDER).map(|i| &decay.weights[i] * exactly(&column[i].abs()));
            weighted.max().unwrap_or_default()
        };
        // One step rounds a sum of four products of numbers below 2³⁰, with entries of F off by a unit.
        let off = power_of_two(40 - 144);
        let weight = decay.weights.iter().max().cloned().unwrap_or_default();
        let drift = &off * weight * &decay.total;
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
                let sizes = model.later[group - 1].iter().zip(&decay.weights);
                let size = sizes.map(|(entry, weight)| entry * weight).max();
                size.unwrap_or_default() * norm * &decay.total
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
fn rows(model: &Loop) -> [[Grid; ORDER]; ROWS] {
    let zero = Grid::zero;
    let one = || BigInt::one() << BITS;
    let gains = model.gains.each_ref().map(on_grid);
    let [_, fall, _] = &model.a;
    let push = &model.b[1];
    let [n1, n2, n3] = gains;
    let before = fall.each_ref().map(on_grid);
    let after: [Grid; 3] = [0, 1, 2].map(|i| on_grid(&(&fall[i] + push * &model.gains[i])));
    let [b1, b2, b3] = before;
    let [a1, a2, a3] = after;
    [
        [one(), zero(), zero(), zero()],
        [zero(), one(), zero(), zero()],
        [zero(), zero(), one(), zero()],
        [n1.clone(), n2.clone(), n3.clone(), zero()],
        [n1, n2, n3, -one()],
        [b1, b2, b3, on_grid(push)],
        [a1, a2, a3, zero()],
    ]
}

/// How fast everything dies away.
struct Decay {
    /// W.
    weights: [BigRational; ORDER],
    m: usize,
    /// K/(1 − q).
    total: BigRational,
}

impl Decay {
    fn of(model: &Loop) -> Result<Decay, NoBounds> {
        // A state's share of the command makes the states comparable.
        let mut weights: [BigRational; ORDER] = std::array::from_fn(|_| BigRational::one());
        for (weight, gain) in weights.iter_mut().zip(&model.gains) {
            if !gain.is_zero() {
                *weight = gain.abs();
            }
        }
        let norm = |matrix: &[[Grid; ORDER]; ORDER]| -> BigRational {
            let row = |i: usize| -> BigRational {
                (0..ORDER)
                    .map(|j| exactly(&matrix[i][j].abs()) * &weights[i] / &weights[j])
                    .sum()
            };
            // Far above what the grid rounds.
            let slack = BigRational::one() + power_of_two(-40);
            (0..ORDER).map(row).max().unwrap_or_default() * slack + power_of_two(-60)
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
                "with viscous friction alone and a delayed current the loop is not stable, or too slow"
                    .to_owned(),
            ));
        }
        let mut power: [[Grid; ORDER]; ORDER] = Default::default();
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
    fn row_norm(&self, row: &[Grid; ORDER]) -> BigRational {
        let shares = (0..ORDER).map(|i| exactly(&row[i].abs()) / &self.weights[i]);
        shares.sum()
    }
}
