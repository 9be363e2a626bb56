//! Correlations by the fast Fourier transform: series are padded with zeros to twice their length, so that
//! nothing wraps around.

use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

/// The transform of real series of up to so many samples.
pub(crate) struct Fourier {
    planner: RealFftPlanner<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    length: usize,
}

impl Fourier {
    /// For series of up to `samples` samples.
    pub(crate) fn new(samples: usize) -> Fourier {
        let length = (2 * samples.max(1)).next_power_of_two();
        let mut planner = RealFftPlanner::new();
        Fourier {
            forward: planner.plan_fft_forward(length),
            planner,
            length,
        }
    }

    /// Number of samples with the padding.
    pub(crate) fn length(&self) -> usize {
        self.length
    }

    /// The spectrum of a series, from frequency zero to half of the samples' own.
    pub(crate) fn spectrum(&self, series: &[f64]) -> Vec<Complex<f64>> {
        let mut padded = series.to_vec();
        padded.resize(self.length, 0.0);
        let mut out = self.forward.make_output_vec();
        // The lengths are the planner's own, the only thing that `process` can object to.
        let _ = self.forward.process(&mut padded, &mut out);
        out
    }

    /// Σ a(k + lag) b(k) of two series by their spectra, for lags from 0 on; negative lags stand at the end of
    /// the circle.
    pub(crate) fn correlation(&mut self, a: &[Complex<f64>], b: &[Complex<f64>]) -> Vec<f64> {
        let backward = self.planner.plan_fft_inverse(self.length);
        let mut product: Vec<Complex<f64>> = a.iter().zip(b).map(|(a, b)| a * b.conj()).collect();
        // The spectrum of a real series is real at both ends but for rounding.
        for end in [0, self.length / 2] {
            product[end].im = 0.0;
        }
        let mut out = backward.make_output_vec();
        let _ = backward.process(&mut product, &mut out);
        let scale = self.length as f64;
        out.iter().map(|value| value / scale).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_correlation_is_the_sum_of_products() {
        let a = [1.0, -2.0, 0.5, 3.0, 0.25];
        let b = [0.5, 1.5, -1.0, 2.0, 4.0];
        let mut fourier = Fourier::new(a.len());
        let found = fourier.correlation(&fourier.spectrum(&a), &fourier.spectrum(&b));
        let length = fourier.length() as i64;
        for lag in -4_i64..=4 {
            let products = (0..5_i64).filter(|k| (0..5).contains(&(k + lag)));
            let sum: f64 = products
                .map(|k| a[(k + lag) as usize] * b[k as usize])
                .sum();
            let value = found[lag.rem_euclid(length) as usize];
            assert!((value - sum).abs() < 1e-12, "lag {lag}: {value} {sum}");
        }
    }
}
