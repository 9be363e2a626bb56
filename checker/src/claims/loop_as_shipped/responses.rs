//! The largest effect of starts and inputs on each quantity of the loop, over all time.
//!
//! Inputs and start are carried forward as columns, v, F v, F² v, …. With weights W and ‖·‖ the
//! largest sum of a row's magnitudes, q = ‖W Fᵐ W⁻¹‖ < 1 for some m, and K = Σ_{i<m} ‖W Fⁱ W⁻¹‖. Then
//! Σ_j ‖W Fʲ W⁻¹‖ ≤ K/(1 − q), so that
//!
//! - after J steps all later terms of a row C together are at most ‖C W⁻¹‖₁ K/(1 − q) ‖W Fᴶ v‖;
//! - what rounding one step adds, at most δ in each entry, stays below δ K/(1 − q) in the weighted norm, whatever follows.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::claims::loop_as_shipped::NoBounds;
use crate::claims::loop_as_shipped::carried::{Carried, ROWS, ShortLoop};
use crate::claims::loop_as_shipped::layout::SquareGrid;
use crate::claims::loop_as_shipped::plant::{Loop, product};
use crate::exact::grid::{BITS, Grid, above, exactly, on_grid, times};
use crate::exact::rational::{integer, power_of_two, short_above};
use crate::exact::short::TooLarge;

/// Place of what the drive holds.
pub const HELD: usize = 3;
/// Place of its change.
pub const CHANGE: usize = 4;
/// Places of the accelerations.
pub const ACCELERATIONS: [usize; 2] = [5, 6];
/// Place of the current that the law asks for.
pub const ASKED: usize = 7;
/// Place of the estimated bias of the angle.
pub const ESTIMATE: usize = 8;

/// Longest m that is tried, as a power of two.
const DOUBLINGS: usize = 17;
/// Steps that are added up, in multiples of m: what is left then is q⁸ ≤ 2⁻¹⁶ of the start.
const LENGTHS: usize = 8;

/// Largest q.
fn largest_q() -> BigRational {
    power_of_two(-2)
}

/// Worst responses, for each row, all rounded up.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// Largest |C Fʲ e₁|: the largest value of each quantity after a start at rest at 1 rad. For the change of the held
    /// current, the largest value from the second step on.
    pub start: [BigRational; ROWS],
    /// The change of the held current in the first step, after a start at 1 rad.
    pub first_change: BigRational,
    /// Sums over all time of the responses to a current of 1 A, an acceleration of 1 rad/s² and a torque of 1 N m on
    /// the wheel.
    pub sums: [[BigRational; ROWS]; 3],
    /// Sums over all time of the responses to each input of one sample ([`Loop::readings`]).
    pub readings: Vec<[BigRational; ROWS]>,
    /// Largest response to errors of 1 rad before the start: of all readings in the window of an encoder on the pivot, or of
    /// the observer's state. Zero without either.
    pub before: [BigRational; ROWS],
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
        let steps = decay.m * LENGTHS;
        let too_large = |_: TooLarge| {
            NoBounds::NotShown("a response of the loop is too large for the argument".to_owned())
        };
        let short = ShortLoop::of(&model.f, &rows).map_err(too_large)?;
        let from_start = short
            .carry(&[model.layout.at_rest(&model.direct[0])], steps, 1)
            .map_err(too_large)?;
        let mut from_inputs: [Carried; 3] = Default::default();
        for (carried, columns) in from_inputs.iter_mut().zip(&model.inputs) {
            *carried = short.carry(columns, steps, 1).map_err(too_large)?;
        }
        let from_readings: Vec<Carried> = model
            .readings
            .iter()
            .map(|reading| short.carry(std::slice::from_ref(&reading.column), steps, 1))
            .collect::<Result<_, _>>()
            .map_err(too_large)?;
        let oldest = model.layout.before_start();
        let span = model.layout.angles().len().max(1);
        let before = short
            .carry(oldest.as_slice(), steps, span)
            .map_err(too_large)?;

        let weight = decay.weights.iter().max().cloned().unwrap_or_default();
        let norms: Vec<BigRational> = rows.iter().map(|row| decay.row_norm(row)).collect();
        let count = integer(steps as i128);
        // The computed `value` of this row, plus a bound of its errors: later steps and rounding.
        let settled = |index: usize, carried: &Carried, value: &BigRational| -> BigRational {
            let norm = &norms[index];
            let drift = &carried.off * &weight * &decay.total;
            let columns = integer(carried.last.len() as i128);
            let late: BigRational = carried.last.iter().map(|column| decay.size(column)).sum();
            short_above(
                value
                    + norm * (late + &drift * &columns) * &decay.total
                    + (norm * drift + &carried.off) * &count * columns,
            )
        };
        // The terms of the exponential that are not computed one by one.
        let beyond = |index: usize, input: usize| -> BigRational {
            &model.later[input] * &weight * &norms[index] * &decay.total
        };
        let most = |carried: &Carried, index: usize| -> BigRational {
            carried.first[index]
                .clone()
                .max(carried.peak[index].clone())
        };
        let start = |index: usize| -> BigRational {
            let value = match index {
                CHANGE => from_start.peak[CHANGE].clone(),
                _ => most(&from_start, index),
            };
            settled(index, &from_start, &value)
        };
        let t = &model.t;
        Ok(Responses {
            start: std::array::from_fn(start),
            first_change: settled(CHANGE, &from_start, &from_start.first[CHANGE]),
            sums: [0, 1, 2].map(|input| {
                let carried = &from_inputs[input];
                std::array::from_fn(|index| {
                    let sum = settled(index, carried, &carried.sum[index]);
                    short_above(t * (sum + beyond(index, input)))
                })
            }),
            before: std::array::from_fn(|index| settled(index, &before, &most(&before, index))),
            readings: from_readings
                .iter()
                .map(|carried| {
                    std::array::from_fn(|index| settled(index, carried, &carried.sum[index]))
                })
                .collect(),
            kick: std::array::from_fn(|index| {
                let carried = &from_inputs[0];
                short_above(t * (settled(index, carried, &most(carried, index)) + beyond(index, 0)))
            }),
        })
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
        on_the_grid(&model.estimate),
    ]
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
        // The weight of a state is its share of the command, which makes the states comparable.
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
            if q <= largest_q() {
                break;
            }
            matrix = product(&matrix, &matrix);
            m *= 2;
            q = norm(&matrix);
        }
        if q > largest_q() {
            return Err(NoBounds::NotShown(
                "the loop is not stable, or too slow for the argument".to_owned(),
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
            total: short_above(sum / (BigRational::one() - q)),
            weights,
            m,
        })
    }

    /// ‖W v‖.
    fn size(&self, column: &[BigRational]) -> BigRational {
        let weighted = self.weights.iter().zip(column);
        let sizes = weighted.map(|(weight, entry)| weight * entry.abs());
        sizes.max().unwrap_or_default()
    }

    /// ‖C W⁻¹‖₁.
    fn row_norm(&self, row: &[Grid]) -> BigRational {
        let entries = row.iter().zip(&self.weights);
        entries
            .map(|(entry, weight)| exactly(&entry.abs()) / weight)
            .sum()
    }
}

/// The weight of a state is its share of the held current, which makes the states comparable. The wheel's speed has the
/// weight of the speed that an encoder shows, and each turn has the weight of the turn over the window. The angles that
/// an encoder on the pivot showed have the weight of the oldest, and an observer's state its own share.
fn weights(model: &Loop) -> Vec<BigRational> {
    let share = |place: usize| model.held.get(place).map(Signed::abs).unwrap_or_default();
    let turns = model.layout.turns();
    let of_turn = share(turns.start);
    let speed = match turns.is_empty() {
        false => &of_turn * &model.t * integer(turns.len() as i128),
        true => share(2),
    };
    let mut weights = vec![share(0), share(1), speed, BigRational::one()];
    weights.resize(turns.end, of_turn);
    let order = model.layout.order();
    weights.resize(order, share(order - 1));
    for weight in weights.iter_mut().filter(|weight| weight.is_zero()) {
        *weight = BigRational::one();
    }
    weights
}
