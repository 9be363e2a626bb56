//! The weak form of an equation of motion: the equation is multiplied by a test function ("bump")
//! ψ = (t − a)² (b − t)², which vanishes with its derivative at both ends of a short interval, and integrated by parts.
//! The result holds for the measured series, so no noise is differentiated (modulating functions; Shinbrot,
//! Trans. ASME 79 (1957)).
//!
//! There are two quadratures. [`bumps`] applies the trapezoidal rule over the samples to ψ and its first two
//! derivatives. [`Bump`] has weights over the intervals between samples, which sum to 1, so that a constant
//! acceleration is exact with any number of samples.

use std::cell::OnceCell;

use super::record::Record;

/// Length of a bump in s: well below a period of the pendulum, and long enough to average the noise.
pub(crate) const BUMP_S: f64 = 0.4;
/// Smallest number of samples under a bump.
const BUMP_SAMPLES: usize = 12;

/// Smallest number of samples on either side of the centre of a bump.
pub(crate) const FEWEST_HALF_SAMPLES: usize = 4;

/// ψ at time t for a bump from a to b, or its derivative of order 1 or 2.
fn bump(t: f64, (a, b): (f64, f64), order: usize) -> f64 {
    let (u, v) = (t - a, b - t);
    match order {
        0 => u * u * v * v,
        1 => 2.0 * u * v * (v - u),
        _ => 2.0 * (v * v - 4.0 * u * v + u * u),
    }
}

/// One bump over some samples of a record.
pub struct WeakForm<'b> {
    start: usize,
    /// Weights of the samples for ψ and its first two derivatives.
    weights: &'b [OnceCell<Vec<f64>>; 3],
    time_s: &'b [f64],
}

impl WeakForm<'_> {
    /// ∫ f dᵒψ/dtᵒ dt by the trapezoidal rule, corrected at the ends for the first order, for the samples f of a channel
    /// of the whole record. The order o is 0, 1 or 2 (larger ones count as 2).
    pub fn integral(&self, samples: &[f64], order: usize) -> f64 {
        let weights = self.weights(order);
        let samples = &samples[self.start..self.start + weights.len()];
        // Four sums side by side: each waits for its own last addition only.
        let mut sums = [0.0; 4];
        let (of_weights, of_samples) = (weights.chunks_exact(4), samples.chunks_exact(4));
        let rest: f64 = of_weights
            .remainder()
            .iter()
            .zip(of_samples.remainder())
            .map(|(weight, value)| weight * value)
            .sum();
        for (weights, values) in of_weights.zip(of_samples) {
            for (sum, (weight, value)) in sums.iter_mut().zip(weights.iter().zip(values)) {
                *sum += weight * value;
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
    }

    /// As [`WeakForm::integral`], for a function of the sample's index in the record.
    pub fn integral_of(&self, f: impl Fn(usize) -> f64, order: usize) -> f64 {
        dot(self.weights(order), (self.start..).map(f))
    }

    /// ∫ ψ dt, the weight of a constant.
    pub fn area(&self) -> f64 {
        self.weights(0).iter().sum()
    }

    fn weights(&self, order: usize) -> &[f64] {
        let order = order.min(2);
        self.weights[order].get_or_init(|| quadrature(self.time_s, order))
    }
}

/// Calls `each` for every bump. A bump lasts `bump_s` seconds, and at least twelve samples. Neighbouring bumps overlap by
/// half.
pub fn bumps(record: &Record, bump_s: f64, mut each: impl FnMut(&WeakForm)) {
    let n = record.len();
    if n < BUMP_SAMPLES {
        return;
    }
    let mean_step = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
    let length = ((bump_s / mean_step).round() as usize).clamp(BUMP_SAMPLES, n);
    let is_whole = |start: usize| {
        let mut weights = record.weight[start..start + length].iter();
        weights.all(|weight| *weight > 0.0)
    };
    let mut starts = (0..=n - length)
        .step_by((length / 2).max(1))
        .filter(|&start| is_whole(start));
    let mut next = starts.next();
    while let Some(first) = next {
        // The weights depend on the intervals between samples alone. An even clock has them once for all bumps.
        let time_s = &record.time_s[first..first + length];
        let weights: [OnceCell<Vec<f64>>; 3] = Default::default();
        while let Some(start) = next
            && (start == first || is_shifted(time_s, &record.time_s[start..start + length]))
        {
            each(&WeakForm {
                start,
                weights: &weights,
                time_s,
            });
            next = starts.next();
        }
    }
}

/// Whether two lists of times have the same intervals. Times in a file are rounded; a millionth of a step changes nothing.
fn is_shifted(first: &[f64], second: &[f64]) -> bool {
    let shift = second[0] - first[0];
    let last = first.len() - 1;
    let least = 1e-6 * (first[last] - first[0]) / last as f64;
    let mut pairs = first.iter().zip(second);
    pairs.all(|(a, b)| (b - a - shift).abs() <= least)
}

/// The weights of the samples at these times in ∫ f dᵒψ/dtᵒ dt for a bump over all of them, divided by (T/2)⁴ with its
/// length T. They are those of the trapezoidal rule, corrected at the ends for the first order.
fn quadrature(time_s: &[f64], order: usize) -> Vec<f64> {
    let last = time_s.len() - 1;
    let (a, b) = (time_s[0], time_s[last]);
    let scale = ((b - a) / 2.0).powi(4);
    let mut weights: Vec<f64> = (0..=last)
        .map(|k| {
            let span = time_s[(k + 1).min(last)] - time_s[k.saturating_sub(1)];
            0.5 * span * bump(time_s[k], (a, b), order) / scale
        })
        .collect();
    if order == 1 {
        // Euler–Maclaurin: dψ/dt vanishes at the ends, but its slope 2 (b − a)² does not.
        let slope = 2.0 * (b - a).powi(2) / 12.0 / scale;
        weights[0] += (time_s[1] - a).powi(2) * slope;
        weights[last] -= (b - time_s[last - 1]).powi(2) * slope;
    }
    weights
}

/// The weights of a bump over the intervals from `centre − half` to `centre + half`, and over the
/// samples between them. Each set sums to 1.
///
/// With v linear between samples, ∫ψ̇ v = −Σ (Δv/Δt) ∫ψ. The integration by parts is exact for the samples
/// themselves, so a constant acceleration is exact with any number of samples.
pub(crate) struct Bump {
    /// Weights of the `2 half` intervals.
    pub(crate) intervals: Vec<f64>,
    /// Weights of the `2 half − 1` samples between them.
    pub(crate) samples: Vec<f64>,
}

impl Bump {
    /// The bump centred at a sample.
    pub(crate) fn around(time_s: &[f64], centre: usize, half: usize) -> Bump {
        let (a, b) = (time_s[centre - half], time_s[centre + half]);
        // The same ψ as in `bump`, with the factors in another order. The order affects the last bits, and these decide into
        // which bin the equal values of a quantised log fall, which changes a bin's share of an error by percents.
        let bump = |t: f64| ((t - a) * (b - t)).powi(2);
        let span = centre - half..centre + half;
        let mut intervals: Vec<f64> = span
            .clone()
            .map(|k| bump(0.5 * (time_s[k] + time_s[k + 1])) * (time_s[k + 1] - time_s[k]))
            .collect();
        let mut samples: Vec<f64> = span
            .skip(1)
            .map(|k| bump(time_s[k]) * 0.5 * (time_s[k + 1] - time_s[k - 1]))
            .collect();
        for weights in [&mut intervals, &mut samples] {
            let area: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= area);
        }
        Bump { intervals, samples }
    }
}

/// A weighted sum.
pub(crate) fn dot(weights: &[f64], values: impl Iterator<Item = f64>) -> f64 {
    weights.iter().zip(values).map(|(w, v)| w * v).sum()
}

/// A half-width in samples, at least [`FEWEST_HALF_SAMPLES`].
pub(crate) fn half_samples(record: &Record, half_s: f64) -> usize {
    let n = record.len();
    let mean_step_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1).max(1) as f64;
    ((half_s / mean_step_s).round() as usize).clamp(FEWEST_HALF_SAMPLES, n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::Kind;

    /// Every bump has the integrals of its own times, whether the clock is even, is rounded, changes its pace, or jitters;
    /// a bump with a sample that does not count is left out.
    #[test]
    fn each_bump_has_the_weights_of_its_own_times() {
        let even = |k: usize| 0.004 * k as f64;
        let clocks: [&dyn Fn(usize) -> f64; 4] = [
            &even,
            &|k| (even(k) * 1e9).round() / 1e9,
            &|k| even(k) + 0.002 * k.saturating_sub(700) as f64,
            &|k| even(k) + 0.001 * (k as f64 * 1.7).sin(),
        ];
        for (clock, time) in clocks.iter().enumerate() {
            let time_s: Vec<f64> = (0..1500).map(time).collect();
            let angle: Vec<f64> = time_s.iter().map(|t| 0.3 + (9.7 * t).cos()).collect();
            let outputs = [Some(angle.clone()), None, None];
            let mut record = Record::new("x", Kind::FreeSwing, time_s, outputs, None, false);
            record.weight[400] = 0.0;
            let mut starts = vec![];
            bumps(&record, BUMP_S, |bump| {
                let length = bump.weights(0).len();
                let window = bump.start..bump.start + length;
                let area: f64 = bump.area();
                for order in 0..3 {
                    let own = quadrature(&record.time_s[window.clone()], order);
                    let expected = dot(&own, angle[window.clone()].iter().copied());
                    let size: f64 = own.iter().map(|weight| weight.abs()).sum();
                    for found in [
                        bump.integral(&angle, order),
                        bump.integral_of(|k| angle[k], order),
                    ] {
                        let off = (found - expected).abs() / size;
                        assert!(off < 1e-6, "clock {clock}, order {order}: {off}");
                    }
                }
                // ∫ψ over a bump of length T is T⁵/30, in units of (T/2)⁴.
                let span_s = record.time_s[window.end - 1] - record.time_s[window.start];
                assert!((area / (span_s * 16.0 / 30.0) - 1.0).abs() < 0.02);
                assert!(!window.contains(&400));
                starts.push((bump.start, length));
            });
            let length = starts[0].1;
            let expected: Vec<(usize, usize)> = (0..=1500 - length)
                .step_by(length / 2)
                .filter(|start| !(*start..start + length).contains(&400))
                .map(|start| (start, length))
                .collect();
            assert_eq!(starts, expected, "clock {clock}");
        }
    }
}
