//! The sums of [`crate::claims::closed_loop_for_all_time`]: the largest difference of two loops along one row, over all time.
//!
//! **Rounding of this computation.** C F̂ᵏ and C Fᵏ are kept in units of 2⁻¹⁹² and rounded down in
//! every step. Such an error of at most one unit per entry has ‖·‖* ≤ 2⁻¹⁹² √(Σ|P⁻¹ᵢⱼ|), and shrinks
//! by γ in each later step. All errors together are therefore bounded by a geometric series, which
//! is added.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::exact::matrices::{Matrix, Vector, quadratic};
use crate::exact::rational::{integer, power_of_two, root_above, rounded_up};

/// Bits after the point of the powers of F.
const BITS: usize = 192;

/// The data of the two loops for the worst difference of one row.
pub(crate) struct Response<'a> {
    pub exact: &'a Matrix,
    pub quantised: &'a Matrix,
    pub bd: &'a Vector,
    pub inverse: &'a Matrix,
    pub input_norm: BigRational,
    pub gamma: &'a BigRational,
    pub terms: u32,
}

/// Entries as integers over one denominator.
fn over_one(entries: &[BigRational]) -> (Vec<BigInt>, BigInt) {
    let mut common = BigInt::one();
    for entry in entries {
        common = common.lcm(entry.denom());
    }
    let whole = entries
        .iter()
        .map(|entry| entry.numer() * (&common / entry.denom()))
        .collect();
    (whole, common)
}

/// A matrix as integers over one denominator.
struct Scaled {
    /// Row by row.
    entries: Vec<BigInt>,
    denominator: BigInt,
}

impl Scaled {
    fn new(matrix: &Matrix) -> Self {
        let entries: Vec<BigRational> = matrix.iter().flatten().cloned().collect();
        let (entries, denominator) = over_one(&entries);
        Scaled {
            entries,
            denominator,
        }
    }

    /// row · matrix, rounded down.
    fn left(&self, row: &[BigInt; 3]) -> [BigInt; 3] {
        [0, 1, 2].map(|j| {
            let sum: BigInt = (0..3).map(|i| &row[i] * &self.entries[3 * i + j]).sum();
            sum.div_floor(&self.denominator)
        })
    }

    /// row · matrix · rowᵀ times the denominator.
    fn quadratic(&self, row: &[BigInt; 3]) -> BigInt {
        let mut sum = BigInt::zero();
        for i in 0..3 {
            for j in 0..3 {
                sum += &row[i] * &self.entries[3 * i + j] * &row[j];
            }
        }
        sum
    }
}

impl Response<'_> {
    /// For each V, the largest value of V S_k + G_k over all k, and a bound of the terms of S that are not added up.
    pub fn worst(
        &self,
        row: &Vector,
        noises: &[BigRational],
    ) -> Result<(Vec<BigRational>, BigRational), String> {
        if self.terms == 0 || self.terms > 1_000_000 {
            return Err(format!(
                "{} terms; between 1 and 1000000 are added up",
                self.terms
            ));
        }
        let unit = power_of_two(-(i32::try_from(BITS).unwrap_or(0)));
        let one = BigRational::one();
        let root =
            |value: &BigRational| root_above(value).ok_or_else(|| "a negative square".to_owned());
        let scaled_unit = |value: &BigRational| (value / &unit).ceil().to_integer();

        // ‖·‖* of the rounding errors of a row, at any time.
        let entries: BigRational = self.inverse.iter().flatten().map(Signed::abs).sum();
        let row_error = &unit * root(&entries)? * (&one + &one / (&one - self.gamma));
        let sum_error = scaled_unit(&(&row_error * &self.input_norm)) + 1;
        let difference_error = scaled_unit(&(&row_error * integer(2))) + 1;

        let (exact, quantised) = (Scaled::new(self.exact), Scaled::new(self.quantised));
        let inverse = Scaled::new(self.inverse);
        let (input, input_denominator) = over_one(self.bd);
        let levels: Vec<BigInt> = noises.iter().map(scaled_unit).collect();

        let start: [BigInt; 3] = [0, 1, 2].map(|i| (&row[i] / &unit).floor().to_integer());
        let (mut with_exact, mut with_quantised) = (start.clone(), start);
        let mut sum = BigInt::zero();
        let mut worst = vec![BigInt::zero(); levels.len()];
        let mut power = BigInt::one() << BITS;
        let gamma = scaled_unit(self.gamma);
        for _ in 0..self.terms {
            let response: BigInt = (0..3).map(|i| &with_quantised[i] * &input[i]).sum();
            sum += response.abs().div_ceil(&input_denominator) + &sum_error;
            with_exact = exact.left(&with_exact);
            with_quantised = quantised.left(&with_quantised);
            let difference = [0, 1, 2].map(|i| &with_quantised[i] - &with_exact[i]);
            let square = inverse
                .quadratic(&difference)
                .div_ceil(&inverse.denominator);
            let gain = square.sqrt() + 1 + &difference_error;
            for (level, worst) in levels.iter().zip(&mut worst) {
                let total = ((level * &sum) >> BITS) + 1 + &gain;
                if total > *worst {
                    *worst = total;
                }
            }
            power = ((power * &gamma) >> BITS) + 1;
        }
        let power = BigRational::from(power) * &unit;
        let reach = root(&quadratic(self.inverse, row))?;
        let rest = &reach * &self.input_norm * &power / (&one - self.gamma);
        let sum = BigRational::from(sum) * &unit + &rest;
        if &rest * integer(1000) > sum {
            return Err(format!(
                "{} terms leave {} of {} open; add up more",
                self.terms,
                rounded_up(&rest, 3),
                rounded_up(&sum, 3)
            ));
        }
        let late_gain = reach * integer(2) * power;
        let worst = worst
            .into_iter()
            .zip(noises)
            .map(|(worst, noise)| (BigRational::from(worst) * &unit).max(noise * &sum + &late_gain))
            .collect();
        Ok((worst, rest))
    }
}
