//! Whether a residual is correlated with itself or with the input, and its effective number of independent values.
//!
//! The usual tests of system identification (Ljung, *System Identification*, 1999, 16.6).

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::fourier::Fourier;

/// Number of lags in the correlation tests, in samples (25 is usual in the field).
pub const LAGS: usize = 25;
/// Two-sided 99 % point of the normal distribution.
const NORMAL_99: f64 = 2.575_829_303_548_901;

/// A correlation function of a residual, with the band that contains 99 % of the coefficients of a white residual.
#[derive(Clone, Debug, PartialEq)]
pub struct CorrelationTest {
    /// Lags in samples; at a positive lag, the residual comes later.
    pub lags: Vec<i64>,
    /// Correlation coefficient at each lag.
    pub values: Vec<f64>,
    /// Each coefficient of a white residual lies within ± this value with a probability of 99 %.
    pub bound_99: f64,
    /// Probability that a white residual shows at least this much correlation over all lags together.
    pub p_value: f64,
}

impl CorrelationTest {
    /// Whether the residual passes the joint test over all lags at 99 %.
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
/// If the model explains the whole response to the input, the coefficient at each lag is Gaussian with
/// variance P/n, P = Σ ρ_e(k) ρ_u(k) over all lags (Ljung 1999, 16.6). The joint test uses only the lags from 0 on:
/// correlation at negative lags comes from feedback. The coefficients are correlated with each other; the joint test
/// accounts for that by an effective number of lags. `None` if fewer than 2·[`LAGS`] samples count or the input never
/// changes.
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
    // The estimates at large lags are only scatter.
    let reach = reach.min((n / 4.0) as usize).max(1);
    let inflation = (1.0
        + 2.0
            * (1..reach)
                .map(|lag| rho(&correlation.own, lag) * rho(&correlation.input, lag))
                .sum::<f64>())
    .max(1.0 / n);
    let variance = inflation / n;
    // Neighbouring coefficients are correlated, as the memories of input and residual overlap. Their sum of squares has
    // the mean of LAGS + 1 independent coefficients, and the scatter of fewer.
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

/// The effective number of independent values of a residual series; n for white noise.
///
/// It is n divided by the larger of two correlation lengths. The first is 1 + 2 Σ ρ(k) (that of a mean; Priestley 1981,
/// 5.3.2), summed up to the first zero of ρ. The second is 1 + 2 Σ ρ(k)² (that of a mean square, on which a likelihood
/// depends); it does not cancel for a residual that oscillates. Coefficients that white noise of n samples could show
/// as well are set to zero: those below √(2 ln n / n), which none of n lags exceeds in most cases. The
/// mean is not subtracted: a constant offset counts as one value.
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
    /// Σ e(k + lag) u(k), negative lags at the end; empty without input.
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
        let fourier = Fourier::new(n);
        let e_hat = fourier.spectrum(&e);
        let mut own = fourier.correlation(&e_hat, &e_hat);
        own.truncate(n);
        let (mut input_own, mut circular) = (vec![], vec![]);
        if let Some(input) = input {
            let mean = (0..n).filter(|&k| valid(k)).map(|k| input[k]).sum::<f64>() / count.max(1.0);
            let u: Vec<f64> = (0..n)
                .map(|k| if valid(k) { input[k] - mean } else { 0.0 })
                .collect();
            let u_hat = fourier.spectrum(&u);
            input_own = fourier.correlation(&u_hat, &u_hat);
            input_own.truncate(n);
            circular = fourier.correlation(&e_hat, &u_hat);
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
    use super::super::test_series::{mean_square, white};
    use super::*;

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
        assert!(autocorrelation(&residual[..20], &[]).is_none());
        assert!((mean_square(&residual) - 1.09).abs() < 0.1);
    }
}
