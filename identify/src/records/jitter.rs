//! A clock that jitters: time stamps that are off by a random part of the interval between samples, or samples that were
//! taken late at random.
//!
//! An error ε of the time changes a sample of slope s by s ε. If the errors are independent, this is white noise
//! whose variance σ_t² s² grows with the square of the slope, beside the constant variance σ² of the sensor. Both are
//! estimated from the log alone: a divided difference of order d over the logged times removes every polynomial of
//! degree below d, and with its weights w scaled to Σ w² = 1, its mean square is σ² + σ_t² Σ w² s². Regression of the
//! squares on Σ w² s² gives both variances.

use plant::Kind;

use super::record::{Record, RecordedChannel};
use super::statistics::median;

/// The jitter of a clock, as one channel shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jitter {
    /// Variance of the time's error, s².
    time_variance: f64,
    /// Standard error of that variance, s².
    std: f64,
    /// Variance of the noise that does not depend on the slope, in squared units of the channel.
    noise_variance: f64,
    /// Mean square of the slope, in squared units of the channel per s².
    slope_square: f64,
}

/// Orders of the differences that are tried, the lowest first.
const ORDERS: [usize; 4] = [2, 4, 6, 8];
/// A larger order is taken if it lowers the mean square by this share: the motion itself was still in the smaller one.
const STILL_FALLS: f64 = 0.1;
/// Likewise where it lowers the jitter by this share: in a chirp, the fast part of the motion is still in the smaller
/// order, and it is there that the slope is large. A jitter does not fall with the order.
const JITTER_FALLS: f64 = 0.25;
/// Samples to either side over which a slope is taken.
const REACH: usize = 2;
/// The slope must stand out of its own noise by this factor of their mean squares. A jitter that matters makes the
/// slope times a fifth of an interval comparable to the noise, hence a hundred times its noise over four intervals.
const SLOPE_IS_PLAIN: f64 = 10.0;
/// Fewest differences from which a jitter is estimated.
const FEWEST: usize = 100;
/// Squares beyond this multiple of their expectation are jolts or lost samples; 1 in 10⁵ of a Gaussian's.
const JOLT: f64 = 20.0;
/// A jitter is plain beyond this many standard errors of its variance. With a few channels in ten logs, chance
/// reaches it on one bench in 10⁷; the margin is for noise that is not Gaussian.
const PLAIN: f64 = 6.0;
/// Two channels agree if their variances differ by less than this share: their slopes are known to a tenth.
const AGREES: f64 = 0.5;
/// Largest jitter in intervals between samples: samples that are late by up to a whole interval at random have 0.29.
/// A wave of a few samples per period gives more.
const MOST_OF_STEP: f64 = 0.3;
/// Number of samples at which the slope is looked at before anything is estimated.
const LOOKS: usize = 2000;
/// Rounds of the regression, each with the weights of the one before.
const ROUNDS: usize = 8;

impl Record {
    /// Finds out whether the clock jitters, and gives every channel the noise that follows.
    pub(super) fn find_jitter(&mut self) {
        if self.kind == Kind::Balance {
            return;
        }
        let kinks = self.kinks();
        let (mut places, mut found) = (vec![], vec![]);
        for (index, channel) in self.channels.iter().enumerate() {
            // Rounding is no noise while a motion stands still between two steps, and noise while it crosses them.
            if channel.quantum.is_none()
                && moves_plainly(channel)
                && let Some(one) = jitter(&self.time_s, &channel.samples, &kinks)
            {
                places.push(index);
                found.push(one);
            }
        }
        self.clock_jitter_s = shared(&self.time_s, &found);
        let Some(jitter_s) = self.clock_jitter_s else {
            return;
        };
        for (index, one) in places.into_iter().zip(found) {
            let of_clock = jitter_s * jitter_s * one.slope_square;
            let channel = &mut self.channels[index];
            channel.noise_std = channel
                .noise_std
                .max((one.noise_variance + of_clock).sqrt());
        }
    }
}

/// Whether a channel moves plainly from sample to sample, by [`SLOPE_IS_PLAIN`]; for dense logs a sample of the samples is
/// enough to tell.
fn moves_plainly(channel: &RecordedChannel) -> bool {
    let samples = &channel.samples;
    let last = samples.len().saturating_sub(2 * REACH);
    let (mut squares, mut count) = (0.0, 0.0);
    for k in (0..last).step_by((last / LOOKS).max(1)) {
        let square = (samples[k + 2 * REACH] - samples[k]).powi(2);
        if square.is_finite() {
            squares += square;
            count += 1.0;
        }
    }
    squares > SLOPE_IS_PLAIN * 2.0 * channel.noise_std.powi(2) * count
}

/// Estimates the jitter from the samples of one channel at their logged times. `kinks` are the samples, in rising order, at
/// which the motion has a kink; no difference is taken across one. `None` where the log cannot tell.
fn jitter(time_s: &[f64], samples: &[f64], kinks: &[usize]) -> Option<Jitter> {
    let mut before: Option<(f64, Jitter)> = None;
    for order in ORDERS {
        let found = squares(time_s, samples, kinks, order)?;
        if before.is_none() && !slope_is_plain(time_s, &found) {
            return None;
        }
        let size = median(found.iter().map(|(square, _)| *square))?;
        let jitter = regression(&found, order)?;
        if let Some((size_before, jitter_before)) = before
            && size > size_before * (1.0 - STILL_FALLS)
            && jitter.time_variance >= jitter_before.time_variance * (1.0 - JITTER_FALLS)
        {
            return Some(jitter);
        }
        before = Some((size, jitter));
    }
    // Where the largest order still lowers the squares, they are the motion's.
    None
}

/// The regression of the squares of differences of an order on the squares of the slopes.
fn regression(found: &Squares, order: usize) -> Option<Jitter> {
    let n = found.len() as f64;
    let slope_square = found.iter().map(|(_, slope)| slope).sum::<f64>() / n;
    let mean_square = found.iter().map(|(square, _)| square).sum::<f64>() / n;
    let (mut constant, mut time_variance) = (mean_square, 0.0);
    let mut variance_of_time = 0.0;
    for _ in 0..ROUNDS {
        let mut sums = [0.0; 5];
        let mut scatter = [[0.0; 2]; 2];
        for (square, slope) in found {
            let expected = constant + time_variance * slope;
            if *square > JOLT * expected {
                continue;
            }
            // The variance of a Gaussian's square is twice its square.
            let weight = 1.0 / (expected * expected);
            for (sum, term) in
                sums.iter_mut()
                    .zip([1.0, *slope, slope * slope, *square, square * slope])
            {
                *sum += weight * term;
            }
            let miss = (weight * (square - expected)).powi(2);
            scatter[0][0] += miss;
            scatter[0][1] += miss * slope;
            scatter[1][1] += miss * slope * slope;
        }
        let [one, x, xx, y, xy] = sums;
        let determinant = one * xx - x * x;
        if determinant <= 0.0 || !determinant.is_finite() {
            return None;
        }
        time_variance = ((one * xy - x * y) / determinant).max(0.0);
        constant = ((y - time_variance * x) / one).max(1e-6 * mean_square);
        // The variance of the estimate from the scatter of the squares, whatever their distribution.
        let (a, b) = (-x / determinant, one / determinant);
        variance_of_time =
            a * a * scatter[0][0] + 2.0 * a * b * scatter[0][1] + b * b * scatter[1][1];
    }
    Some(Jitter {
        time_variance,
        std: (variance_of_time * overlap(order)).sqrt(),
        noise_variance: constant,
        slope_square,
    })
}

/// Whether the slopes stand out of their noise, for differences `found` as (square, mean square of the slope).
fn slope_is_plain(time_s: &[f64], found: &[(f64, f64)]) -> bool {
    let squares: f64 = found.iter().map(|(square, _)| square).sum();
    let slopes: f64 = found.iter().map(|(_, slope)| slope).sum();
    // A slope is a difference over 2 REACH intervals.
    let reach_s = 2.0 * REACH as f64 * step_s(time_s);
    slopes >= SLOPE_IS_PLAIN * 2.0 * squares / (reach_s * reach_s)
}

/// The mean interval between samples, s.
pub(super) fn step_s(time_s: &[f64]) -> f64 {
    let ends = time_s.first().zip(time_s.last());
    let intervals = time_s.len().saturating_sub(1).max(1) as f64;
    ends.map_or(0.0, |(first, last)| last - first) / intervals
}

/// The jitter that the channels of a log share: the standard deviation of the time's error in s, from the weighted
/// mean of the `found` variances. `None` if it is not plain, if a channel contradicts it, if it is more than a
/// fraction of an interval, or if it makes the smaller part of the noise in every channel. In the last two cases,
/// noise that grows with the slope may have another cause; the smaller part also stays below the remainder that
/// counts.
fn shared(time_s: &[f64], found: &[Jitter]) -> Option<f64> {
    let weight = |one: &Jitter| 1.0 / one.std.powi(2).max(f64::MIN_POSITIVE);
    let total: f64 = found.iter().map(weight).sum();
    let mean: f64 = found
        .iter()
        .map(|one| weight(one) * one.time_variance)
        .sum::<f64>()
        / total;
    let is_plain = mean > PLAIN / total.sqrt();
    let agrees =
        |one: &Jitter| (one.time_variance - mean).abs() < (PLAIN * one.std).max(AGREES * mean);
    let is_fraction = mean.sqrt() < MOST_OF_STEP * step_s(time_s);
    let is_most = |one: &Jitter| mean * one.slope_square > one.noise_variance;
    let is_jitter = total > 0.0 && is_plain && is_fraction;
    (is_jitter && found.iter().all(agrees) && found.iter().any(is_most)).then(|| mean.sqrt())
}

/// By how much the variance of a mean square grows because neighbouring differences of this order overlap:
/// Σ ρ(k)² with ρ(k) = C(2d, d + k)/C(2d, d), which is C(4d, 2d)/C(2d, d)².
fn overlap(order: usize) -> f64 {
    let binomial =
        |n: usize, k: usize| -> f64 { (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product() };
    binomial(4 * order, 2 * order) / binomial(2 * order, order).powi(2)
}

/// The square of every difference, and the weighted mean square of the slope over its samples.
type Squares = Vec<(f64, f64)>;

/// The squares of all differences of an order; `None` if there are too few.
fn squares(time_s: &[f64], samples: &[f64], kinks: &[usize], order: usize) -> Option<Squares> {
    let n = samples.len().min(time_s.len());
    if n < order + 2 * REACH + 2 {
        return None;
    }
    let slopes: Vec<f64> = (0..n)
        .map(|k| {
            if k < REACH || k + REACH >= n {
                return f64::NAN;
            }
            let (before, after) = (k - REACH, k + REACH);
            (samples[after] - samples[before]) / (time_s[after] - time_s[before])
        })
        .collect();
    let mut found = Vec::with_capacity(n);
    let mut weights = vec![0.0; order + 1];
    // Times relative to their first, and 1/Σ w². The weights are those of the times alone: an even clock has them once.
    let mut known = vec![f64::NAN; order + 1];
    let mut per_total = f64::NAN;
    for first in REACH..n - order - REACH {
        let last = first + order;
        let kink = kinks.partition_point(|&kink| kink + REACH < first);
        if kinks.get(kink).is_some_and(|&kink| kink <= last + REACH) {
            continue;
        }
        let times = &time_s[first..=last];
        // Times in a file are rounded; a millionth of a step changes nothing.
        let least = 1e-6 * (times[order] - times[0]) / order as f64;
        let mut pairs = times.iter().zip(&known);
        if !pairs.all(|(time, known)| (time - times[0] - known).abs() <= least) {
            for (known, time) in known.iter_mut().zip(times) {
                *known = time - times[0];
            }
            for (i, weight) in weights.iter_mut().enumerate() {
                let others = times.iter().enumerate().filter(|(j, _)| *j != i);
                // In units of the whole span, so that the product neither overflows nor vanishes.
                let product =
                    others.map(|(_, other)| (times[i] - other) / (times[order] - times[0]));
                *weight = 1.0 / product.product::<f64>();
            }
            per_total = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
        }
        let (mut difference, mut slope) = (0.0, 0.0);
        for (i, weight) in weights.iter().enumerate() {
            difference += weight * samples[first + i];
            slope += weight * weight * slopes[first + i].powi(2);
        }
        let square = difference * difference * per_total;
        if square.is_finite() && slope.is_finite() {
            found.push((square, slope * per_total));
        }
    }
    (found.len() >= FEWEST).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal, Uniform};

    /// A decaying swing of 1.55 Hz, sampled `rate_hz` times a second with noise of 1.2 mrad. Its times are off by ±`share` of
    /// an interval; `stamps` says whether the stamps are wrong, or the samples taken at other times than the log's even ones.
    fn swing(seed: u64, rate_hz: f64, share: f64, stamps: bool) -> (Vec<f64>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let off = Uniform::new(-1.0, 1.0).expect("ordered");
        let step_s = 1.0 / rate_hz;
        (0..(30.0 * rate_hz) as usize)
            .map(|k| {
                let even_s = k as f64 * step_s;
                let error_s = share * step_s * off.sample(&mut rng);
                let (taken_s, logged_s) = if stamps {
                    (even_s, even_s + error_s)
                } else {
                    (even_s + error_s, even_s)
                };
                let noise: f64 = StandardNormal.sample(&mut rng);
                let angle = 0.6 * (-0.03 * taken_s).exp() * (9.74 * taken_s).cos();
                (logged_s, angle + 1.2e-3 * noise)
            })
            .unzip()
    }

    #[test]
    fn the_jitter_and_the_noise_are_recovered() {
        for seed in 0..20 {
            let stamps = seed % 2 == 0;
            for (rate_hz, share) in [(50.0, 0.2), (100.0, 0.2), (100.0, 0.4), (250.0, 0.2)] {
                let (time_s, angle) = swing(seed, rate_hz, share, stamps);
                let found = jitter(&time_s, &angle, &[]).expect("a plain slope");
                let truth = (share / rate_hz).powi(2) / 3.0;
                let off = (found.time_variance - truth) / found.std;
                assert!(
                    off.abs() < 4.5,
                    "seed {seed} {rate_hz} {share}: {found:?} {truth}"
                );
                let total = found.noise_variance + found.time_variance * found.slope_square;
                let expected = 1.2e-3f64.powi(2) + truth * found.slope_square;
                // 1500 overlapping differences know their mean square to 6 %.
                assert!((total / expected - 1.0).abs() < 0.25, "{total} {expected}");
                if rate_hz <= 100.0 {
                    assert!(found.time_variance > 8.0 * found.std, "{found:?}");
                }
            }
        }
    }

    #[test]
    fn a_steady_clock_has_no_jitter() {
        let mut beyond = 0;
        for seed in 0..200 {
            for rate_hz in [50.0, 250.0] {
                let (time_s, angle) = swing(seed, rate_hz, 0.0, false);
                let found = jitter(&time_s, &angle, &[]);
                beyond += usize::from(found.is_some_and(|one| one.time_variance > 3.0 * one.std));
            }
        }
        // One in 700 of a Gaussian.
        assert!(beyond <= 4, "{beyond} of 400, seeds 0..200");
    }

    /// A chirp of up to six samples in a period: what differences leave of the motion grows with the slope, too.
    #[test]
    fn a_chirp_is_no_jitter() {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let time_s: Vec<f64> = (0..2000).map(|k| 0.05 * f64::from(k)).collect();
            let mut speed = |t: f64| {
                let noise: f64 = StandardNormal.sample(&mut rng);
                100.0 * (0.105 * t * t).sin() + 0.05 * noise
            };
            let speed: Vec<f64> = time_s.iter().map(|&t| speed(t)).collect();
            let found: Vec<Jitter> = jitter(&time_s, &speed, &[]).into_iter().collect();
            assert_eq!(shared(&time_s, &found), None, "seed {seed}: {found:?}");
        }
    }

    /// Uneven samples with right stamps have no jitter.
    #[test]
    fn uneven_times_are_no_jitter() {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let off = Uniform::new(-0.3, 0.3).expect("ordered");
            let (mut time_s, mut angle) = (vec![], vec![]);
            for k in 0..3000 {
                let at_s = 0.01 * (f64::from(k) + off.sample(&mut rng));
                let noise: f64 = StandardNormal.sample(&mut rng);
                time_s.push(at_s);
                angle.push(0.6 * (9.74 * at_s).cos() + 1.2e-3 * noise);
            }
            if let Some(found) = jitter(&time_s, &angle, &[]) {
                assert!(
                    found.time_variance < 4.0 * found.std,
                    "seed {seed}: {found:?}"
                );
                assert!(found.noise_variance.sqrt() < 1.3e-3);
            }
        }
    }
}
