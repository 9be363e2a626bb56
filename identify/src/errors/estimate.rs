//! A minimum with the standard errors of its parameters.

use nalgebra::{DMatrix, SymmetricEigen};
use plant::Model;

use super::covariance::covariance;
use crate::fit::{Minimum, Unknowns};
use crate::records::Record;

/// A model fitted to records.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Which effects the model has.
    pub model: Model,
    /// All its parameters, SI.
    pub values: Vec<f64>,
    /// Which of them were free.
    pub unknowns: Unknowns,
    /// The minimum that was found.
    pub minimum: Minimum,
    /// Covariance of the free parameters, in their own units; `None` if the data do not determine some combination of
    /// them.
    pub covariance: Option<DMatrix<f64>>,
}

impl Fit {
    /// Standard error of the parameter at this position; `None` if it was not free or is not determined.
    pub fn std(&self, position: usize) -> Option<f64> {
        let index = self.unknowns.free.iter().position(|&at| at == position)?;
        let variance = self.covariance.as_ref()?[(index, index)];
        (variance > 0.0).then(|| variance.sqrt())
    }

    /// The positions of the parameters that have a standard error, and the correlation matrix of their errors in that
    /// order: symmetric, ones on the diagonal, no negative eigenvalue. `None` if fewer than two have one.
    pub fn correlation(&self) -> Option<(Vec<usize>, DMatrix<f64>)> {
        let covariance = self.covariance.as_ref()?;
        let (indices, stds): (Vec<usize>, Vec<f64>) = (0..self.unknowns.free.len())
            .filter_map(|index| Some((index, self.std(self.unknowns.free[index])?)))
            .unzip();
        let count = indices.len();
        if count < 2 {
            return None;
        }
        let scaled = DMatrix::from_fn(count, count, |row, column| {
            let (a, b) = (indices[row], indices[column]);
            0.5 * (covariance[(a, b)] + covariance[(b, a)]) / (stds[row] * stds[column])
        });
        // A strong correlation is a difference of large numbers. Rounding can leave an eigenvalue slightly
        // below zero; it is set to zero.
        let mut eigen = SymmetricEigen::new(scaled);
        eigen.eigenvalues.apply(|value| *value = value.max(0.0));
        let possible = eigen.recompose();
        let matrix = DMatrix::from_fn(count, count, |row, column| {
            let (a, b) = (row.min(column), row.max(column));
            let scale = (possible[(a, a)] * possible[(b, b)]).sqrt();
            if a == b {
                1.0
            } else {
                possible[(a, b)] / scale
            }
        });
        let positions = indices.iter().map(|&index| self.unknowns.free[index]);
        Some((positions.collect(), matrix))
    }
}

/// Computes the standard errors of a minimum.
pub fn finish(records: &[&Record], model: &Model, free: &[usize], minimum: Minimum) -> Fit {
    let unknowns = Unknowns::new(model, free);
    let covariance = covariance(
        records,
        &minimum.windows,
        model,
        &minimum.values,
        &unknowns,
        &minimum.information,
        &minimum.on_bound,
    )
    .map(|mut matrix| {
        // From the fit's coordinates to the parameters' own units.
        for index in 0..unknowns.free.len() {
            let slope = unknowns.slope(index, minimum.values[unknowns.free[index]]);
            matrix.row_mut(index).scale_mut(slope);
            matrix.column_mut(index).scale_mut(slope);
        }
        matrix
    });
    Fit {
        model: model.clone(),
        values: minimum.values.clone(),
        unknowns,
        minimum,
        covariance,
    }
}
