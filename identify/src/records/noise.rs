//! The noise of a sensor, estimated from the log alone.
//!
//! Differences of order d remove every polynomial of degree below d. The part of a smooth motion in them falls quickly
//! with d, while white noise of standard deviation σ keeps the variance
//! σ² C(2d, d) (Kendall & Stuart, vol. 3, "variate-difference method"). The order is raised until
//! the estimate no longer falls. A median over blocks makes the estimate insensitive to pushes and jolts.

use super::statistics::median;

/// Highest order of differences.
const MAX_ORDER: usize = 10;
/// Number of blocks over which the median is taken.
const BLOCKS: usize = 20;
/// Lower limit of the noise estimate, as a share of the signal's spread. It stands for the errors of the integration
/// and of the log's own rounding: no model is more exact than that.
const RELATIVE_FLOOR: f64 = 1e-4;

/// Relative standard deviation of [`noise_std`] from n samples, times √n: 1.25 over simulated swings of 500 to
/// 20,000 samples (see the tests of the residual's structure).
pub(crate) const NOISE_RELATIVE_STD_ROOT_N: f64 = 1.25;

/// Standard deviation of the noise of a channel, in the unit of the channel.
///
/// Samples that are not finite are gaps. The estimate is never below q/√12 for a channel with resolution
/// q (the standard deviation of a rounding error), nor below 1e-4 of its spread. A channel that
/// never changes gets the smallest positive number that keeps weights finite.
pub fn noise_std(samples: &[f64]) -> f64 {
    noise_by_differences(samples, &[]).std
}

/// The lower limit of [`noise_std`] for a channel. The resolution needs the samples in order, which takes longer than
/// all else about the noise of a dense log: it is computed once for what asks for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseFloor {
    /// The step of a quantised channel, as [`resolution`] finds it.
    pub(crate) resolution: f64,
    /// The smallest standard deviation that the noise can have.
    pub(crate) std: f64,
}

impl NoiseFloor {
    /// The limit for a channel with these samples; those that are not finite are gaps.
    pub(crate) fn of(samples: &[f64]) -> NoiseFloor {
        let finite = samples.iter().copied().filter(|v| v.is_finite());
        let n = finite.clone().count().max(1) as f64;
        let mean = finite.clone().sum::<f64>() / n;
        let spread = (finite.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let resolution = resolution(samples);
        let std = (resolution / 12f64.sqrt())
            .max(RELATIVE_FLOOR * spread)
            .max(1e-12);
        NoiseFloor { resolution, std }
    }
}

/// A noise estimate, and the amount of data behind it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoiseEstimate {
    /// Its standard deviation.
    pub(crate) std: f64,
    /// Number of differences behind the estimate.
    pub(crate) differences: usize,
}

/// As [`noise_std`], with the number of differences. `kinks` are the samples, in rising order, at which the
/// motion has a kink because the current steps there. No difference is taken across a kink.
pub(crate) fn noise_by_differences(samples: &[f64], kinks: &[usize]) -> NoiseEstimate {
    noise_above(&NoiseFloor::of(samples), samples, kinks)
}

/// As [`noise_by_differences`], with the lower limit of these samples.
pub(crate) fn noise_above(floor: &NoiseFloor, samples: &[f64], kinks: &[usize]) -> NoiseEstimate {
    if samples.iter().filter(|v| v.is_finite()).count() < 2 {
        return NoiseEstimate {
            std: 1.0,
            differences: 0,
        };
    }
    let best = without_floor(samples, kinks);
    NoiseEstimate {
        std: best.map_or(floor.std, |best| best.std.max(floor.std)),
        differences: best.map_or(0, |best| best.differences),
    }
}

/// As [`noise_by_differences`], but not raised to a share of the signal's spread; `None` where there are too few samples.
/// It is for what grows without limit, like the angle of a wheel.
pub(crate) fn without_floor(samples: &[f64], kinks: &[usize]) -> Option<NoiseEstimate> {
    let mut best: Option<NoiseEstimate> = None;
    let mut differences = samples.to_vec();
    let mut binomial = 1.0;
    for order in 1..=MAX_ORDER.min(samples.len().saturating_sub(1)) {
        for k in 0..differences.len() - order {
            differences[k] = differences[k + 1] - differences[k];
        }
        let mut kept = differences[..differences.len() - order].to_vec();
        for &kink in kinks {
            // After the kink, the motion is smooth again.
            let across = (kink + 1).saturating_sub(order)..kink.min(kept.len());
            kept[across].fill(f64::NAN);
        }
        // C(2d, d) by its recursion.
        binomial *= (2 * order * (2 * order - 1)) as f64 / (order * order) as f64;
        let Some((mean_square, differences)) = median_of_blocks(&kept) else {
            break;
        };
        let estimate = NoiseEstimate {
            std: (mean_square / binomial).sqrt(),
            differences,
        };
        let scatter = 1.0 / (kept.len() as f64).sqrt();
        match best {
            // A fall by less than the estimate's own scatter does not count.
            Some(previous) if estimate.std > previous.std * (1.0 - scatter) => {
                break;
            }
            _ => best = Some(estimate),
        }
    }
    best
}

/// A difference between neighbouring samples beyond this many standard deviations of a difference is a step of the
/// command. Gaussian noise exceeds it once in 500 million.
const STEP_DEVIATIONS: f64 = 6.0;
/// A difference below this share of the largest current is never a step: it may be the last digit of a
/// quantised column, whose flicker is noise.
const LEAST_STEP_SHARE: f64 = 0.02;
/// Share of the differences that contain no step, even if a command switches at nearly every sample.
const CALM_SHARE: f64 = 0.1;
/// Largest number of rounds of separating steps from noise; each is one pass over the differences.
const ROUNDS: usize = 20;
/// The value z with P(|Z| < z) = [`CALM_SHARE`] for a standard normal Z.
const CALM_QUANTILE: f64 = 0.125_661;

/// A command has a step where it changes by at least this share of its largest value. Smaller changes bend the motion
/// by less than the noise of most sensors, and a smooth command has no larger ones.
const STEP_OF_COMMAND: f64 = 0.1;

/// The samples at which a command has a step; each is the first at the new level.
pub(crate) fn steps_of_command(current_a: &[f64]) -> Vec<usize> {
    let largest = current_a.iter().filter(|current| current.is_finite());
    let largest = largest.fold(0.0f64, |largest, current| largest.max(current.abs()));
    let noise = STEP_DEVIATIONS * std::f64::consts::SQRT_2 * noise_between_steps(current_a);
    let least = noise.max(STEP_OF_COMMAND * largest);
    let steps = |&k: &usize| (current_a[k] - current_a[k - 1]).abs() > least;
    (1..current_a.len()).filter(steps).collect()
}

/// Standard deviation of the noise of a recorded input, in its unit, without the lower limits of [`noise_std`]. A clean
/// command of a few levels therefore has zero noise.
///
/// The result is the smaller of two upper bounds. One comes from third differences, which remove a smooth command. The
/// other comes from the differences that are no steps ([`STEP_DEVIATIONS`]), which removes the levels of a switching
/// command.
pub fn input_noise_std(samples: &[f64]) -> f64 {
    /// C(6, 3)
    const BINOMIAL: f64 = 20.0;
    let third: Vec<f64> = samples
        .windows(4)
        .map(|s| s[3] - 3.0 * s[2] + 3.0 * s[1] - s[0])
        .collect();
    let smooth = median_of_blocks(&third).map_or(0.0, |(square, _)| (square / BINOMIAL).sqrt());
    smooth.min(noise_between_steps(samples))
}

/// Standard deviation of the noise of a command that is held between steps.
fn noise_between_steps(samples: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = samples
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|size| size.is_finite())
        .collect();
    if sizes.is_empty() {
        return 0.0;
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let largest = samples.iter().filter(|value| value.is_finite());
    let largest = largest.fold(0.0f64, |largest, value| largest.max(value.abs()));
    let calm = sizes[(CALM_SHARE * sizes.len() as f64) as usize];
    let mut deviation = calm / CALM_QUANTILE;
    let mut kept = 0;
    for _ in 0..ROUNDS {
        let limit = (STEP_DEVIATIONS * deviation).max(LEAST_STEP_SHARE * largest);
        let count = sizes.partition_point(|size| *size <= limit);
        if count == kept || count == 0 {
            break;
        }
        kept = count;
        let squares: f64 = sizes[..count].iter().map(|size| size * size).sum();
        deviation = (squares / count as f64).sqrt();
    }
    deviation / std::f64::consts::SQRT_2
}

/// Median over blocks of the mean square, with the number of values behind it; `None` if no value is finite.
fn median_of_blocks(values: &[f64]) -> Option<(f64, usize)> {
    let size = (values.len() / BLOCKS).max(8);
    let mut used = 0;
    let mut squares = vec![];
    for block in values.chunks(size) {
        let finite = block.iter().filter(|v| v.is_finite());
        let count = finite.clone().count();
        if 2 * count >= block.len() && count > 0 {
            squares.push(finite.map(|v| v * v).sum::<f64>() / count as f64);
            used += count;
        }
    }
    median(squares).map(|median| (median, used))
}

/// The step of a quantised channel: the smallest difference between two different values, if most other differences are
/// multiples of it. Otherwise 0, since the smallest difference is then accidental (a wheel that gains speed has no two
/// equal samples). Where no value comes twice and nearly all lie one step apart, the step is that of the motion: a wheel
/// that dry friction slows down loses the same speed from sample to sample.
pub fn resolution(samples: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = samples.iter().copied().filter(|v| v.is_finite()).collect();
    if sorted.is_empty() {
        return 0.0;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    let scale = sorted[sorted.len() - 1].abs().max(sorted[0].abs());
    let steps = || {
        let pairs = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        // Rounding in the conversion of units makes equal counts differ in the last bits.
        pairs.filter(|step| *step > 1e-9 * scale)
    };
    let least = steps().fold(f64::INFINITY, f64::min).min(scale);
    let is_multiple = |step: &f64| {
        let times = step / least;
        (times - times.round()).abs() < MULTIPLE
    };
    let multiples = steps().filter(is_multiple).count();
    let (all, single) = (
        steps().count(),
        steps().filter(|step| *step < 1.5 * least).count(),
    );
    let none_comes_twice = all + 1 == sorted.len();
    if none_comes_twice && single as f64 >= MOSTLY * all as f64 {
        return 0.0;
    }
    if multiples as f64 >= MOSTLY * all as f64 {
        least
    } else {
        0.0
    }
}

/// Tolerance for a multiple of a step, in steps: the column may have been rounded after it had been quantised.
const MULTIPLE: f64 = 0.1;
/// Share of all differences that must be multiples of the step. Of random differences, a fifth are.
const MOSTLY: f64 = 0.9;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};

    #[test]
    fn white_noise_on_a_swing_is_recovered_within_five_percent() {
        for seed in 0..50 {
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let noise = Normal::new(0.0, 1.2e-3).expect("positive");
            let samples: Vec<f64> = (0..7500)
                .map(|k| 0.35 * (10.3 * 0.004 * k as f64).sin() + noise.sample(&mut rng))
                .collect();
            let ratio = noise_std(&samples) / 1.2e-3;
            assert!((ratio - 1.0).abs() < 0.06, "seed {seed}: {ratio}");
        }
    }

    #[test]
    fn a_quantised_quiet_log_has_the_noise_of_its_rounding() {
        let samples: Vec<f64> = (0..1500)
            .map(|k| ((0.3 * (0.1 * k as f64).sin()) / 0.01).round() * 0.01)
            .collect();
        let ratio = noise_std(&samples) / (0.01 / 12f64.sqrt());
        assert!((0.99..1.4).contains(&ratio), "{ratio}");
    }

    /// In a coast-down with dry friction, or of a wheel that is logged once a turn, equal steps are those of the motion.
    #[test]
    fn a_steady_fall_is_not_taken_for_steps_of_the_sensor() {
        for seed in 0..20 {
            let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
            let noise = Normal::new(0.0, 5e-4).expect("positive");
            let mut fall = |lost: usize| -> Vec<f64> {
                (0..150)
                    .filter(|k| lost == 0 || k % lost != 0)
                    .map(|k| 15.0 - 0.075 * k as f64 + noise.sample(&mut rng))
                    .collect()
            };
            for lost in [0, 40] {
                let samples = fall(lost);
                assert_eq!(resolution(&samples), 0.0, "seed {seed}, lost {lost}");
            }
            let ratio = noise_std(&fall(0)) / 5e-4;
            assert!((0.6..1.6).contains(&ratio), "seed {seed}: {ratio}");
        }
    }

    #[test]
    fn a_slow_fall_in_steps_of_the_sensor_keeps_them() {
        for slope in [0.3, 0.7, 1.3] {
            let samples: Vec<f64> = (0..200)
                .map(|k| {
                    let counts = 1500.0 - slope * f64::from(k);
                    counts.round() * 0.01
                })
                .collect();
            let step = resolution(&samples);
            assert!((step / 0.01 - 1.0).abs() < 1e-6, "{slope}: {step}");
        }
    }

    #[test]
    fn degenerate_channels_give_a_usable_number() {
        for samples in [vec![], vec![1.0], vec![0.0; 100], vec![f64::NAN; 30]] {
            let noise = noise_std(&samples);
            assert!(noise > 0.0 && noise.is_finite());
        }
    }
}
