//! The double sum of sensitivities over the autocovariance of a residual, in the frequency domain.

use nalgebra::DMatrix;
use rustfft::num_complex::Complex;

use crate::fourier::Fourier;

/// Σᵢⱼ sᵢ R(i−j) sⱼᵀ of one channel.
pub(super) fn correlated_sum(
    residual: &[f64],
    sensitivities: &[Vec<f64>],
    count: usize,
) -> DMatrix<f64> {
    let n = residual.len();
    let fourier = Fourier::new(n);
    let length = fourier.length();
    let power: Vec<f64> = fourier
        .spectrum(residual)
        .iter()
        .map(|bin| bin.norm_sqr() / count as f64)
        .collect();
    let bins = power.len();
    // The mean over all frequencies is the variance, and no frequency gets a smaller power than this mean. At the
    // frequencies of its own sensitivities, the fit has removed power from the residual.
    let level = (power.iter().sum::<f64>() * 2.0 - power[0] - power[bins - 1]) / length as f64;
    // Averages over n^(1/3) neighbouring frequencies (Daniell window). `length` is 2n or more, and the number of bins
    // grows with it.
    let half = ((n as f64).cbrt() * length as f64 / n as f64 / 2.0).ceil() as usize;
    let mut sums = vec![0.0; bins + 1];
    for (k, value) in power.iter().enumerate() {
        sums[k + 1] = sums[k] + value;
    }
    let smooth = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(bins));
        ((sums[to] - sums[from]) / (to - from) as f64).max(level)
    };
    let transformed: Vec<Vec<Complex<f64>>> =
        sensitivities.iter().map(|s| fourier.spectrum(s)).collect();
    let p = sensitivities.len();
    let weights: Vec<f64> = (0..bins)
        .map(|k| {
            // A real series has each inner frequency twice.
            let multiplicity = if k == 0 || k == bins - 1 { 1.0 } else { 2.0 };
            smooth(k) * multiplicity / length as f64
        })
        .collect();
    let mut out = DMatrix::zeros(p, p);
    for row in 0..p {
        for column in 0..=row {
            let bins = transformed[row].iter().zip(&transformed[column]);
            let sum: f64 = bins
                .zip(&weights)
                .map(|((a, b), weight)| weight * (a * b.conj()).re)
                .sum();
            out[(row, column)] = sum;
            out[(column, row)] = sum;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// An AR(1) residual multiplies the variance of a mean by (1 + a)/(1 − a) (Priestley 1981,
    /// 5.3.2).
    #[test]
    fn the_variance_of_a_mean_of_correlated_residuals_is_the_known_one() {
        let a: f64 = 0.9;
        let n = 20_000;
        let ones = vec![vec![1.0; n]];
        let mut sum = 0.0;
        let seeds = 20;
        for seed in 0..seeds {
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let mut state: f64 = 0.0;
            let residual: Vec<f64> = (0..n)
                .map(|_| {
                    let e: f64 = StandardNormal.sample(&mut rng);
                    state = a * state + (1.0 - a * a).sqrt() * e;
                    state
                })
                .collect();
            sum += correlated_sum(&residual, &ones, n)[(0, 0)] / n as f64;
        }
        let expected = (1.0 + a) / (1.0 - a);
        let ratio = sum / seeds as f64 / expected;
        assert!((0.85..1.1).contains(&ratio), "{ratio}");
    }
}
