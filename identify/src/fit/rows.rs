//! Linear least squares, row by row.

use nalgebra::{DMatrix, DVector};

/// Rounds of reweighting. Each round brings the fit a good part of the way.
const REWEIGHTINGS: usize = 30;

/// Rows of a linear least squares.
pub(super) struct Rows {
    columns: usize,
    left: Vec<f64>,
    right: Vec<f64>,
}

impl Rows {
    pub(super) fn new(columns: usize) -> Rows {
        Rows {
            columns,
            left: vec![],
            right: vec![],
        }
    }

    pub(super) fn push(&mut self, row: &[f64], right: f64) {
        if row.iter().all(|v| v.is_finite()) && right.is_finite() {
            self.left.extend_from_slice(row);
            self.right.push(right);
        }
    }

    pub(super) fn solve(&self) -> Option<DVector<f64>> {
        if self.right.len() < self.columns {
            return None;
        }
        let mut matrix = DMatrix::from_row_slice(self.right.len(), self.columns, &self.left);
        // Columns are scaled, so that the pseudo-inverse drops directions that are negligible and not those that are
        // small only because of their unit. A column of zeros (no current flowed) decides nothing: its unknown is zero.
        let scale: Vec<f64> = matrix
            .column_iter()
            .map(|column| Some(column.norm()).filter(|norm| *norm > 0.0))
            .map(|norm| norm.unwrap_or(f64::INFINITY))
            .collect();
        for (column, scale) in scale.iter().enumerate() {
            matrix.column_mut(column).unscale_mut(*scale);
        }
        let solution = matrix
            .svd(true, true)
            .solve(&DVector::from_column_slice(&self.right), 1e-8)
            .ok()?;
        Some(DVector::from_fn(self.columns, |row, _| {
            solution[row] / scale[row]
        }))
    }
}

impl Rows {
    /// Least absolute deviations by iteratively reweighted least squares (Schlossmacher, JASA 68 (1973)). A row that is
    /// shifted by a push has no more influence than any other.
    pub(super) fn solve_absolute(&self) -> Option<DVector<f64>> {
        let mut x = self.solve()?;
        let n = self.right.len();
        for _ in 0..REWEIGHTINGS {
            let residual: Vec<f64> = (0..n)
                .map(|row| {
                    let left = &self.left[row * self.columns..(row + 1) * self.columns];
                    let model: f64 = left.iter().zip(x.iter()).map(|(a, b)| a * b).sum();
                    (self.right[row] - model).abs()
                })
                .collect();
            let mean = residual.iter().sum::<f64>() / n as f64;
            let mut weighted = Rows::new(self.columns);
            for (row, residual) in residual.iter().enumerate() {
                // A row that fits exactly must not take all the weight.
                let weight = 1.0 / residual.max(1e-3 * mean).max(1e-300).sqrt();
                let left = &self.left[row * self.columns..(row + 1) * self.columns];
                let left: Vec<f64> = left.iter().map(|value| weight * value).collect();
                weighted.push(&left, weight * self.right[row]);
            }
            x = weighted.solve()?;
        }
        Some(x)
    }
}
