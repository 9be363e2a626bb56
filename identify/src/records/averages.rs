//! Averages over blocks of samples, for logs that are far denser than their motion.
//!
//! A pendulum with a period of 0.6 s sampled at 1000 Hz gives no more information than averages over ten samples, whose
//! noise is √10 times smaller. The fit then has a tenth of the work. The current keeps all its samples.
//!
//! The mean over a block differs from the value in its middle. For m samples with spacing h, it is larger by ½ s² y″ with
//! s² = (m² − 1) h²/12, the variance of the sampling times. This bias is subtracted, with y″ from a parabola through
//! nine blocks (Savitzky & Golay, Anal. Chem. 36 (1964)). The noise of y″ raises the noise of a block by half a percent. For a
//! swing in blocks of a sixtieth of its period, the correction reduces the bias from 4.6e-4 of the amplitude to some 1e-5.

use std::ops::Range;

/// Weights that give y″ in the middle of nine equally spaced values, multiplied by their spacing squared.
const SECOND_DERIVATIVE: [f64; 9] = [28.0, 7.0, -8.0, -17.0, -20.0, -17.0, -8.0, 7.0, 28.0];
const DIVISOR: f64 = 462.0;
/// Number of blocks on either side of the middle one.
const HALF: usize = SECOND_DERIVATIVE.len() / 2;

/// Divides `n` samples into ranges of `block` samples. A remainder forms its own block if it has at least half as many
/// samples; otherwise it is joined to the last block.
pub(crate) fn blocks(n: usize, block: usize) -> Vec<Range<usize>> {
    let mut blocks: Vec<Range<usize>> = (0..n)
        .step_by(block.max(1))
        .map(|start| start..(start + block).min(n))
        .collect();
    if blocks.len() > 1
        && let Some(rest) = blocks.pop_if(|last| 2 * last.len() < block)
        && let Some(last) = blocks.last_mut()
    {
        last.end = rest.end;
    }
    blocks
}

/// The mean of the finite samples; NaN if fewer than half are finite.
fn mean(samples: &[f64]) -> f64 {
    let finite = samples.iter().filter(|sample| sample.is_finite());
    let count = finite.clone().count();
    if 2 * count < samples.len() {
        return f64::NAN;
    }
    finite.sum::<f64>() / count as f64
}

/// The mean of every block.
pub(crate) fn means(samples: &[f64], blocks: &[Range<usize>]) -> Vec<f64> {
    let of_block = |block: &Range<usize>| mean(&samples[block.clone()]);
    blocks.iter().map(of_block).collect()
}

/// The values in the middle of blocks, from the blocks' means; NaN for a block in which the motion has a kink. If the
/// nine blocks around a block are not all present and smooth, y″ is taken from the nearest block where they are, up to
/// four blocks away; if there is none, the mean is returned uncorrected.
pub(crate) fn middles(samples: &[f64], blocks: &[Range<usize>], kinks: &[usize]) -> Vec<f64> {
    let means = means(samples, blocks);
    let kinks_in = |span: Range<usize>| {
        // After the kink, the motion is smooth again.
        let first = kinks.partition_point(|&kink| kink <= span.start);
        kinks.get(first).is_some_and(|&kink| kink < span.end)
    };
    let curvatures: Vec<f64> = (0..means.len())
        .map(|at| {
            if at < HALF || at + HALF >= means.len() {
                return f64::NAN;
            }
            let near = at - HALF..at + HALF + 1;
            if kinks_in(blocks[near.start].start..blocks[near.end - 1].end) {
                return f64::NAN;
            }
            let weighted = means[near].iter().zip(SECOND_DERIVATIVE);
            weighted.map(|(value, weight)| weight * value).sum::<f64>() / DIVISOR
        })
        .collect();
    let length = blocks.first().map_or(1, Range::len) as f64;
    // s²/2, divided by the square of the spacing of the blocks.
    let share = (length * length - 1.0) / (24.0 * length * length);
    (0..means.len())
        .map(|at| {
            if kinks_in(blocks[at].clone()) {
                return f64::NAN;
            }
            let nearest = (0..=HALF)
                .flat_map(|away| [at.checked_sub(away), Some(at + away)])
                .flatten()
                .filter_map(|near| curvatures.get(near))
                .find(|curvature| curvature.is_finite());
            means[at] - share * nearest.unwrap_or(&0.0)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_lie_end_to_end_and_none_is_short() {
        for n in [1, 7, 95, 100, 104, 106] {
            let blocks = blocks(n, 10);
            let mut end = 0;
            for block in &blocks {
                assert_eq!(block.start, end);
                end = block.end;
                assert!(n < 5 || block.len() >= 5, "{n}: {blocks:?}");
            }
            assert_eq!(end, n);
        }
    }

    /// In blocks of a sixtieth of a period the middle of a swing is found to 2e-5 of its amplitude, where the mean is
    /// 4.6e-4 below it.
    #[test]
    fn the_middle_of_a_block_is_not_its_mean() {
        let omega = std::f64::consts::TAU / 600.0;
        let value = |t: f64| (omega * t).cos();
        let samples: Vec<f64> = (0..6000).map(|k| value(f64::from(k))).collect();
        let blocks = blocks(samples.len(), 10);
        let (means, middles) = (means(&samples, &blocks), middles(&samples, &blocks, &[]));
        let (mut of_means, mut of_middles) = (0.0f64, 0.0f64);
        for at in HALF..blocks.len() - HALF {
            let truth = value(blocks[at].start as f64 + 4.5);
            of_means = of_means.max((means[at] - truth).abs());
            of_middles = of_middles.max((middles[at] - truth).abs());
        }
        assert!((4e-4..5e-4).contains(&of_means), "{of_means}");
        assert!(of_middles < 2e-5, "{of_middles}");
    }

    #[test]
    fn gaps_and_kinks_are_left_out() {
        let mut samples: Vec<f64> = (0..200).map(|k| f64::from(k * k)).collect();
        samples[55..65].fill(f64::NAN);
        let blocks = blocks(200, 10);
        let line: Vec<f64> = (0..200).map(|k| f64::from(k * k)).collect();
        let means = means(&samples, &blocks);
        assert!(means[5].is_finite(), "half of the block is there");
        samples[50..65].fill(f64::NAN);
        assert!(self::means(&samples, &blocks)[5].is_nan());
        // The parabola's own curvature, everywhere but where it is too far away, and in the block of the kink.
        let kinked = middles(&line, &blocks, &[145]);
        assert!(kinked[14].is_nan() && kinked[13].is_finite() && kinked[15].is_finite());
        for (at, middle) in middles(&line, &blocks, &[]).iter().enumerate() {
            let truth = (10.0 * at as f64 + 4.5).powi(2);
            assert!((middle - truth).abs() < 1e-8, "{at}: {middle} {truth}");
        }
    }
}
