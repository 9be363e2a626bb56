//! The part of a residual that a better model could explain, in units of the sensor's noise.
//!
//! The correlation tests reject every real log with many samples, because they detect even the smallest structure. This
//! statistic says how large the structure is.

use crate::records::NOISE_RELATIVE_STD_ROOT_N;

/// The size of the part of a residual that is not sensor noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResidualStructure {
    /// Root mean square of the structured part, in units of the channel's noise. It is a lower bound that the true value
    /// exceeds with a probability of 84 % (one standard error); 0 if there is no structure.
    pub rms_over_noise: f64,
    /// Significance of the structure in standard deviations of a Gaussian: the largest over all window
    /// lengths. White noise stays below [`SIGNIFICANT`] in more than 99.5 % of all residuals.
    pub significance: f64,
}

impl ResidualStructure {
    /// Whether the structure is significant.
    pub fn is_significant(&self) -> bool {
        self.significance > SIGNIFICANT
    }
}

/// Significance above which a residual counts as structured. A Gaussian exceeds four standard deviations on one
/// side in 3e-5; with some ten window lengths tried and the noise estimated from the log, white noise
/// is flagged in less than 0.2 % of all residuals (see the tests).
pub const SIGNIFICANT: f64 = 4.0;
/// Additional relative uncertainty of the noise estimate: real noise is not exactly Gaussian, white and constant.
const NOISE_RELATIVE_STD: f64 = 0.02;
/// Smallest number of windows over which a mean square is formed.
const FEWEST_WINDOWS: usize = 6;

/// Measures how much of a residual is structure rather than sensor noise.
///
/// The residual is averaged over windows of m = 1, 2, 4, … samples. White noise of standard
/// deviation σ leaves the mean square σ²/m, with the scatter of a χ² variable with as many degrees of
/// freedom as there are windows. Structure that varies slowly over m samples adds its own mean
/// square S². For every time scale of the structure, some m shows it best: the largest
/// S² (minus its standard error) is reported. The uncertainty of σ itself enters the significance, so that an
/// error of a few percent in the noise is not taken for structure.
///
/// `residual` and `noise_std` are in the unit of the channel. Samples that are not finite or have
/// `weight` 0 do not count (an empty `weight` counts all samples). The samples are treated as equally
/// spaced. If the prediction was fitted to these same samples, both results are slightly too low.
///
/// Pass the residual of a quantised channel through [`without_rounding`] first: rounding errors
/// are white only while the motion crosses steps faster than it is sampled.
pub fn structure(residual: &[f64], noise_std: f64, weight: &[f64]) -> ResidualStructure {
    let counted: Vec<Option<f64>> = residual
        .iter()
        .enumerate()
        .map(|(k, &value)| {
            let counts = value.is_finite() && weight.get(k).is_none_or(|&weight| weight > 0.0);
            counts.then_some(value / noise_std)
        })
        .collect();
    let samples = counted.iter().flatten().count().max(1) as f64;
    let noise_variance =
        NOISE_RELATIVE_STD_ROOT_N.powi(2) / samples + NOISE_RELATIVE_STD * NOISE_RELATIVE_STD;
    let mut square = 0.0;
    let mut significance: f64 = 0.0;
    let mut length = 1;
    while counted.len() / length >= FEWEST_WINDOWS {
        let mut windows = 0usize;
        let mut sum_of_squares = 0.0;
        for window in counted.chunks(length) {
            let (count, sum) = window
                .iter()
                .flatten()
                .fold((0usize, 0.0), |(count, sum), value| {
                    (count + 1, sum + value)
                });
            if count > 0 && 2 * count >= length {
                windows += 1;
                // Variance 1 for white noise, for any number of counting samples in the window.
                sum_of_squares += sum * sum / count as f64;
            }
        }
        if windows >= FEWEST_WINDOWS {
            let ratio = sum_of_squares / windows as f64;
            let relative_variance = 2.0 / windows as f64 + 4.0 * noise_variance;
            significance = significance.max(gaussian_of_chi_squared(ratio, relative_variance));
            square = f64::max(
                square,
                (ratio - 1.0 - relative_variance.sqrt()) / length as f64,
            );
        }
        length *= 2;
    }
    ResidualStructure {
        rms_over_noise: square.sqrt(),
        significance,
    }
}

/// The standard normal deviate of a mean square with mean 1 and this variance, treated as χ²/ν with
/// ν = 2/variance (Wilson & Hilferty, PNAS 17 (1931): its cube root is nearly Gaussian).
fn gaussian_of_chi_squared(ratio: f64, variance: f64) -> f64 {
    let ninth = variance / 9.0;
    (ratio.cbrt() - (1.0 - ninth)) / ninth.sqrt()
}

/// The residual of a quantised channel without the rounding error that the prediction itself
/// implies: measured − E[round(predicted + noise)], where the noise before rounding has the
/// variance noise_std² − q²/12.
///
/// A pendulum that swings within one step of its encoder leaves a residual as large as a step, which
/// no model could lower. This function removes it, as far as the prediction determines the position of the angle
/// within its step. `quantum` is the step q, and `noise_std` the whole noise of the channel, rounding included.
/// The zero of the steps is that of the measured values.
pub fn without_rounding(
    measured: &[f64],
    predicted: &[f64],
    noise_std: f64,
    quantum: f64,
) -> Vec<f64> {
    let before = (noise_std * noise_std - quantum * quantum / 12.0)
        .max(0.0)
        .sqrt();
    let zero = measured
        .iter()
        .copied()
        .find(|value| value.is_finite())
        .unwrap_or(0.0);
    measured
        .iter()
        .zip(predicted)
        .map(|(&measured, &predicted)| {
            let steps = (predicted - zero) / quantum;
            let nearest = steps.round();
            let expected = if before < 1e-3 * quantum {
                nearest
            } else {
                // E[round(x + e)] = nearest + Σ over the edges of the chance to lie beyond them.
                let mut sum = nearest;
                for edge in 0..=3 {
                    let beyond = |distance: f64| normal_tail(distance * quantum / before);
                    sum += beyond(nearest + f64::from(edge) + 0.5 - steps);
                    sum -= beyond(steps - (nearest - f64::from(edge) - 0.5));
                }
                sum
            };
            measured - (zero + expected * quantum)
        })
        .collect()
}

/// P(Z > x) of a standard normal Z.
fn normal_tail(x: f64) -> f64 {
    0.5 * statrs::function::erf::erfc(x / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::super::test_series::{mean_square, white};
    use super::*;
    use crate::records::noise_std;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Uniform};

    /// A decaying swing of 1.55 Hz at 250 Hz.
    fn swing(n: usize) -> Vec<f64> {
        (0..n)
            .map(|k| {
                let t = 0.004 * k as f64;
                0.35 * (-0.05 * t).exp() * (9.74 * t).cos()
            })
            .collect()
    }

    #[test]
    fn white_noise_is_hardly_ever_structure_however_its_size_was_estimated() {
        let lengths = [500, 1500, 7500, 20_000];
        let mut errors = vec![vec![]; 4];
        let mut flagged = 0;
        let mut tried = 0;
        for seed in 0..2000 {
            let n = lengths[seed as usize % 4];
            let residual: Vec<f64> = white(seed, n).iter().map(|e| 1.2e-3 * e).collect();
            let measured: Vec<f64> = swing(n).iter().zip(&residual).map(|(x, e)| x + e).collect();
            let found = structure(&residual, noise_std(&measured), &[]);
            let known = structure(&residual, 1.2e-3, &[]);
            flagged += usize::from(found.is_significant()) + usize::from(known.is_significant());
            tried += 2;
            errors[seed as usize % 4].push(noise_std(&measured) / 1.2e-3 - 1.0);
        }
        // The noise is as uncertain as `structure` allows for.
        for (errors, n) in errors.iter().zip(lengths) {
            let rms = mean_square(errors).sqrt();
            let allowed = NOISE_RELATIVE_STD.hypot(NOISE_RELATIVE_STD_ROOT_N / (n as f64).sqrt());
            assert!(rms < 1.1 * allowed, "{rms} {allowed}, n {n}, seeds 0..2000");
        }
        eprintln!("white noise flagged {flagged} of {tried}");
        assert!(
            flagged * 1000 < 2 * tried,
            "{flagged} of {tried}, seeds 0..2000"
        );
    }

    #[test]
    fn a_perfect_prediction_of_a_quantised_swing_is_hardly_ever_structure() {
        let mut flagged = 0;
        let mut tried = 0;
        for seed in 0..600 {
            let quantum = 0.01;
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let noise = [0.0, 0.1, 0.3, 1.0, 3.0][seed as usize % 5] * quantum;
            let phase = Uniform::new(0.0, quantum)
                .expect("ordered")
                .sample(&mut rng);
            let n = 7500;
            let truth = swing(n);
            let e = white(seed + 10_000, n);
            let measured: Vec<f64> = truth
                .iter()
                .zip(&e)
                .map(|(x, e)| ((x + phase + noise * e) / quantum).round() * quantum - phase)
                .collect();
            let std = noise_std(&measured);
            let residual = without_rounding(&measured, &truth, std, quantum);
            flagged += usize::from(structure(&residual, std, &[]).is_significant());
            tried += 1;
        }
        eprintln!("quantised swing flagged {flagged} of {tried}");
        assert!(flagged * 200 < tried, "{flagged} of {tried}, seeds 0..600");
    }

    #[test]
    fn the_size_of_structure_is_found_whatever_its_time_scale() {
        for seed in 0..60 {
            let n = 7500;
            let e = white(seed, n);
            for size in [0.3, 1.0, 3.0, 30.0] {
                for period in [40.0, 160.0, 2000.0] {
                    let residual: Vec<f64> = e
                        .iter()
                        .enumerate()
                        .map(|(k, e)| {
                            let phase = std::f64::consts::TAU * k as f64 / period + seed as f64;
                            e + size * 2f64.sqrt() * phase.sin()
                        })
                        .collect();
                    let found = structure(&residual, 1.0, &[]);
                    assert!(
                        found.is_significant(),
                        "seed {seed}, size {size}, period {period}: {found:?}"
                    );
                    let ratio = found.rms_over_noise / size;
                    // It is a lower bound: one standard error is subtracted, and a window that is
                    // long enough to lower the noise averages some of a fast wave away.
                    let least = if size < 1.0 { 0.7 } else { 0.8 };
                    assert!(
                        (least..1.1).contains(&ratio),
                        "seed {seed}, size {size}, period {period}: {ratio}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_does_not_count_does_not_count() {
        let n = 4000;
        let mut residual = white(3, n);
        let mut weight = vec![1.0; n];
        for k in 1000..1400 {
            residual[k] += 50.0;
            weight[k] = 0.0;
        }
        residual[2000] = f64::NAN;
        assert!(!structure(&residual, 1.0, &weight).is_significant());
        assert!(structure(&residual, 1.0, &[]).is_significant());
        assert_eq!(structure(&[], 1.0, &[]), ResidualStructure::default());
    }
}
