//! A swing divided into half cycles: zero crossings, and the peaks between them. Each is fitted to many samples.
//!
//! Between two crossings, the angle is fitted with the first two harmonics of a pendulum,
//! A (cos θ − A²/192 cos 3θ) (the third harmonic from Duffing's equation with the cubic term of the sine;
//! Nayfeh & Mook, *Nonlinear Oscillations*, 1979, 2.3). Around zero, it is fitted with a sine. Each number comes from
//! many samples, so neither noise nor the steps of an encoder have much influence.

use nalgebra::{Matrix2, Vector2};

/// Samples belong to the peak where the cosine of the phase exceeds this value (within 60° of the peak).
const PEAK_PART: f64 = 0.5;
/// Samples belong to the crossing where the sine of the phase is below this value (within 30°).
const CROSSING_PART: f64 = 0.5;

/// A zero crossing.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    pub(super) time_s: f64,
    pub(super) variance_s2: f64,
}

/// The peak between two crossings.
#[derive(Clone, Copy)]
pub(super) struct Peak {
    pub(super) time_s: f64,
    /// Angle at the peak, rad, with its sign.
    pub(super) angle: f64,
    pub(super) variance: f64,
}

/// All crossings, and the peaks between them: peak k lies between crossings k and k + 1.
pub(super) fn half_cycles(
    samples: &[(f64, f64)],
    least: f64,
    noise: f64,
    quantum: Option<f64>,
) -> (Vec<Crossing>, Vec<Peak>) {
    // Rough crossings: a change of sign counts once the angle is clear of the noise.
    let clear = 0.5 * least;
    let mut rough: Vec<f64> = vec![];
    let mut side = 0.0;
    let mut last_zero = 0.0;
    for pair in samples.windows(2) {
        let ((t0, x0), (t1, x1)) = (pair[0], pair[1]);
        if x0 * x1 <= 0.0 && x0 != x1 {
            last_zero = t0 + (t1 - t0) * x0 / (x0 - x1);
        }
        if x1.abs() > clear && x1.signum() != side {
            if side != 0.0 {
                rough.push(last_zero);
            }
            side = x1.signum();
        }
    }
    let within = |from: f64, to: f64| {
        let first = samples.partition_point(|sample| sample.0 < from);
        let last = samples.partition_point(|sample| sample.0 <= to);
        &samples[first..last.max(first)]
    };
    // Samples on the same step of the encoder count as one value.
    let inflation = |count: usize, range: f64| match quantum {
        Some(quantum) => (count as f64 / (1.0 + range / quantum)).max(1.0),
        None => 1.0,
    };
    let mut peaks: Vec<Peak> = vec![];
    for pair in rough.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let omega = std::f64::consts::PI / (to - from);
        let middle = 0.5 * (from + to);
        let reach = PEAK_PART.acos() / omega;
        let part = within(middle - reach, middle + reach);
        let highest = part.iter().map(|sample| sample.1.abs()).fold(0.0, f64::max);
        let Some(peak) = fit_two(part, |t, amplitude: f64| {
            let theta = omega * (t - middle);
            let third = amplitude * amplitude / 192.0;
            (theta.cos() - third * (3.0 * theta).cos(), theta.sin())
        }) else {
            break;
        };
        let angle = peak.0 * (1.0 - peak.0 * peak.0 / 192.0);
        let delay = (peak.1 / peak.0).atan() / omega;
        peaks.push(Peak {
            time_s: middle + delay.clamp(-reach, reach),
            angle,
            variance: noise * noise * peak.2 * inflation(part.len(), (1.0 - PEAK_PART) * highest),
        });
    }
    let mut crossings: Vec<Crossing> = vec![];
    for (index, &zero) in rough.iter().enumerate() {
        let before = index.checked_sub(1).and_then(|k| peaks.get(k));
        let after = peaks.get(index);
        let (Some(peak), spacing) = (
            after.or(before),
            match (rough.get(index + 1), index.checked_sub(1)) {
                (Some(next), Some(k)) => 0.5 * (next - rough[k]),
                (Some(next), None) => next - zero,
                (None, Some(k)) => zero - rough[k],
                (None, None) => break,
            },
        ) else {
            break;
        };
        let omega = std::f64::consts::PI / spacing;
        let reach = CROSSING_PART.asin() / omega;
        let part = within(zero - reach, zero + reach);
        let Some(fit) = fit_two(part, |t, _| {
            let theta = omega * (t - zero);
            (theta.sin(), theta.cos())
        }) else {
            break;
        };
        let slope = fit.0 * omega;
        let range = 2.0 * CROSSING_PART * peak.angle.abs();
        crossings.push(Crossing {
            time_s: zero - (fit.1 / slope).clamp(-reach, reach),
            variance_s2: noise * noise * fit.3 / (slope * slope) * inflation(part.len(), range),
        });
    }
    let count = crossings.len().saturating_sub(1).min(peaks.len());
    peaks.truncate(count);
    crossings.truncate(count + 1);
    (crossings, peaks)
}

/// Least squares with two functions of time (the first may depend on its own coefficient). Returns both
/// coefficients, and their variances for noise of variance 1.
fn fit_two(
    samples: &[(f64, f64)],
    functions: impl Fn(f64, f64) -> (f64, f64),
) -> Option<(f64, f64, f64, f64)> {
    if samples.len() < 3 {
        return None;
    }
    let mut found = (0.0, 0.0, 0.0, 0.0);
    for _ in 0..3 {
        let (mut square, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for &(t, x) in samples {
            let (f, g) = functions(t, found.0);
            let row = Vector2::new(f, g);
            square += row * row.transpose();
            right += row * x;
        }
        let inverse = square.try_inverse()?;
        let solution = inverse * right;
        found = (solution[0], solution[1], inverse[(0, 0)], inverse[(1, 1)]);
    }
    found.0.is_finite().then_some(found)
}

/// The part of the swing from its largest peak until it disappears in the noise. Before the largest peak, the body
/// was pushed by hand.
pub(super) fn dying_part(
    (crossings, peaks): (Vec<Crossing>, Vec<Peak>),
) -> (Vec<Crossing>, Vec<Peak>) {
    let Some(largest) =
        (0..peaks.len()).max_by(|&a, &b| peaks[a].angle.abs().total_cmp(&peaks[b].angle.abs()))
    else {
        return (vec![], vec![]);
    };
    let end = (largest..peaks.len())
        .find(|&k| peaks[k].angle.abs() < 5.0 * peaks[k].variance.sqrt())
        .unwrap_or(peaks.len());
    (
        crossings[largest..=end].to_vec(),
        peaks[largest..end].to_vec(),
    )
}
