//! What is left in a residual: noise, or structure that a better model would explain.
//!
//! Three questions. Does the residual remember itself or the input ([`autocorrelation`],
//! [`cross_correlation`]: the tests that the field expects, Ljung, *System Identification*, 1999,
//! 16.6)? How large is what a better model could explain, in units of the sensor's noise
//! ([`structure`])? And how many independent values is the series worth ([`effective_samples`])?
//!
//! The first has an answer "no" for every real log of many samples, because it rejects whatever is
//! detectable; the second says whether that matters.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Lags that the correlation tests look at, in samples (the field's habit: 25).
pub const LAGS: usize = 25;
/// Two-sided 99 % point of the normal distribution.
const NORMAL_99: f64 = 2.575_829_303_548_901;

/// How large the part of a residual is that is not sensor noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Structure {
    /// Root mean square of the structured part over the noise of the channel: a lower bound that
    /// the truth exceeds with a probability of 84 % (one standard error), 0 where there is none.
    pub rms_over_noise: f64,
    /// How surely there is any, in standard deviations of a Gaussian: the largest over all window
    /// lengths. White noise stays below [`SIGNIFICANT`] in more than 99.5 % of all residuals.
    pub significance: f64,
}

impl Structure {
    /// Whether there is structure beyond reasonable doubt.
    pub fn is_significant(&self) -> bool {
        self.significance > SIGNIFICANT
    }
}

/// Significance above which there is structure. A Gaussian exceeds four standard deviations on one
/// side in 3e-5; with some ten window lengths tried and the noise estimated from the log, white noise
/// is flagged in less than 0.2 % of all residuals (see the tests).
pub const SIGNIFICANT: f64 = 4.0;

/// Relative standard deviation of a channel's noise as [`crate::noise_std`] estimates it from n
/// samples, times √n: 1.25 over simulated swings of 500 to 20,000 samples (see the tests).
const NOISE_RELATIVE_STD_ROOT_N: f64 = 1.25;
/// Relative standard deviation of the noise beyond that: real noise is not quite Gaussian, white
/// and constant.
const NOISE_RELATIVE_STD: f64 = 0.02;
/// Fewest windows over which a mean square is formed.
const FEWEST_WINDOWS: usize = 6;

/// How much of a residual is structure rather than sensor noise.
///
/// The residual is averaged over windows of m = 1, 2, 4, … samples. White noise of standard
/// deviation σ leaves the mean square σ²/m, with the scatter of a χ² variable of as many degrees of
/// freedom as there are windows; structure that varies slowly against m samples leaves its own mean
/// square S² besides. Whatever the time scale of the structure is, some m shows it best: the largest
/// S² (less its standard error) counts. The scatter of σ itself enters the significance, so that an
/// error of a few percent in the noise is not taken for structure.
///
/// `residual` and `noise_std` in the unit of the channel; samples that are not finite or have
/// `weight` 0 do not count (an empty `weight` counts them all). The samples are taken as equally
/// spaced. A prediction that was fitted to these very samples only lowers both numbers.
///
/// For a quantised channel pass the residual through [`without_rounding`] first: rounding errors
/// are white only while the motion crosses steps faster than it is sampled.
pub fn structure(residual: &[f64], noise_std: f64, weight: &[f64]) -> Structure {
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
                // Variance 1 for white noise, however many samples of the window count.
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
    Structure {
        rms_over_noise: square.sqrt(),
        significance,
    }
}

/// The Gaussian deviate of a mean square with mean 1 and this variance, taken as χ²/ν with
/// ν = 2/variance (Wilson & Hilferty, PNAS 17 (1931): its cube root is nearly Gaussian).
fn gaussian_of_chi_squared(ratio: f64, variance: f64) -> f64 {
    let ninth = variance / 9.0;
    (ratio.cbrt() - (1.0 - ninth)) / ninth.sqrt()
}

/// The residual of a quantised channel without the rounding error that the prediction itself
/// foresees: measured − E[round(predicted + noise)], where the noise before rounding has the
/// variance noise_std² − q²/12.
///
/// A pendulum that swings within one step of its encoder leaves a residual as large as a step that
/// no model could lower; this removes it as far as the prediction says where in its step the angle
/// is. `quantum` is the step q and `noise_std` the whole noise of the channel, rounding included.
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

/// A correlation function of a residual with the band that 99 % of white residuals keep.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrelationTest {
    /// Lags in samples; a positive one means that the residual comes later.
    pub lags: Vec<i64>,
    /// Correlation coefficient at each lag.
    pub values: Vec<f64>,
    /// Each coefficient of a white residual lies within ± this in 99 % of all cases.
    pub bound_99: f64,
    /// Probability that a white residual correlates as strongly over all lags together.
    pub p_value: f64,
}

impl CorrelationTest {
    /// Whether the residual passes at 99 %: all lags together.
    pub fn passes(&self) -> bool {
        self.p_value >= 0.01
    }

    /// Number of lags outside the band.
    pub fn outside(&self) -> usize {
        self.values
            .iter()
            .filter(|value| value.abs() > self.bound_99)
            .count()
    }
}

/// Autocorrelation of a residual at lags 1 to [`LAGS`], with the portmanteau test of Ljung & Box
/// (Biometrika 65 (1978)) over all of them. Samples that are not finite or have weight 0 are gaps.
/// `None` where fewer than 2·[`LAGS`] samples count.
pub fn autocorrelation(residual: &[f64], weight: &[f64]) -> Option<CorrelationTest> {
    let correlation = Correlation::of(residual, None, weight);
    let n = correlation.count;
    if n < 2.0 * LAGS as f64 || correlation.own[0] <= 0.0 {
        return None;
    }
    let lags: Vec<i64> = (1..=LAGS as i64).collect();
    let values: Vec<f64> = (1..=LAGS)
        .map(|lag| correlation.own[lag] / correlation.own[0])
        .collect();
    let statistic: f64 = values
        .iter()
        .zip(1..)
        .map(|(value, lag)| n * (n + 2.0) * value * value / (n - f64::from(lag)))
        .sum();
    Some(CorrelationTest {
        lags,
        values,
        bound_99: NORMAL_99 / n.sqrt(),
        p_value: chi_squared_tail(statistic, LAGS as f64),
    })
}

/// Correlation of a residual with an input (the current) at lags −[`LAGS`] to [`LAGS`].
///
/// If the model explains all that the input does, the coefficient at each lag is Gaussian with
/// variance P/n, P = Σ ρ_e(k) ρ_u(k) over all lags (Ljung 1999, 16.6). Only the lags from 0 on
/// count in the joint test: correlation at negative ones comes of feedback. The correlated
/// coefficients enter the joint test with their own correlation through the effective number of
/// lags. `None` where fewer than 2·[`LAGS`] samples count or the input never changes.
pub fn cross_correlation(
    residual: &[f64],
    input: &[f64],
    weight: &[f64],
) -> Option<CorrelationTest> {
    let correlation = Correlation::of(residual, Some(input), weight);
    let n = correlation.count;
    let scale = (correlation.own[0] * correlation.input[0]).sqrt();
    if n < 2.0 * LAGS as f64 || scale <= 0.0 {
        return None;
    }
    let lags: Vec<i64> = (-(LAGS as i64)..=LAGS as i64).collect();
    let values: Vec<f64> = lags
        .iter()
        .map(|&lag| correlation.cross(lag) / scale)
        .collect();
    let rho = |series: &[f64], lag: usize| series.get(lag).map_or(0.0, |value| value / series[0]);
    let reach = correlation.own.len().min(correlation.input.len());
    // Far lags hold nothing but the scatter of the estimate.
    let reach = reach.min((n / 4.0) as usize).max(1);
    let inflation = (1.0
        + 2.0
            * (1..reach)
                .map(|lag| rho(&correlation.own, lag) * rho(&correlation.input, lag))
                .sum::<f64>())
    .max(1.0 / n);
    let variance = inflation / n;
    // Neighbouring coefficients move together as the input's and the residual's memories overlap:
    // their sum of squares has the mean of LAGS + 1 and the scatter of fewer, independent ones.
    let together = |shift: usize| -> f64 {
        let mut sum = 0.0;
        for lag in -(reach as i64) + 1..reach as i64 {
            let own = rho(&correlation.own, lag.unsigned_abs() as usize);
            let other = rho(
                &correlation.input,
                (lag + shift as i64).unsigned_abs() as usize,
            );
            sum += own * other;
        }
        sum / inflation
    };
    let count = LAGS as f64 + 1.0;
    let squares: f64 = count
        + 2.0
            * (1..=LAGS)
                .map(|shift| (count - shift as f64) * together(shift).powi(2))
                .sum::<f64>();
    let independent = (count * count / squares).clamp(1.0, count);
    let statistic: f64 = values[LAGS..]
        .iter()
        .map(|value| value * value / variance)
        .sum::<f64>()
        * independent
        / count;
    Some(CorrelationTest {
        lags,
        values,
        bound_99: NORMAL_99 * variance.sqrt(),
        p_value: chi_squared_tail(statistic, independent),
    })
}

/// P(χ²_ν > x).
fn chi_squared_tail(x: f64, degrees: f64) -> f64 {
    ChiSquared::new(degrees).map_or(f64::NAN, |distribution| distribution.sf(x))
}

/// The number of independent values that a residual series is worth: n for white noise.
///
/// n over the larger of two correlation lengths: 1 + 2 Σ ρ(k) (that of a mean; Priestley 1981,
/// 5.3.2) up to where ρ first vanishes, and 1 + 2 Σ ρ(k)² (that of a mean square, which is what a
/// likelihood is made of; it does not cancel for a residual that oscillates). Coefficients that
/// white noise of n samples would show as well (beyond √(2 ln n / n), exceeded by none of n lags in
/// most cases) are taken as zero. The mean is not subtracted: a constant offset is one value.
pub fn effective_samples(residual: &[f64], weight: &[f64]) -> f64 {
    let correlation = Correlation::of(residual, None, weight);
    let n = correlation.count;
    if n < 2.0 || correlation.own[0] <= 0.0 {
        return n;
    }
    let threshold = (2.0 * n.ln() / n).sqrt();
    let mut of_mean = 1.0;
    let mut of_square = 1.0;
    let mut connected = true;
    for value in &correlation.own[1..] {
        let rho = value / correlation.own[0];
        let counts = rho.abs() > threshold;
        connected &= counts && rho > 0.0;
        if connected {
            of_mean += 2.0 * rho;
        }
        if counts {
            of_square += 2.0 * rho * rho;
        }
    }
    (n / f64::max(of_mean, of_square)).max(1.0)
}

/// Sums of products at all lags, by the fast Fourier transform; gaps count as zero.
struct Correlation {
    /// Number of samples that count.
    count: f64,
    /// Σ e(k) e(k + lag).
    own: Vec<f64>,
    /// Σ u(k) u(k + lag), the mean subtracted; empty without input.
    input: Vec<f64>,
    /// Σ e(k + lag) u(k), negative lags at the end of the circle; empty without input.
    circular: Vec<f64>,
}

impl Correlation {
    fn of(residual: &[f64], input: Option<&[f64]>, weight: &[f64]) -> Correlation {
        let n = residual.len();
        let valid = |k: usize| {
            residual[k].is_finite()
                && weight.get(k).is_none_or(|&weight| weight > 0.0)
                && input.is_none_or(|input| input.get(k).is_some_and(|value| value.is_finite()))
        };
        let count = (0..n).filter(|&k| valid(k)).count() as f64;
        let e: Vec<f64> = (0..n)
            .map(|k| if valid(k) { residual[k] } else { 0.0 })
            .collect();
        let length = (2 * n.max(1)).next_power_of_two();
        let mut planner = RealFftPlanner::<f64>::new();
        let forward = planner.plan_fft_forward(length);
        let backward = planner.plan_fft_inverse(length);
        let transform = |series: &[f64]| -> Vec<Complex<f64>> {
            let mut padded = series.to_vec();
            padded.resize(length, 0.0);
            let mut out = forward.make_output_vec();
            // The lengths are the planner's own, the only thing that `process` can object to.
            let _ = forward.process(&mut padded, &mut out);
            out
        };
        let inverse = |mut spectrum: Vec<Complex<f64>>| -> Vec<f64> {
            // A product of a spectrum with its conjugate is real at the ends but for rounding.
            for end in [0, length / 2] {
                spectrum[end].im = 0.0;
            }
            let mut out = backward.make_output_vec();
            let _ = backward.process(&mut spectrum, &mut out);
            out.iter().map(|value| value / length as f64).collect()
        };
        let e_hat = transform(&e);
        let mut own = inverse(e_hat.iter().map(|bin| bin * bin.conj()).collect());
        own.truncate(n);
        let (mut input_own, mut circular) = (vec![], vec![]);
        if let Some(input) = input {
            let mean = (0..n).filter(|&k| valid(k)).map(|k| input[k]).sum::<f64>() / count.max(1.0);
            let u: Vec<f64> = (0..n)
                .map(|k| if valid(k) { input[k] - mean } else { 0.0 })
                .collect();
            let u_hat = transform(&u);
            input_own = inverse(u_hat.iter().map(|bin| bin * bin.conj()).collect());
            input_own.truncate(n);
            circular = inverse(
                e_hat
                    .iter()
                    .zip(&u_hat)
                    .map(|(e, u)| e * u.conj())
                    .collect(),
            );
        }
        if own.is_empty() {
            own.push(0.0);
        }
        if input_own.is_empty() {
            input_own.push(0.0);
        }
        Correlation {
            count,
            own,
            input: input_own,
            circular,
        }
    }

    /// Σ e(k + lag) u(k).
    fn cross(&self, lag: i64) -> f64 {
        let length = self.circular.len() as i64;
        if length == 0 {
            return 0.0;
        }
        self.circular[lag.rem_euclid(length) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise_std;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, Uniform};

    fn white(seed: u64, n: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut rng)).collect()
    }

    fn mean_square(values: &[f64]) -> f64 {
        values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
    }

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
        assert_eq!(structure(&[], 1.0, &[]), Structure::default());
        assert!(autocorrelation(&residual[..20], &[]).is_none());
    }

    #[test]
    fn effective_samples_of_white_noise_are_its_samples() {
        let mut worst: f64 = f64::INFINITY;
        let mut sum = 0.0;
        for seed in 0..300 {
            let n = 5000;
            let ratio = effective_samples(&white(seed, n), &[]) / n as f64;
            worst = worst.min(ratio);
            sum += ratio / 300.0;
        }
        assert!(worst > 0.9 && sum > 0.995, "{worst} {sum}, seeds 0..300");
    }

    /// An AR(1) series has the correlation length (1 + a)/(1 − a) for its mean (Priestley 1981,
    /// 5.3.2) and (1 + a²)/(1 − a²) for its mean square.
    #[test]
    fn effective_samples_of_an_autoregressive_series_are_the_known_ones() {
        for a in [0.5, 0.9, 0.98] {
            let mut sum = 0.0;
            for seed in 0..40 {
                let n = 20_000;
                let mut state = 0.0;
                let series: Vec<f64> = white(seed, n)
                    .iter()
                    .map(|e| {
                        state = a * state + e;
                        state
                    })
                    .collect();
                sum += n as f64 / effective_samples(&series, &[]) / 40.0;
            }
            let expected = (1.0 + a) / (1.0 - a);
            assert!(
                (0.8..1.2).contains(&(sum / expected)),
                "{a}: {sum} {expected}"
            );
        }
        // A residual that oscillates is worth a few values, not one for each zero crossing.
        let sine: Vec<f64> = (0..6000).map(|k| (0.1 * k as f64).sin()).collect();
        assert!(effective_samples(&sine, &[]) < 5.0);
        assert!(effective_samples(&vec![1.0; 500], &[]) < 3.0);
    }

    #[test]
    fn one_white_residual_in_a_hundred_fails_each_correlation_test() {
        let (mut auto, mut cross) = (0, 0);
        let trials = 3000;
        for seed in 0..trials {
            let n = 1500;
            let residual = white(seed, n);
            // A command that is itself strongly correlated.
            let mut state = 0.0;
            let input: Vec<f64> = white(seed + 1_000_000, n)
                .iter()
                .map(|e| {
                    state = 0.95 * state + e;
                    state
                })
                .collect();
            let test = autocorrelation(&residual, &[]).expect("long enough");
            auto += usize::from(!test.passes());
            let test = cross_correlation(&residual, &input, &[]).expect("long enough");
            cross += usize::from(!test.passes());
        }
        let rate = |count: usize| count as f64 / trials as f64;
        eprintln!("failing: auto {} cross {}", rate(auto), rate(cross));
        for count in [auto, cross] {
            assert!(
                (0.003..0.02).contains(&rate(count)),
                "{auto} {cross} of {trials}"
            );
        }
    }

    #[test]
    fn correlation_is_found_at_the_lag_at_which_it_is() {
        let n = 4000;
        let e = white(1, n);
        let u = white(2, n);
        let residual: Vec<f64> = (0..n)
            .map(|k| e[k] + if k >= 7 { 0.3 * u[k - 7] } else { 0.0 })
            .collect();
        let test = cross_correlation(&residual, &u, &[]).expect("long enough");
        let largest = (0..test.values.len())
            .max_by(|&a, &b| test.values[a].abs().total_cmp(&test.values[b].abs()))
            .expect("not empty");
        assert_eq!(test.lags[largest], 7);
        assert!(!test.passes());
        assert!(
            autocorrelation(&residual, &[])
                .expect("long enough")
                .passes()
        );
        assert!((mean_square(&residual) - 1.09).abs() < 0.1);
    }
}
