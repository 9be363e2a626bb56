//! Least squares with a step function of a coordinate.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::coordinate::bin_of;
use super::series::ResidualSeries;

/// A region is the shortest run of bins with this share of the explained squares. The share is large enough to contain a
/// whole cause (a magnet pulls on one side of its place and pushes on the other, half the squares each), and small
/// enough to exclude its faint ends.
const REGION_PART: f64 = 0.8;
/// Relative uncertainty of a sum of squares that comes from the noise estimate itself.
const NOISE_SQUARE_RELATIVE_STD: f64 = 0.06;

/// A least-squares fit of a step function to one or several series.
pub(super) struct StepFit {
    /// Coefficients: the constants of the bins, then, if fitted, their parts along the motion.
    pub(super) beta: DVector<f64>,
    /// Standard error of each.
    pub(super) std: DVector<f64>,
    /// Sum of squares that the function explains, in units of the squared noise.
    pub(super) explained: f64,
    /// The sum of squares that the function would explain of noise alone, and the variance of this sum.
    pub(super) of_noise: (f64, f64),
    /// For each series: explained squares in each bin above those of noise.
    pub(super) energy: Vec<Vec<f64>>,
    /// For each series: the squares that noise alone would explain in each bin, already subtracted.
    pub(super) noise_energy: Vec<Vec<f64>>,
    /// For each series: number of values in each bin.
    pub(super) count: Vec<Vec<f64>>,
}

/// Fits f(x) with these bin edges; `at` gives coordinate and speed for a series and an interval.
/// `is_turn` marks a cyclic coordinate (the wheel's angle): a bump during which the wheel turns by half a turn or more
/// is left out, since it averages over all angles.
pub(super) fn fit_steps(
    series: &[&ResidualSeries],
    edges: &[f64],
    (with_sign, is_turn): (bool, bool),
    at: &dyn Fn(usize, usize) -> (f64, f64),
) -> Option<StepFit> {
    let bins = edges.len() - 1;
    let columns = if with_sign { 2 * bins } else { bins };
    let most = if is_turn { bins / 2 } else { columns };
    let mut square = DMatrix::<f64>::zeros(columns, columns);
    let mut noise = DMatrix::<f64>::zeros(columns, columns);
    let mut right = DVector::<f64>::zeros(columns);
    let mut total = 0.0;
    let mut values = 0usize;
    // Rows are stored as short lists, because a bump passes only a few bins.
    let mut rows: Vec<Vec<Vec<(usize, f64)>>> = vec![];
    for (index, one) in series.iter().enumerate() {
        let scale = 1.0 / one.noise_std;
        let mut own = vec![];
        for ((start, weights), value) in one.looks.iter().zip(&one.values) {
            let mut row = vec![0.0; columns];
            for (offset, weight) in weights.iter().enumerate() {
                let (x, speed) = at(index, start + offset);
                if let Some(bin) = bin_of(edges, x) {
                    row[bin] += weight * scale;
                    if with_sign {
                        row[bins + bin] += weight * scale * speed.signum();
                    }
                }
            }
            let mut row: Vec<(usize, f64)> = row
                .into_iter()
                .enumerate()
                .filter(|(_, weight)| *weight != 0.0)
                .collect();
            if row.len() > most {
                row.clear();
            }
            for &(a, left) in &row {
                right[a] += left * value;
                for &(b, other) in &row {
                    square[(a, b)] += left * other;
                }
            }
            total += value * value;
            values += 1;
            own.push(row);
        }
        for (k, row) in own.iter().enumerate() {
            for (later, other) in own.iter().enumerate().skip(k) {
                let lag = one.position[later] - one.position[k];
                let Some(&correlation) = one.noise_correlation.get(lag) else {
                    break;
                };
                for &(a, left) in row {
                    for &(b, right) in other {
                        noise[(a, b)] += correlation * left * right;
                        if later > k {
                            noise[(b, a)] += correlation * left * right;
                        }
                    }
                }
            }
        }
        rows.push(own);
    }
    let mean_diagonal = square.trace() / columns as f64;
    for index in 0..columns {
        // Without this, the coefficients of bins that the data do not distinguish would grow without bound.
        square[(index, index)] += 1e-6 * mean_diagonal.max(1e-300);
    }
    let inverse = Cholesky::new(square)?.inverse();
    let beta = &inverse * &right;
    let explained = beta.dot(&right);
    let of_noise = &inverse * &noise;
    let mean = of_noise.trace();
    let variance =
        2.0 * (&of_noise * &of_noise).trace() + (NOISE_SQUARE_RELATIVE_STD * mean).powi(2);
    // The residual that the coordinate does not explain counts as noise, too.
    let left = ((total - explained) / (values as f64 - mean).max(1.0)).max(1.0);
    let spread = &of_noise * &inverse;
    let std = DVector::from_fn(columns, |k, _| (left * spread[(k, k)].max(0.0)).sqrt());
    let mut energy = vec![vec![0.0; bins]; series.len()];
    let mut noise_energy = vec![vec![0.0; bins]; series.len()];
    let mut count = vec![vec![0.0; bins]; series.len()];
    for (index, own) in rows.iter().enumerate() {
        for row in own {
            let fitted: f64 = row.iter().map(|&(k, weight)| weight * beta[k]).sum();
            for &(k, weight) in row {
                energy[index][k % bins] += fitted * weight * beta[k];
                if k < bins {
                    count[index][k] += weight * series[index].noise_std;
                }
            }
        }
    }
    // The noise's share is distributed by the number of values that each series has in the bin.
    for bin in 0..bins {
        let all: f64 = count.iter().map(|count| count[bin]).sum();
        let mut own = of_noise[(bin, bin)];
        if with_sign {
            own += of_noise[(bins + bin, bins + bin)];
        }
        for (index, count) in count.iter().enumerate() {
            noise_energy[index][bin] = own * count[bin] / all.max(1e-300);
            energy[index][bin] -= noise_energy[index][bin];
        }
    }
    Some(StepFit {
        beta,
        std,
        explained,
        of_noise: (mean, variance),
        energy,
        noise_energy,
        count,
    })
}

/// The shortest run of bins that holds [`REGION_PART`] of the positive energy, as first and last index.
pub(super) fn shortest_run(energy: &[f64], edges: &[f64]) -> Option<(usize, usize)> {
    let positive: Vec<f64> = energy.iter().map(|value| value.max(0.0)).collect();
    let goal = REGION_PART * positive.iter().sum::<f64>();
    if goal <= 0.0 {
        return None;
    }
    let mut best: Option<(usize, usize)> = None;
    for from in 0..positive.len() {
        let mut sum = 0.0;
        for to in from..positive.len() {
            sum += positive[to];
            if sum >= goal {
                let width = edges[to + 1] - edges[from];
                if best.is_none_or(|(a, b)| width < edges[b + 1] - edges[a]) {
                    best = Some((from, to));
                }
                break;
            }
        }
    }
    best
}
