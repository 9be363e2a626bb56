//! The noise of a sensor, estimated from the log alone.
//!
//! Differences of order d annihilate every polynomial of degree below d, so that what is left of a
//! smooth motion falls quickly with d while white noise of standard deviation σ keeps the variance
//! σ² C(2d, d) (Kendall & Stuart, vol. 3, "variate-difference method"). The order is raised until
//! the estimate no longer falls. The median over blocks keeps pushes and jolts out of it.

use super::statistics::median;

/// Highest order of difference that is tried.
const MAX_ORDER: usize = 10;
/// Number of blocks over which the median is taken.
const BLOCKS: usize = 20;
/// Fraction of the signal's spread below which no model of a bench is believed, however quiet its
/// log: it stands for the error of the integration and of the log's own rounding.
const RELATIVE_FLOOR: f64 = 1e-4;

/// Standard deviation of the noise of a channel, in the unit of the channel.
///
/// Samples that are not finite are gaps. The estimate is never below the resolution q of the
/// channel (q/√12, the standard deviation of a rounding error) nor below 1e-4 of its spread; a
/// channel that never changes gets the smallest positive number that keeps weights finite.
pub fn noise_std(samples: &[f64]) -> f64 {
    let finite: Vec<f64> = samples.iter().copied().filter(|v| v.is_finite()).collect();
    if finite.len() < 2 {
        return 1.0;
    }
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    let spread =
        (finite.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / finite.len() as f64).sqrt();
    let floor = (resolution(&finite) / 12f64.sqrt())
        .max(RELATIVE_FLOOR * spread)
        .max(1e-12);

    let mut best: Option<f64> = None;
    let mut differences = samples.to_vec();
    let mut binomial = 1.0;
    for order in 1..=MAX_ORDER {
        for k in 0..differences.len() - order {
            differences[k] = differences[k + 1] - differences[k];
        }
        let kept = &differences[..differences.len() - order];
        // C(2d, d) by its recursion.
        binomial *= (2 * order * (2 * order - 1)) as f64 / (order * order) as f64;
        let Some(mean_square) = median_of_blocks(kept) else {
            break;
        };
        let estimate = (mean_square / binomial).sqrt();
        match best {
            // A fall of less than the estimate's own scatter is no fall.
            Some(previous) if estimate > previous * (1.0 - 1.0 / (kept.len() as f64).sqrt()) => {
                break;
            }
            _ => best = Some(estimate),
        }
    }
    best.unwrap_or(floor).max(floor)
}

/// Standard deviation of the noise of a recorded input, in its unit: third differences alone, without the
/// floors of [`noise_std`], so that a clean command of a few levels has none.
pub fn input_noise_std(samples: &[f64]) -> f64 {
    /// C(6, 3)
    const BINOMIAL: f64 = 20.0;
    let third: Vec<f64> = samples
        .windows(4)
        .map(|s| s[3] - 3.0 * s[2] + 3.0 * s[1] - s[0])
        .collect();
    median_of_blocks(&third).map_or(0.0, |mean_square| (mean_square / BINOMIAL).sqrt())
}

/// Median over blocks of the mean square; `None` if nothing finite is left.
fn median_of_blocks(values: &[f64]) -> Option<f64> {
    let size = (values.len() / BLOCKS).max(8);
    let squares = values.chunks(size).filter_map(|block| {
        let finite = block.iter().filter(|v| v.is_finite());
        let count = finite.clone().count();
        (2 * count >= block.len() && count > 0)
            .then(|| finite.map(|v| v * v).sum::<f64>() / count as f64)
    });
    median(squares)
}

/// The smallest step between two different values: the resolution of a quantised channel (and a
/// tiny number for a channel whose values are all different).
pub fn resolution(samples: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = samples.iter().copied().filter(|v| v.is_finite()).collect();
    if sorted.is_empty() {
        return 0.0;
    }
    sorted.sort_by(f64::total_cmp);
    let scale = sorted[sorted.len() - 1].abs().max(sorted[0].abs());
    sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        // Rounding in the conversion of units makes equal counts differ in the last bits.
        .filter(|step| *step > 1e-9 * scale)
        .fold(f64::INFINITY, f64::min)
        .min(scale)
}

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

    #[test]
    fn degenerate_channels_give_a_usable_number() {
        for samples in [vec![], vec![1.0], vec![0.0; 100], vec![f64::NAN; 30]] {
            let noise = noise_std(&samples);
            assert!(noise > 0.0 && noise.is_finite());
        }
    }
}
