//! Numbers with about 106 bits as unevaluated sums of two doubles, and small matrices of them.
//!
//! Sums after D. Knuth, products by a fused multiply-add (T. J. Dekker, "A floating-point technique
//! for extending the available precision", Numer. Math. 18, 1971). The relative error of an
//! operation is about 2⁻¹⁰⁴.

use nalgebra::DMatrix;

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// a + b, and its rounding error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

impl DoubleDouble {
    pub(crate) const ZERO: Self = Self::of(0.0);
    pub(crate) const ONE: Self = Self::of(1.0);

    pub(crate) const fn of(value: f64) -> Self {
        DoubleDouble { hi: value, lo: 0.0 }
    }

    pub(crate) fn to_f64(self) -> f64 {
        self.hi + self.lo
    }

    fn normal(hi: f64, lo: f64) -> Self {
        let (hi, lo) = two_sum(hi, lo);
        DoubleDouble { hi, lo }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        let (hi, lost) = two_sum(self.hi, other.hi);
        let (lo, rest) = two_sum(self.lo, other.lo);
        let first = Self::normal(hi, lost + lo);
        Self::normal(first.hi, first.lo + rest)
    }

    pub(crate) fn negated(self) -> Self {
        DoubleDouble {
            hi: -self.hi,
            lo: -self.lo,
        }
    }

    pub(crate) fn times(self, other: Self) -> Self {
        let product = self.hi * other.hi;
        let lost = self.hi.mul_add(other.hi, -product);
        Self::normal(product, lost + (self.hi * other.lo + self.lo * other.hi))
    }

    pub(crate) fn over(self, other: Self) -> Self {
        let first = self.hi / other.hi;
        let rest = self.plus(other.times(Self::of(first)).negated());
        let second = rest.hi / other.hi;
        let rest = rest.plus(other.times(Self::of(second)).negated());
        let third = rest.hi / other.hi;
        Self::normal(first, second).plus(Self::of(third))
    }
}

/// A small matrix, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Wide {
    rows: usize,
    columns: usize,
    entries: Vec<DoubleDouble>,
}

impl Wide {
    pub(crate) fn zeros(rows: usize, columns: usize) -> Wide {
        Wide {
            rows,
            columns,
            entries: vec![DoubleDouble::ZERO; rows * columns],
        }
    }

    pub(crate) fn identity(size: usize) -> Wide {
        let mut one = Wide::zeros(size, size);
        for index in 0..size {
            one.set(index, index, DoubleDouble::ONE);
        }
        one
    }

    pub(crate) fn of(matrix: &DMatrix<f64>) -> Wide {
        let mut wide = Wide::zeros(matrix.nrows(), matrix.ncols());
        for row in 0..matrix.nrows() {
            for column in 0..matrix.ncols() {
                wide.set(row, column, DoubleDouble::of(matrix[(row, column)]));
            }
        }
        wide
    }

    pub(crate) fn to_f64(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows, self.columns, |row, column| {
            self.at(row, column).to_f64()
        })
    }

    pub(crate) fn at(&self, row: usize, column: usize) -> DoubleDouble {
        self.entries[row * self.columns + column]
    }

    pub(crate) fn set(&mut self, row: usize, column: usize, value: DoubleDouble) {
        self.entries[row * self.columns + column] = value;
    }

    /// Inserts `block` with its first entry at `row`, `column`.
    pub(crate) fn put(&mut self, row: usize, column: usize, block: &Wide) {
        for i in 0..block.rows {
            for j in 0..block.columns {
                self.set(row + i, column + j, block.at(i, j));
            }
        }
    }

    /// The block of this size at `row`, `column`.
    pub(crate) fn block(&self, row: usize, column: usize, rows: usize, columns: usize) -> Wide {
        let mut block = Wide::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                block.set(i, j, self.at(row + i, column + j));
            }
        }
        block
    }

    fn map(&self, f: impl Fn(DoubleDouble) -> DoubleDouble) -> Wide {
        Wide {
            entries: self.entries.iter().map(|entry| f(*entry)).collect(),
            ..*self
        }
    }

    pub(crate) fn scaled(&self, factor: DoubleDouble) -> Wide {
        self.map(|entry| entry.times(factor))
    }

    pub(crate) fn negated(&self) -> Wide {
        self.map(DoubleDouble::negated)
    }

    pub(crate) fn plus(&self, other: &Wide) -> Wide {
        let pairs = self.entries.iter().zip(&other.entries);
        Wide {
            entries: pairs.map(|(a, b)| a.plus(*b)).collect(),
            ..*self
        }
    }

    pub(crate) fn minus(&self, other: &Wide) -> Wide {
        self.plus(&other.negated())
    }

    pub(crate) fn times(&self, other: &Wide) -> Wide {
        let mut product = Wide::zeros(self.rows, other.columns);
        for row in 0..self.rows {
            for column in 0..other.columns {
                let sum = (0..self.columns).fold(DoubleDouble::ZERO, |sum, k| {
                    sum.plus(self.at(row, k).times(other.at(k, column)))
                });
                product.set(row, column, sum);
            }
        }
        product
    }

    pub(crate) fn transposed(&self) -> Wide {
        let mut transposed = Wide::zeros(self.columns, self.rows);
        for row in 0..self.rows {
            for column in 0..self.columns {
                transposed.set(column, row, self.at(row, column));
            }
        }
        transposed
    }

    /// (M + Mᵀ)/2.
    pub(crate) fn symmetric(&self) -> Wide {
        self.plus(&self.transposed()).scaled(DoubleDouble::of(0.5))
    }

    /// The largest magnitude of an entry; NaN if an entry is not finite.
    pub(crate) fn largest(&self) -> f64 {
        self.entries.iter().fold(0.0, |most: f64, entry| {
            let size = entry.hi.abs();
            if size.is_finite() {
                most.max(size)
            } else {
                f64::NAN
            }
        })
    }

    /// X with M X = `right`, by elimination with row pivoting; `None` if M is singular.
    pub(crate) fn solve(&self, right: &Wide) -> Option<Wide> {
        let size = self.rows;
        let (mut m, mut x) = (self.clone(), right.clone());
        for pivot in 0..size {
            let best = (pivot..size).max_by(|a, b| {
                let size = |row: usize| m.at(row, pivot).hi.abs();
                size(*a).total_cmp(&size(*b))
            })?;
            let head = m.at(best, pivot);
            if head.hi == 0.0 || !head.hi.is_finite() {
                return None;
            }
            for matrix in [&mut m, &mut x] {
                for column in 0..matrix.columns {
                    let (upper, lower) = (matrix.at(pivot, column), matrix.at(best, column));
                    matrix.set(pivot, column, lower);
                    matrix.set(best, column, upper);
                }
            }
            for row in 0..size {
                if row == pivot {
                    continue;
                }
                let factor = m.at(row, pivot).over(head).negated();
                for matrix in [&mut m, &mut x] {
                    for column in 0..matrix.columns {
                        let sum = matrix.at(row, column);
                        let sum = sum.plus(factor.times(matrix.at(pivot, column)));
                        matrix.set(row, column, sum);
                    }
                }
            }
        }
        for row in 0..size {
            let head = m.at(row, row);
            for column in 0..x.columns {
                x.set(row, column, x.at(row, column).over(head));
            }
        }
        Some(x)
    }

    /// exp(M) by scaling, Taylor series and squaring; `None` where it overflows.
    pub(crate) fn exponential(&self) -> Option<Wide> {
        let norm = (0..self.columns)
            .map(|column| {
                (0..self.rows)
                    .map(|row| self.at(row, column).hi.abs())
                    .sum()
            })
            .fold(0.0, f64::max);
        // After 28 terms of a series for a norm of 1/8, the remainder is 2⁻⁸⁴/28! ≈ 2⁻¹⁸², far below the relative error
        // 2⁻¹⁰⁴ of one operation.
        let squarings = (norm * 8.0).log2().ceil().max(0.0);
        if squarings.is_nan() || squarings > 60.0 {
            return None;
        }
        let scaled = self.scaled(DoubleDouble::of(0.5_f64.powi(squarings as i32)));
        let mut term = Wide::identity(self.rows);
        let mut sum = term.clone();
        for order in 1..=28 {
            let share = DoubleDouble::ONE.over(DoubleDouble::of(f64::from(order)));
            term = term.times(&scaled).scaled(share);
            sum = sum.plus(&term);
        }
        for _ in 0..squarings as usize {
            sum = sum.times(&sum);
        }
        sum.largest().is_finite().then_some(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three times the computed 1/3 differs from 1 by at most 2⁻¹⁰⁴.
    #[test]
    fn a_third_has_twice_the_digits() {
        let third = DoubleDouble::ONE.over(DoubleDouble::of(3.0));
        let rest = third
            .times(DoubleDouble::of(3.0))
            .plus(DoubleDouble::ONE.negated());
        assert!(rest.to_f64().abs() < 2f64.powi(-103), "{rest:?}");
        assert_ne!(third.lo, 0.0);
    }

    /// The exponential of a rotation's generator is orthogonal, and has the entries of the rotation.
    #[test]
    fn the_exponential_of_a_skew_matrix_is_a_turn() {
        let angle = 1.25_f64;
        let skew = DMatrix::from_row_slice(2, 2, &[0.0, -angle, angle, 0.0]);
        let turn = Wide::of(&skew).exponential().unwrap();
        let back = turn.transposed().times(&turn).minus(&Wide::identity(2));
        assert!(back.largest() < 1e-30, "{:e}", back.largest());
        assert!((turn.at(0, 0).to_f64() - angle.cos()).abs() < 1e-16);
    }

    /// The Hilbert matrix of order 8, whose condition number is 1.5e10.
    #[test]
    fn an_ill_conditioned_system_is_solved() {
        let mut hilbert = Wide::zeros(8, 8);
        for row in 0..8 {
            for column in 0..8 {
                let entry = DoubleDouble::of((row + column + 1) as f64);
                hilbert.set(row, column, DoubleDouble::ONE.over(entry));
            }
        }
        let inverse = hilbert.solve(&Wide::identity(8)).unwrap();
        let rest = hilbert.times(&inverse).minus(&Wide::identity(8));
        assert!(rest.largest() < 1e-18, "{:e}", rest.largest());
    }
}
