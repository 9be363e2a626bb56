//! The set of parameter vectors that identification allows, in coordinates in which it is a box or a ball.
//!
//! p = c + S L z, with the values c, the standard errors on the diagonal of S, and ρ² the 95 % quantile of χ² for as many
//! degrees of freedom as there are uncertain parameters.
//!
//! - **Correlations known.** L Lᵀ is at least their matrix R, as L = M √D with R + 10⁻⁸ = M D Mᵀ and roots rounded up.
//!   Then the 95 % ellipsoid (p − c)ᵀ (S R S)⁻¹ (p − c) ≤ ρ² lies in what the ball |z| ≤ ρ becomes. The 10⁻⁸ covers
//!   what rounding left of a matrix that a computation printed.
//! - **None known.** L = 1, and z lies in the box |zᵢ| ≤ ρ. It contains the 95 % ellipsoid whatever the correlations
//!   are: the ellipsoid's projection on an axis is that interval.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::certificate::reader::{Certificate, CertifiedCorrelation};
use crate::exact::rational::{decimal, integer, power, root_above, root_below};

/// 95 % quantiles of χ² for 1 to 7 degrees of freedom, rounded up in the third decimal.
const CHI_SQUARED_95: [&str; 7] = [
    "3.842", "5.992", "7.815", "9.488", "11.071", "12.592", "14.068",
];

/// An interval of each coordinate z.
pub(crate) type Part = Vec<(BigRational, BigRational)>;

/// The set.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Region {
    /// c.
    pub values: Vec<BigRational>,
    /// S L, row by row.
    pub directions: Vec<Vec<BigRational>>,
    /// Largest |p − c| of each parameter.
    pub radii: Vec<BigRational>,
    /// Whether correlations are known, so that z lies in a ball.
    pub is_ball: bool,
    /// ρ².
    quantile: BigRational,
    /// ρ, rounded up.
    factor: BigRational,
}

impl Region {
    /// The set for parameters of these names, values and standard errors; an error of zero is none.
    ///
    /// # Errors
    /// A sentence that says what the certificate states wrongly.
    pub fn of(
        certificate: &Certificate,
        names: &[&str],
        values: Vec<BigRational>,
        errors: &[BigRational],
    ) -> Result<Region, String> {
        let count = errors.iter().filter(|error| !error.is_zero()).count();
        let quantile = CHI_SQUARED_95
            .get(count.saturating_sub(1))
            .and_then(|text| decimal(text))
            .ok_or_else(|| format!("no quantile for {count} parameters"))?;
        let factor = root_above(&quantile).ok_or("a negative quantile")?;
        let factors = match &certificate.correlation {
            Some(stated) => factors(&correlations(stated, names)?)?,
            None => identity(names.len()),
        };
        let directions = factors
            .iter()
            .zip(errors)
            .map(|(row, error)| row.iter().map(|entry| entry * error).collect())
            .collect();
        Ok(Region {
            directions,
            radii: errors.iter().map(|error| error * &factor).collect(),
            is_ball: certificate.correlation.is_some(),
            values,
            quantile,
            factor,
        })
    }

    /// The box of all z. A coordinate that moves no parameter is zero.
    pub fn whole(&self) -> Part {
        let moves = |j: usize| self.directions.iter().any(|row| !row[j].is_zero());
        (0..self.values.len())
            .map(|j| match moves(j) {
                true => (-self.factor.clone(), self.factor.clone()),
                false => (BigRational::zero(), BigRational::zero()),
            })
            .collect()
    }

    /// Points of the set where a loop that is unstable at all mostly is so: the corners of the box, drawn in to the ball
    /// where the set is one.
    pub fn corners(&self) -> Vec<Vec<BigRational>> {
        let whole = self.whole();
        let moving: Vec<usize> = (0..whole.len())
            .filter(|j| !whole[*j].1.is_zero())
            .collect();
        let drawn_in = match self.is_ball && !moving.is_empty() {
            true => {
                // Half a thousandth for the ρ that is rounded up.
                let count = integer(moving.len() as i128);
                root_below(&count.recip()).unwrap_or_default()
                    * BigRational::new(999.into(), 1000.into())
            }
            false => BigRational::one(),
        };
        (0..1_usize << moving.len())
            .map(|corner| {
                let mut z = vec![BigRational::zero(); whole.len()];
                for (bit, j) in moving.iter().enumerate() {
                    let (low, high) = &whole[*j];
                    z[*j] = if corner >> bit & 1 == 0 { low } else { high } * &drawn_in;
                }
                z
            })
            .collect()
    }

    /// Whether a part lies beyond the ball.
    pub fn is_outside(&self, part: &Part) -> bool {
        let nearest: BigRational = part
            .iter()
            .map(|(low, high)| {
                let off = if low.is_positive() {
                    low.clone()
                } else if high.is_negative() {
                    high.clone()
                } else {
                    BigRational::zero()
                };
                &off * &off
            })
            .sum();
        self.is_ball && nearest > self.quantile
    }

    /// Whether z belongs to the set.
    pub fn holds(&self, z: &[BigRational]) -> bool {
        let square: BigRational = z.iter().map(|entry| entry * entry).sum();
        !self.is_ball || square <= self.quantile
    }

    /// The parameters at z.
    pub fn at(&self, z: &[BigRational]) -> Vec<BigRational> {
        let both = self.values.iter().zip(&self.directions);
        both.map(|(value, row)| {
            let moved: BigRational = row.iter().zip(z).map(|(x, y)| x * y).sum();
            value + moved
        })
        .collect()
    }
}

fn identity(count: usize) -> Vec<Vec<BigRational>> {
    (0..count)
        .map(|i| (0..count).map(|j| integer(i128::from(i == j))).collect())
        .collect()
}

/// R for these parameters; those that are not listed are independent.
fn correlations(
    stated: &CertifiedCorrelation,
    names: &[&str],
) -> Result<Vec<Vec<BigRational>>, String> {
    let count = stated.parameters.len();
    if stated.matrix.len() != count || stated.matrix.iter().any(|row| row.len() != count) {
        return Err("the matrix of correlations is not as large as its names are many".to_owned());
    }
    for (i, row) in stated.matrix.iter().enumerate() {
        for (j, entry) in row.iter().enumerate() {
            // As the reader of model.toml allows it.
            let off = &entry.value - &stated.matrix[j][i].value;
            let is_one = (&entry.value - BigRational::one()).abs() <= power(10, -9);
            if off.abs() > power(10, -9)
                || (i == j && !is_one)
                || entry.value.abs() > integer(1) + power(10, -9)
            {
                return Err(format!(
                    "the correlation of {} and {} is no correlation",
                    stated.parameters[i], stated.parameters[j]
                ));
            }
        }
    }
    let place = |name: &str| stated.parameters.iter().position(|known| known == name);
    let mut found = identity(names.len());
    for (i, a) in names.iter().enumerate() {
        for (j, b) in names.iter().enumerate().filter(|(j, _)| *j != i) {
            if let (Some(row), Some(column)) = (place(a), place(b)) {
                // The same for both orders.
                let (row, column) = (row.max(column), row.min(column));
                found[i][j].clone_from(&stated.matrix[row][column].value);
            }
        }
    }
    Ok(found)
}

/// L, lower triangular, with L Lᵀ ≥ R.
fn factors(r: &[Vec<BigRational>]) -> Result<Vec<Vec<BigRational>>, String> {
    let count = r.len();
    let mut rest: Vec<Vec<BigRational>> = r.to_vec();
    for (i, row) in rest.iter_mut().enumerate() {
        row[i] += power(10, -8);
    }
    let mut found = vec![vec![BigRational::zero(); count]; count];
    for k in 0..count {
        let pivot = rest[k][k].clone();
        if !pivot.is_positive() {
            return Err(
                "the correlations are those of no errors: a variance would be negative".to_owned(),
            );
        }
        let root = root_above(&pivot).ok_or("a negative square")?;
        let column: Vec<BigRational> = (0..count).map(|i| &rest[i][k] / &pivot).collect();
        for i in k..count {
            found[i][k] = &column[i] * &root;
            for j in k..count {
                let taken = &column[i] * &column[j] * &pivot;
                rest[i][j] -= taken;
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// L Lᵀ is R + 10⁻⁸, up to roots that are rounded up; what is no matrix of correlations is refused.
    #[test]
    fn the_factors_of_correlations() {
        let d = |text: &str| decimal(text).unwrap();
        let r = [
            ["1", "0.98", "-0.5"],
            ["0.98", "1", "-0.55"],
            ["-0.5", "-0.55", "1"],
        ];
        let r: Vec<Vec<BigRational>> = r.iter().map(|row| row.map(d).to_vec()).collect();
        let l = factors(&r).unwrap();
        for i in 0..3 {
            for j in 0..3 {
                let product: BigRational = (0..3).map(|k| &l[i][k] * &l[j][k]).sum();
                let off = product - &r[i][j];
                let added = if i == j { power(10, -8) } else { integer(0) };
                assert!((off - added).abs() < power(10, -15), "{i} {j}");
            }
        }
        let mut impossible = r;
        impossible[0][2] = d("0.5");
        impossible[2][0] = d("0.5");
        assert!(factors(&impossible).is_err());
    }
}
