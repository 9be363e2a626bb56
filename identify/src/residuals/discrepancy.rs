//! What no model explains, as a random process beside the noise of the sensor (Kennedy & O'Hagan, J. R. Stat. Soc. B 63
//! (2001)).
//!
//! The residual of a series is taken as white noise of standard deviation σ plus a stationary Gaussian process with the
//! covariance δ² exp(−|t − t′|/ℓ) cos ω(t − t′). With ω = 0 this is an Ornstein–Uhlenbeck process; the residual of a
//! pendulum oscillates, and ω is then its own frequency. The process is that of a damped oscillator that is driven by
//! white noise, hence a Kalman filter with two states evaluates its likelihood exactly in O(n), for samples at any
//! times (Särkkä & Solin, *Applied Stochastic Differential Equations*, 2019, 12.3).

use crate::fourier::Fourier;

/// The process that stands for what a model does not explain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrepancy {
    /// Standard deviation δ, in the unit of the series; 0 if there is nothing but noise.
    pub std: f64,
    /// Correlation time ℓ, s.
    pub time_s: f64,
    /// Angular frequency ω, rad/s; 0 for a discrepancy that does not oscillate.
    pub frequency_rad_s: f64,
}

/// A residual with the times of its samples and the noise of its sensor.
#[derive(Clone, Copy, Debug)]
pub struct NoisySeries<'a> {
    /// Measured minus predicted, in the unit of the series. Samples that are not finite are missing.
    pub residual: &'a [f64],
    /// Times of the samples in s, increasing.
    pub time_s: &'a [f64],
    /// Samples of weight 0 are missing; an empty list counts all.
    pub weight: &'a [f64],
    /// Standard deviation σ of the sensor's noise, positive.
    pub noise_std: f64,
}

impl NoisySeries<'_> {
    /// Time and residual of the samples that count.
    fn counted(&self) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
        let pairs = self.time_s.iter().zip(self.residual).enumerate();
        pairs
            .filter(|(k, (_, value))| {
                value.is_finite() && self.weight.get(*k).is_none_or(|&weight| weight > 0.0)
            })
            .map(|(_, (&time_s, &value))| (time_s, value))
    }
}

impl Discrepancy {
    /// Nothing but noise.
    pub const NONE: Discrepancy = Discrepancy {
        std: 0.0,
        time_s: 1.0,
        frequency_rad_s: 0.0,
    };

    /// Logarithm of the likelihood of a residual, without the constant −n ln(σ√(2π)).
    pub fn log_likelihood(&self, series: &NoisySeries) -> f64 {
        self.log_likelihood_of(series.counted(), series.noise_std)
    }

    /// As [`Discrepancy::log_likelihood`], for samples that count, as (time in s, value), with noise of this deviation.
    fn log_likelihood_of(&self, counted: impl Iterator<Item = (f64, f64)>, noise: f64) -> f64 {
        // In units of the noise: −2 ln L, and the variance of the process.
        let mut loss = Loss::ZERO;
        let variance = (self.std / noise).powi(2);
        // Mean and covariance of the two states before a sample; the first is what the series shows.
        let (mut mean, mut p) = ([0.0; 2], [variance, 0.0, variance]);
        let mut gain = [0.0; 2];
        let mut expected = 1.0;
        // Between equal steps the covariance tends to a limit (Anderson &
        // Moore, *Optimal Filtering*, 1979, 4.4), and is not computed any more once it stands.
        let mut stands = false;
        let mut before_s: Option<f64> = None;
        let (mut step_s, mut decay, mut sin, mut cos) = (0.0, 1.0, 0.0, 1.0);
        for (time_s, value) in counted {
            if let Some(before_s) = before_s {
                let elapsed_s = time_s - before_s;
                // Times in a file are rounded; a millionth of a step changes nothing.
                if (elapsed_s - step_s).abs() > 1e-6 * step_s {
                    step_s = elapsed_s;
                    decay = (-step_s / self.time_s).exp();
                    (sin, cos) = (self.frequency_rad_s * step_s).sin_cos();
                    stands = false;
                }
                mean = [
                    decay * (cos * mean[0] - sin * mean[1]),
                    decay * (sin * mean[0] + cos * mean[1]),
                ];
            }
            if !stands {
                if before_s.is_some() {
                    let [a, b, c] = p;
                    let (ss, cc, sc) = (sin * sin, cos * cos, sin * cos);
                    let kept = decay * decay;
                    let new = variance * (1.0 - kept);
                    p = [
                        kept * (cc * a - 2.0 * sc * b + ss * c) + new,
                        kept * (sc * (a - c) + (cc - ss) * b),
                        kept * (ss * a + 2.0 * sc * b + cc * c) + new,
                    ];
                }
                let before = (expected, gain);
                expected = p[0] + 1.0;
                gain = [p[0] / expected, p[1] / expected];
                p = [p[0] / expected, p[1] / expected, p[2] - gain[1] * p[1]];
                let moved = (gain[0] - before.1[0]).abs() + (gain[1] - before.1[1]).abs();
                stands = (expected - before.0).abs() + moved < STANDS * expected;
            }
            before_s = Some(time_s);
            let innovation = value / noise - mean[0];
            loss.add(innovation, expected);
            mean = [
                mean[0] + gain[0] * innovation,
                mean[1] + gain[1] * innovation,
            ];
        }
        -0.5 * loss.total()
    }

    /// The discrepancy of highest likelihood for a residual: one that does not oscillate, or one at the residual's own
    /// frequency.
    pub fn of(series: &NoisySeries) -> Discrepancy {
        let counted: Vec<(f64, f64)> = series.counted().collect();
        let (Some(first), Some(last)) = (counted.first(), counted.last()) else {
            return Discrepancy::NONE;
        };
        let n = counted.len() as f64;
        let span_s = last.0 - first.0;
        if counted.len() < FEWEST || span_s <= 0.0 {
            return Discrepancy::NONE;
        }
        let step_s = span_s / (n - 1.0);
        let squares = counted.iter().map(|(_, value)| value * value);
        let rms = (squares.sum::<f64>() / n).sqrt();
        let noise = series.noise_std;
        let mut best = Peak {
            at: Discrepancy::NONE,
            log_likelihood: Discrepancy::NONE.log_likelihood_of(counted.iter().copied(), noise),
        };
        for frequency_rad_s in [0.0, own_frequency(&counted, step_s)] {
            let mut time_s = SHORTEST * step_s;
            let mut own = Peak {
                at: Discrepancy::NONE,
                log_likelihood: f64::NEG_INFINITY,
            };
            while time_s < LONGEST * span_s {
                let beyond = (rms * rms - noise * noise).max(0.0).sqrt();
                for std in [0.1 * noise, 0.5 * beyond, beyond, 2.0 * beyond] {
                    let at = Discrepancy {
                        std,
                        time_s,
                        frequency_rad_s,
                    };
                    own.try_at(at, &counted, noise);
                }
                time_s *= 4.0;
            }
            own.climb(
                &counted,
                noise,
                [SHORTEST * step_s, LONGEST * span_s],
                span_s,
            );
            if own.log_likelihood > best.log_likelihood {
                best = own;
            }
        }
        best.at
    }
}

/// −2 ln L of independent innovations: Σ ν²/s + ln s.
struct Loss {
    squares: f64,
    logarithms: f64,
    /// The product of the variances whose logarithm is not yet in the sum: one logarithm of a product costs less than
    /// many of its factors.
    product: f64,
}

impl Loss {
    const ZERO: Loss = Loss {
        squares: 0.0,
        logarithms: 0.0,
        product: 1.0,
    };

    /// Adds an innovation of this variance, which is at least 1.
    fn add(&mut self, innovation: f64, variance: f64) {
        self.squares += innovation * innovation / variance;
        self.product *= variance;
        if self.product > 1e100 {
            self.logarithms += self.product.ln();
            self.product = 1.0;
        }
    }

    fn total(&self) -> f64 {
        self.squares + self.logarithms + self.product.ln()
    }
}

/// The covariance of the filter stands still if a sample changes it by less than this share: a hundred thousand samples
/// then change the likelihood by less than one in ten million.
const STANDS: f64 = 1e-13;
/// Fewest samples from which a discrepancy is estimated.
const FEWEST: usize = 8;
/// Shortest correlation time that is tried, in steps of the log: neighbouring samples are then independent.
const SHORTEST: f64 = 0.25;
/// Longest correlation time that is tried, in lengths of the log: the discrepancy is then a constant.
const LONGEST: f64 = 4.0;
/// The search ends when its steps, in the logarithms of δ and ℓ, are below this value.
const FINE: f64 = 0.02;

/// The best discrepancy so far.
struct Peak {
    at: Discrepancy,
    log_likelihood: f64,
}

impl Peak {
    fn try_at(&mut self, at: Discrepancy, counted: &[(f64, f64)], noise: f64) -> bool {
        let log_likelihood = at.log_likelihood_of(counted.iter().copied(), noise);
        let is_better = log_likelihood > self.log_likelihood;
        if is_better {
            *self = Peak { at, log_likelihood };
        }
        is_better
    }

    /// Climbs along the coordinates with steps that are halved where none leads up.
    fn climb(&mut self, counted: &[(f64, f64)], noise: f64, limits_s: [f64; 2], span_s: f64) {
        let [shortest_s, longest_s] = limits_s;
        let mut step = 0.7;
        // A frequency is resolved to a fraction of one turn in the whole log.
        let mut turn = if self.at.frequency_rad_s > 0.0 {
            1.5
        } else {
            0.0
        };
        while step > FINE {
            let mut moved = false;
            for (std, time, frequency) in [
                (1.0, 0.0, 0.0),
                (-1.0, 0.0, 0.0),
                (0.0, 1.0, 0.0),
                (0.0, -1.0, 0.0),
                (0.5, 1.0, 0.0),
                (-0.5, -1.0, 0.0),
                (0.0, 0.0, 1.0),
                (0.0, 0.0, -1.0),
            ] {
                if frequency != 0.0 && turn == 0.0 {
                    continue;
                }
                let mut at = self.at;
                at.std *= (std * step).exp();
                at.time_s = (at.time_s * (time * step).exp()).clamp(shortest_s, longest_s);
                at.frequency_rad_s = (at.frequency_rad_s + frequency * turn / span_s).abs();
                moved |= self.try_at(at, counted, noise);
            }
            if !moved {
                step *= 0.5;
                turn *= 0.5;
            }
        }
    }
}

/// The frequency at which a residual has the most power, rad/s. The samples are treated as equally spaced.
fn own_frequency(counted: &[(f64, f64)], step_s: f64) -> f64 {
    let n = counted.len();
    let mean = counted.iter().map(|(_, value)| value).sum::<f64>() / n as f64;
    let values: Vec<f64> = counted.iter().map(|(_, value)| value - mean).collect();
    let fourier = Fourier::new(n);
    let spectrum = fourier.spectrum(&values);
    let length = fourier.length();
    let power = spectrum[1..].iter().map(|one| one.norm_sqr()).enumerate();
    let peak = power.max_by(|a, b| a.1.total_cmp(&b.1));
    let at = peak.map_or(0.0, |(index, _)| (index + 1) as f64);
    std::f64::consts::TAU * at / (length as f64 * step_s)
}

#[cfg(test)]
mod tests {
    use super::super::test_series::white;
    use super::*;
    use nalgebra::{Cholesky, DMatrix, DVector};

    /// Irregular times with a gap.
    fn times(seed: u64, n: usize) -> Vec<f64> {
        let jitter = white(seed + 77, n);
        let mut time_s = 0.0;
        (0..n)
            .map(|k| {
                time_s += 0.02 * (1.0 + 0.3 * jitter[k].tanh());
                if k == n / 2 {
                    time_s += 0.5;
                }
                time_s
            })
            .collect()
    }

    fn dense(of: &Discrepancy, time_s: &[f64], noise_std: f64) -> DMatrix<f64> {
        let n = time_s.len();
        DMatrix::from_fn(n, n, |i, j| {
            let lag = (time_s[i] - time_s[j]).abs();
            let shared = of.std * of.std * (-lag / of.time_s).exp();
            let white = if i == j { noise_std * noise_std } else { 0.0 };
            shared * (of.frequency_rad_s * lag).cos() + white
        })
    }

    #[test]
    fn the_filter_gives_the_likelihood_of_the_dense_covariance() {
        for seed in 0..40 {
            // Between even steps the covariance of the filter comes to a stand, again after every gap.
            let is_even = seed >= 20;
            let n = if is_even { 400 } else { 60 };
            let even = || (0..n).map(|k| (20.0 * k as f64).round() / 1e3).collect();
            let all: Vec<f64> = if is_even { even() } else { times(seed, n) };
            let mut residual = white(seed, n);
            let mut weight = vec![1.0; n];
            residual[7] = f64::NAN;
            weight[20..24].fill(0.0);
            let of = Discrepancy {
                std: [0.3, 2.0, 20.0][seed as usize % 3],
                time_s: [0.01, 0.3, 50.0][seed as usize / 3 % 3],
                frequency_rad_s: [0.0, 9.0][seed as usize % 2],
            };
            let noise_std = 0.7;
            let series = NoisySeries {
                residual: &residual,
                time_s: &all,
                weight: &weight,
                noise_std,
            };
            let kept: Vec<usize> = (0..n)
                .filter(|&k| residual[k].is_finite() && weight[k] > 0.0)
                .collect();
            let time_s: Vec<f64> = kept.iter().map(|&k| all[k]).collect();
            let y = DVector::from_fn(kept.len(), |row, _| residual[kept[row]]);
            let covariance = dense(&of, &time_s, noise_std);
            let cholesky = Cholesky::new(covariance).expect("positive");
            let log_determinant = 2.0 * cholesky.l().diagonal().map(f64::ln).sum();
            let square = y.dot(&cholesky.solve(&y));
            let own = kept.len() as f64 * noise_std.powi(2).ln();
            let expected = -0.5 * (square + log_determinant - own);
            let found = of.log_likelihood(&series);
            assert!(
                (found - expected).abs() < 1e-6 * expected.abs(),
                "seed {seed}: {found} {expected}"
            );
        }
    }

    fn simulated(of: &Discrepancy, seed: u64, time_s: &[f64]) -> Vec<f64> {
        let n = time_s.len();
        let (e, p, q) = (white(seed, n), white(seed + 1000, n), white(seed + 2000, n));
        let mut state = [p[0] * of.std, q[0] * of.std];
        (0..n)
            .map(|k| {
                if k > 0 {
                    let step_s = time_s[k] - time_s[k - 1];
                    let decay = (-step_s / of.time_s).exp();
                    let (sin, cos) = (of.frequency_rad_s * step_s).sin_cos();
                    let new = of.std * (1.0 - decay * decay).sqrt();
                    state = [
                        decay * (cos * state[0] - sin * state[1]) + new * p[k],
                        decay * (sin * state[0] + cos * state[1]) + new * q[k],
                    ];
                }
                state[0] + e[k]
            })
            .collect()
    }

    fn with_unit_noise<'a>(residual: &'a [f64], time_s: &'a [f64]) -> NoisySeries<'a> {
        NoisySeries {
            residual,
            time_s,
            weight: &[],
            noise_std: 1.0,
        }
    }

    #[test]
    fn size_time_and_frequency_are_recovered() {
        for (std, time_s, frequency_rad_s) in [
            (0.5, 0.3, 0.0),
            (3.0, 1.0, 0.0),
            (30.0, 0.2, 0.0),
            (3.0, 2.0, 9.7),
        ] {
            let truth = Discrepancy {
                std,
                time_s,
                frequency_rad_s,
            };
            let mut ratios = [0.0; 2];
            let seeds = 12;
            for seed in 0..seeds {
                let all = times(seed, 6000);
                let residual = simulated(&truth, seed, &all);
                let series = with_unit_noise(&residual, &all);
                let found = Discrepancy::of(&series);
                ratios[0] += (found.std / std).ln() / seeds as f64;
                ratios[1] += (found.time_s / time_s).ln() / seeds as f64;
                let off = (found.frequency_rad_s - frequency_rad_s).abs();
                // A process forgets its phase within ℓ.
                assert!(off < 0.7 / time_s, "{found:?} {truth:?}");
                // The search is not above what it looks for by more than chance: χ² of three.
                let gain = found.log_likelihood(&series) - truth.log_likelihood(&series);
                assert!(
                    (-0.05..10.0).contains(&gain),
                    "seed {seed}: {gain} {found:?}"
                );
            }
            eprintln!("{truth:?}: {ratios:?}");
            // 120 s are a hundred correlation times: δ² is known to 15 %, ℓ to 20 %, of one log.
            assert!(
                ratios.iter().all(|r| r.abs() < 0.15),
                "{truth:?} {ratios:?}, seeds 0..12"
            );
        }
    }

    #[test]
    fn white_noise_has_next_to_no_discrepancy() {
        for seed in 0..20 {
            let all = times(seed, 3000);
            let residual = white(seed, all.len());
            let series = with_unit_noise(&residual, &all);
            let found = Discrepancy::of(&series);
            assert!(found.std < 0.25, "seed {seed}: {found:?}");
            let gain = found.log_likelihood(&series) - Discrepancy::NONE.log_likelihood(&series);
            // The highest of 1500 peaks of a periodogram stands by ln 1500 above an average one, give or take a few.
            assert!(gain < 15.0, "seed {seed}: {gain}");
        }
    }
}
