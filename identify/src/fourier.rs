//! Correlations by the fast Fourier transform. Series are padded with zeros to twice their length, so that the
//! circular correlation does not wrap around.

use rustfft::algorithm::Radix4;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftDirection};

/// The transform of real series with up to a fixed number of samples.
///
/// The padded length is a power of two, so one algorithm is enough. A planner would bring in all other algorithms, a third
/// of this crate's compile time, and its choice would depend on the processor on which the program runs.
pub(crate) struct Fourier {
    forward: Radix4<f64>,
    length: usize,
}

impl Fourier {
    /// For series of up to `samples` samples.
    pub(crate) fn new(samples: usize) -> Fourier {
        let length = (2 * samples.max(1)).next_power_of_two();
        Fourier {
            forward: Radix4::new(length, FftDirection::Forward),
            length,
        }
    }

    /// Number of samples with the padding.
    pub(crate) fn length(&self) -> usize {
        self.length
    }

    /// The spectrum of a series, from frequency zero to half the sampling frequency.
    pub(crate) fn spectrum(&self, series: &[f64]) -> Vec<Complex<f64>> {
        let mut bins: Vec<Complex<f64>> = Vec::with_capacity(self.length);
        bins.extend(series.iter().map(Complex::from));
        bins.resize(self.length, Complex::default());
        self.forward.process(&mut bins);
        bins.truncate(self.length / 2 + 1);
        bins.shrink_to_fit();
        bins
    }

    /// Σ a(k + lag) b(k) of two series from their spectra. Lags count from 0; negative lags stand at the end of the
    /// result.
    pub(crate) fn correlation(&self, a: &[Complex<f64>], b: &[Complex<f64>]) -> Vec<f64> {
        let half: Vec<Complex<f64>> = a.iter().zip(b).map(|(a, b)| a * b.conj()).collect();
        // The spectrum of a real series is symmetric: the upper half is the conjugate of the lower half.
        let beyond = half[1..self.length / 2].iter().rev().map(Complex::conj);
        let mut bins: Vec<Complex<f64>> = half.iter().copied().chain(beyond).collect();
        let backward = Radix4::new(self.length, FftDirection::Inverse);
        backward.process(&mut bins);
        let scale = self.length as f64;
        bins.iter().map(|value| value.re / scale).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_correlation_is_the_sum_of_products() {
        let a = [1.0, -2.0, 0.5, 3.0, 0.25];
        let b = [0.5, 1.5, -1.0, 2.0, 4.0];
        let fourier = Fourier::new(a.len());
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
