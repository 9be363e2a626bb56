//! Columns carried through the loop step by step; their effects on each row are added up.
//!
//! Every column takes thousands of steps, so the numbers are short ones ([`Short`]). The columns are scaled to a
//! largest entry of about 1, and the sums are scaled back. With M the largest entry that occurs, and u = 2⁻⁹⁶, the
//! error of a sum of n products is n (1 + M) u at most: each product is rounded by u, and an entry of F or of a row has
//! an error of u itself.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::claims::loop_as_shipped::layout::SquareGrid;
use crate::exact::grid::{BITS, Grid};
use crate::exact::rational::{integer, power_of_two};
use crate::exact::short::{SHORT_BITS, Short, TooLarge};

/// The quantities: the three states, the held current, its change since the last step, the body's acceleration under
/// the current before and after the command, the current that the law requests, and the estimated bias of the angle.
pub const ROWS: usize = 9;

/// Number of bits that a number of the grid has beyond those of a short one.
const SHORTER: i64 = (BITS - SHORT_BITS) as i64;

/// Bits of the unit of a sum. Every term is rounded up to this unit, so that long sums have room.
const SUM_BITS: usize = 64;

/// The effect of some columns on every row over a number of steps. The values are as computed; [`Carried::off`] bounds
/// their error.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carried {
    /// The sum over the columns of |C v|, for each row C.
    pub first: [BigRational; ROWS],
    /// The largest of the same sums in later steps. Each value is a sum over the requested number of neighbouring
    /// steps.
    pub peak: [BigRational; ROWS],
    /// The sums of all steps together.
    pub sum: [BigRational; ROWS],
    /// The columns after the last step.
    pub last: Vec<Vec<BigRational>>,
    /// Largest amount that rounding adds to an entry in one step.
    pub off: BigRational,
}

/// A loop and its rows in short numbers.
pub(crate) struct ShortLoop {
    next: Vec<Sparse>,
    rows: [Sparse; ROWS],
    /// The largest entry of both.
    largest: Short,
}

impl ShortLoop {
    /// # Errors
    /// [`TooLarge`] for an entry of 2³¹ or more.
    pub(crate) fn of(f: &SquareGrid, rows: &[Vec<Grid>; ROWS]) -> Result<ShortLoop, TooLarge> {
        let next: Vec<Sparse> = f
            .iter()
            .map(|row| Sparse::of(row))
            .collect::<Result<_, _>>()?;
        let mut short_rows: [Sparse; ROWS] = Default::default();
        for (short, row) in short_rows.iter_mut().zip(rows) {
            *short = Sparse::of(row)?;
        }
        let all = next.iter().chain(&short_rows);
        let entries = all.flat_map(|row| row.0.iter().map(|(_, entry)| entry.abs()));
        Ok(ShortLoop {
            largest: entries.max().unwrap_or_default(),
            next,
            rows: short_rows,
        })
    }

    /// Carries the columns on for this number of steps. A peak is a sum over `span` neighbouring steps.
    ///
    /// # Errors
    /// [`TooLarge`] where something grows to 2³¹ times the largest entry of the columns.
    pub(crate) fn carry(
        &self,
        columns: &[Vec<Grid>],
        steps: usize,
        span: usize,
    ) -> Result<Carried, TooLarge> {
        let largest = columns.iter().flatten().map(Signed::abs).max();
        let largest = largest.unwrap_or_default();
        if largest.is_zero() {
            let last = columns
                .iter()
                .map(|column| vec![BigRational::zero(); column.len()]);
            return Ok(Carried {
                last: last.collect(),
                ..Carried::default()
            });
        }
        // The columns are these numbers times 2^scale.
        let scale = largest.bits() as i64 - BITS as i64;
        let shift = SHORTER + scale;
        let short = |entry: &Grid| -> Result<Short, TooLarge> {
            let units: BigInt = if shift < 0 {
                entry << shift.unsigned_abs()
            } else {
                entry >> shift.unsigned_abs()
            };
            Short::of_units(&units)
        };
        let mut now: Vec<Vec<Short>> = columns
            .iter()
            .map(|column| column.iter().map(short).collect())
            .collect::<Result<_, _>>()?;

        let mut largest = self.largest.max(Short::ONE);
        let mut first = [Short::ZERO; ROWS];
        let mut peak = [Short::ZERO; ROWS];
        let mut sum = [0_i128; ROWS];
        let mut recent = vec![[Short::ZERO; ROWS]; span];
        for step in 0..steps {
            for (index, row) in self.rows.iter().enumerate() {
                let mut term = Short::ZERO;
                for column in &now {
                    term = term.plus(row.times(column)?.abs())?;
                }
                recent[step % span][index] = term;
                if step == 0 {
                    first[index] = term;
                } else {
                    let mut together = Short::ZERO;
                    for terms in &recent {
                        together = together.plus(terms[index])?;
                    }
                    peak[index] = peak[index].max(together);
                }
                // Below 2⁹⁵ units, for fewer than 2³¹ steps.
                sum[index] += (term.units() >> (SHORT_BITS - SUM_BITS)) + 1;
            }
            for column in &mut now {
                let mut after = Vec::with_capacity(column.len());
                for row in &self.next {
                    after.push(row.times(column)?);
                }
                *column = after;
                largest = column
                    .iter()
                    .fold(largest, |most, entry| most.max(entry.abs()));
            }
        }
        let back = power_of_two(scale as i32);
        let exactly = |value: Short| value.exactly() * &back;
        let order = integer(self.next.len() as i128);
        let unit = power_of_two(-(SHORT_BITS as i32));
        Ok(Carried {
            first: first.map(exactly),
            peak: peak.map(exactly),
            sum: sum.map(|units| integer(units) * power_of_two(-(SUM_BITS as i32)) * &back),
            last: now
                .into_iter()
                .map(|column| column.into_iter().map(exactly).collect())
                .collect(),
            off: order * (integer(1) + largest.exactly()) * unit * &back,
        })
    }
}

/// The entries of a row that are not zero, with their places.
#[derive(Clone, Debug, Default)]
struct Sparse(Vec<(usize, Short)>);

impl Sparse {
    fn of(row: &[Grid]) -> Result<Sparse, TooLarge> {
        let entries = row.iter().enumerate();
        let entries = entries.filter(|(_, entry)| !entry.is_zero());
        let short = |(place, entry): (usize, &Grid)| {
            let units: BigInt = entry >> SHORTER;
            Ok((place, Short::of_units(&units)?))
        };
        Ok(Sparse(entries.map(short).collect::<Result<_, _>>()?))
    }

    fn times(&self, column: &[Short]) -> Result<Short, TooLarge> {
        let mut sum = Short::ZERO;
        for (place, entry) in &self.0 {
            let product = if *entry == Short::ONE {
                column[*place]
            } else {
                entry.times(column[*place])?
            };
            sum = sum.plus(product)?;
        }
        Ok(sum)
    }
}
