//! How a free swing dies out: amplitude, decay and period, half cycle by half cycle, from the angle
//! alone and without a model.
//!
//! Between two zero crossings the angle is fitted with the first two harmonics of a pendulum,
//! A (cos θ − A²/192 cos 3θ) (the third one from Duffing's equation with the cubic term of the sine;
//! Nayfeh & Mook, *Nonlinear Oscillations*, 1979, 2.3), around zero with a sine: many samples for
//! each number, so that neither noise nor the steps of an encoder matter much. Opposite half cycles
//! are averaged, and so are periods between rising and between falling crossings, which removes the
//! unknown zero of the angle.
//!
//! The decay is compared with dA/dt = −(C + V A + Q A²): C = 4 μ/(G T) for dry friction, V = r_b/(2 Θ)
//! for viscous friction, Q = 4 c ω/(3 π Θ) for quadratic drag (energy lost in a cycle; Nayfeh & Mook,
//! 3.3). The period of small swings follows from the measured one through the complete elliptic
//! integral, T₀ = T agm(1, cos(A/2)) (Abramowitz & Stegun 17.6.3). No friction that depends on speed
//! alone changes it; a contact that bends before it slides, or a spring, does.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix2, Vector2};
use plant::Kind;

use crate::record::{Output, Record};
use crate::start::angle_samples;

/// A number with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error, same unit.
    pub std: f64,
}

/// Something at an amplitude of the swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtAmplitude {
    /// Time, s.
    pub time_s: f64,
    /// Amplitude of the swing, rad.
    pub amplitude_rad: f64,
    /// The quantity.
    pub value: f64,
    /// Its standard error.
    pub std: f64,
}

/// A law dA/dt = −(C + V A + Q A²), fitted with some of its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecayLaw {
    /// Which of C, V and Q are there.
    pub has: [bool; 3],
    /// C in rad/s, V in 1/s, Q in 1/(rad s); those that are not there are 0.
    pub coefficients: [Estimate; 3],
    /// Root mean square of what it leaves of the amplitudes, rad.
    pub rms_rad: f64,
    /// The same relative to the amplitude.
    pub relative_rms: f64,
    /// Bayesian information criterion n ln(rms²) + p ln n over the half cycles: lower is better.
    pub criterion: f64,
}

/// How a free swing dies out.
#[derive(Clone, Debug)]
pub struct Decay {
    /// Amplitude (value, rad) of each pair of half cycles.
    pub amplitudes: Vec<AtAmplitude>,
    /// Relative decay rate −Ȧ/A in 1/s.
    pub rates: Vec<AtAmplitude>,
    /// Measured period in s.
    pub periods: Vec<AtAmplitude>,
    /// Period of small swings in s: the measured one without the effect of the amplitude.
    pub small_swing_periods: Vec<AtAmplitude>,
    /// Every law of one, two or three terms whose coefficients are not negative beyond their errors,
    /// the best one first.
    pub laws: Vec<DecayLaw>,
    /// Change of the period of small swings from the largest to the smallest amplitude, percent.
    pub period_drift_percent: Estimate,
}

/// Half cycles below this many standard deviations of the noise are not used,
const LEAST_OVER_NOISE: f64 = 5.0;
/// nor those below this many steps of a quantised angle.
const LEAST_OVER_QUANTUM: f64 = 3.0;
/// Fewest half cycles from which anything is said.
const FEWEST_HALF_CYCLES: usize = 8;
/// Cosine of the phase up to which a half cycle belongs to its peak (60°).
const PEAK_PART: f64 = 0.5;
/// Sine of the phase up to which it belongs to the crossing (30°).
const CROSSING_PART: f64 = 0.5;

/// Periods at both ends of the swing that are averaged for the drift.
const DRIFT_PERIODS: usize = 5;

/// A zero crossing.
#[derive(Clone, Copy)]
struct Crossing {
    time_s: f64,
    variance_s2: f64,
}

/// The peak between two crossings.
#[derive(Clone, Copy)]
struct Peak {
    time_s: f64,
    /// With its sign.
    angle: f64,
    variance: f64,
}

/// The decay of a free swing; `None` where fewer than eight half cycles stand out of the noise, or
/// for other kinds of experiment.
pub fn decay(record: &Record) -> Option<Decay> {
    if record.kind != Kind::FreeSwing {
        return None;
    }
    let angle = angle_samples(record)?;
    let channel = record.channel(Output::Angle);
    let noise = channel.map_or_else(|| crate::noise_std(&angle), |channel| channel.noise_std);
    let quantum = channel.and_then(|channel| channel.quantum);
    let mut samples: Vec<(f64, f64)> = record
        .time_s
        .iter()
        .zip(&angle)
        .zip(&record.weight)
        .filter(|((_, angle), weight)| angle.is_finite() && **weight > 0.0)
        .map(|((time, angle), _)| (*time, *angle))
        .collect();
    let least = f64::max(
        LEAST_OVER_NOISE * noise,
        LEAST_OVER_QUANTUM * quantum.unwrap_or(0.0),
    );
    // The zero of the angle: first the middle of the range, then what makes opposite peaks equal.
    let (low, high) = samples
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, x)| {
            (low.min(*x), high.max(*x))
        });
    shift(&mut samples, 0.5 * (low + high));
    let mut found = half_cycles(&samples, least, noise, quantum);
    for _ in 0..2 {
        let mut middles: Vec<f64> = found
            .1
            .windows(3)
            .map(|three| 0.25 * (three[0].angle + 2.0 * three[1].angle + three[2].angle))
            .collect();
        if middles.is_empty() {
            return None;
        }
        middles.sort_by(f64::total_cmp);
        shift(&mut samples, middles[middles.len() / 2]);
        found = half_cycles(&samples, least, noise, quantum);
    }
    let (crossings, peaks) = dying_part(found);
    if peaks.len() < FEWEST_HALF_CYCLES {
        return None;
    }
    let amplitudes: Vec<AtAmplitude> = peaks
        .windows(2)
        .map(|pair| {
            let amplitude = 0.5 * (pair[0].angle - pair[1].angle).abs();
            AtAmplitude {
                time_s: 0.5 * (pair[0].time_s + pair[1].time_s),
                amplitude_rad: amplitude,
                value: amplitude,
                std: 0.5 * (pair[0].variance + pair[1].variance).sqrt(),
            }
        })
        .collect();
    let rates = amplitudes
        .windows(3)
        .map(|three| {
            // Non-overlapping peaks: the first pair and the third.
            let (a, b) = (three[0], three[2]);
            let amplitude = 0.5 * (a.value + b.value);
            let scale = 1.0 / ((b.time_s - a.time_s) * amplitude);
            AtAmplitude {
                time_s: three[1].time_s,
                amplitude_rad: amplitude,
                value: (a.value - b.value) * scale,
                std: a.std.hypot(b.std) * scale,
            }
        })
        .collect();
    let periods: Vec<AtAmplitude> = crossings
        .windows(4)
        .zip(peaks.windows(3))
        .map(|(c, p)| AtAmplitude {
            time_s: 0.5 * (c[1].time_s + c[2].time_s),
            amplitude_rad: 0.25 * (p[0].angle - 2.0 * p[1].angle + p[2].angle).abs(),
            value: 0.5 * (c[3].time_s + c[2].time_s - c[1].time_s - c[0].time_s),
            std: 0.5 * c.iter().map(|c| c.variance_s2).sum::<f64>().sqrt(),
        })
        .collect();
    let small_swing_periods: Vec<AtAmplitude> = periods
        .iter()
        .map(|point| {
            let factor = agm(1.0, (0.5 * point.amplitude_rad).cos());
            AtAmplitude {
                value: point.value * factor,
                std: point.std * factor,
                ..*point
            }
        })
        .collect();
    let period_drift_percent = drift(&small_swing_periods, &crossings);
    Some(Decay {
        laws: laws(&amplitudes),
        amplitudes,
        rates,
        periods,
        small_swing_periods,
        period_drift_percent,
    })
}

fn shift(samples: &mut [(f64, f64)], by: f64) {
    for (_, angle) in samples {
        *angle -= by;
    }
}

/// Arithmetic-geometric mean; K(k) = π/(2 agm(1, √(1 − k²))).
fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

/// All crossings and the peaks between them: peak k lies between crossings k and k + 1.
fn half_cycles(
    samples: &[(f64, f64)],
    least: f64,
    noise: f64,
    quantum: Option<f64>,
) -> (Vec<Crossing>, Vec<Peak>) {
    // Rough crossings: a change of sign counts once the angle has got clear of the noise.
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
    // Samples on one step of the encoder are one value.
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

/// Least squares with two functions of time (the first may depend on its own coefficient): both
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

/// From the largest peak on, as long as the swing stands out of the noise: what comes before was
/// pushed by hand.
fn dying_part((crossings, peaks): (Vec<Crossing>, Vec<Peak>)) -> (Vec<Crossing>, Vec<Peak>) {
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

/// The drift from the first periods to the last ones, with the error that the crossings give it:
/// consecutive periods share most of theirs.
fn drift(periods: &[AtAmplitude], crossings: &[Crossing]) -> Estimate {
    let count = DRIFT_PERIODS.min(periods.len() / 2).max(1);
    let mean = |first: usize| -> Estimate {
        let group = &periods[first..first + count];
        let value = group.iter().map(|period| period.value).sum::<f64>() / count as f64;
        let mut weight = vec![0.0; count + 3];
        for k in 0..count {
            for (offset, sign) in [(0, -0.5), (1, -0.5), (2, 0.5), (3, 0.5)] {
                weight[k + offset] += sign / count as f64;
            }
        }
        let variance: f64 = weight
            .iter()
            .zip(&crossings[first..])
            .map(|(weight, crossing)| weight * weight * crossing.variance_s2)
            .sum();
        Estimate {
            value,
            std: variance.sqrt(),
        }
    };
    let (first, last) = (mean(0), mean(periods.len() - count));
    Estimate {
        value: 100.0 * (last.value / first.value - 1.0),
        std: 100.0 * first.std.hypot(last.std) / first.value,
    }
}

/// The amplitudes that the law predicts at these times from the first one.
fn predict(times: &[f64], start: f64, law: &[f64; 3]) -> Vec<f64> {
    let slope = |a: f64| {
        let a = a.max(0.0);
        -(law[0] + law[1] * a + law[2] * a * a)
    };
    let mut out = vec![start];
    let mut a = start;
    for pair in times.windows(2) {
        let h = pair[1] - pair[0];
        let k1 = slope(a);
        let k2 = slope(a + 0.5 * h * k1);
        let k3 = slope(a + 0.5 * h * k2);
        let k4 = slope(a + h * k3);
        a = (a + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)).max(0.0);
        out.push(a);
    }
    out
}

/// All laws, the best first.
fn laws(amplitudes: &[AtAmplitude]) -> Vec<DecayLaw> {
    let mut laws: Vec<DecayLaw> = (1..8u32)
        .filter_map(|mask| {
            let has = [mask & 1 != 0, mask & 2 != 0, mask & 4 != 0];
            fit_law(amplitudes, has)
        })
        .filter(|law| {
            let allowed = |e: &Estimate| e.value >= -2.0 * e.std;
            law.coefficients.iter().all(allowed)
        })
        .collect();
    laws.sort_by(|a, b| a.criterion.total_cmp(&b.criterion));
    laws
}

/// Gauss–Newton with halved steps over the first amplitude and the terms of the law. Half cycles
/// count by their own errors and by a part of their amplitude: what no law of this form can follow
/// is a part of it.
fn fit_law(amplitudes: &[AtAmplitude], has: [bool; 3]) -> Option<DecayLaw> {
    let times: Vec<f64> = amplitudes.iter().map(|point| point.time_s).collect();
    let n = times.len();
    let free: Vec<usize> = (0..3).filter(|&term| has[term]).collect();
    let p = free.len() + 1;
    if n <= p + 2 {
        return None;
    }
    let largest = amplitudes[0].value;
    let mean_amplitude = amplitudes.iter().map(|point| point.value).sum::<f64>() / n as f64;
    let rate = (largest - amplitudes[n - 1].value) / (times[n - 1] - times[0]) / mean_amplitude;
    let typical = [mean_amplitude, 1.0, 1.0 / mean_amplitude].map(|unit| unit * rate.abs());
    // Unknowns: the first amplitude, then the terms in units of their typical size.
    let unpack = |x: &DVector<f64>| -> (f64, [f64; 3]) {
        let mut law = [0.0; 3];
        for (index, &term) in free.iter().enumerate() {
            law[term] = x[index + 1] * typical[term];
        }
        (x[0] * largest, law)
    };
    let residual = |x: &DVector<f64>| -> DVector<f64> {
        let (start, law) = unpack(x);
        let predicted = predict(&times, start, &law);
        DVector::from_iterator(
            n,
            amplitudes
                .iter()
                .zip(predicted)
                .map(|(point, predicted)| (point.value - predicted) / largest),
        )
    };
    let mut x = DVector::from_element(p, 1.0 / free.len() as f64);
    x[0] = 1.0;
    let mut left = residual(&x);
    let mut inverse = DMatrix::zeros(p, p);
    for _ in 0..60 {
        let mut jacobian = DMatrix::zeros(n, p);
        for column in 0..p {
            let mut moved = x.clone();
            moved[column] += 1e-5;
            jacobian.set_column(column, &((residual(&moved) - &left) / 1e-5));
        }
        let square = jacobian.transpose() * &jacobian;
        let mut damped = square.clone();
        for k in 0..p {
            damped[(k, k)] += 1e-12 * (1.0 + square[(k, k)]);
        }
        let cholesky = Cholesky::new(damped)?;
        inverse = cholesky.inverse();
        let step = cholesky.solve(&(jacobian.transpose() * &left));
        let mut length = 1.0;
        let mut better = None;
        while length > 1e-4 {
            let next = &x - length * &step;
            let there = residual(&next);
            if there.norm() <= left.norm() {
                better = Some((next, there));
                break;
            }
            length *= 0.5;
        }
        let Some((next, there)) = better else {
            break;
        };
        let gain = left.norm_squared() - there.norm_squared();
        x = next;
        left = there;
        if gain <= 1e-10 * left.norm_squared() {
            break;
        }
    }
    let variance = left.norm_squared() / (n - p) as f64;
    let (_, law) = unpack(&x);
    let mut coefficients = [Estimate::default(); 3];
    for (index, &term) in free.iter().enumerate() {
        coefficients[term] = Estimate {
            value: law[term],
            std: (variance * inverse[(index + 1, index + 1)]).sqrt() * typical[term],
        };
    }
    let mean_square = left.norm_squared() / n as f64;
    let relative = left
        .iter()
        .zip(amplitudes)
        .map(|(left, point)| (left * largest / point.value).powi(2))
        .sum::<f64>()
        / n as f64;
    Some(DecayLaw {
        has,
        coefficients,
        rms_rad: mean_square.sqrt() * largest,
        relative_rms: relative.sqrt(),
        criterion: n as f64 * mean_square.max(1e-300).ln() + p as f64 * (n as f64).ln(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::{Current, EffectId, Model, Plant, State};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const VALUES: [f64; 6] = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
    ];

    fn swing(
        effects: &[(EffectId, &[f64])],
        viscous: f64,
        start: f64,
        noise: f64,
        step: f64,
        seed: u64,
    ) -> Record {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut model = Model::base();
        let mut values = VALUES.to_vec();
        values[4] = viscous;
        for (effect, parameters) in effects {
            model = model.with(*effect);
            let at = model.position(*effect).expect("just added");
            values.splice(at..at, parameters.iter().copied());
        }
        let n = 7500;
        let time_s: Vec<f64> = (0..n).map(|k| 0.004 * k as f64).collect();
        let mut angle = vec![];
        Plant::new(&model, &values, Kind::FreeSwing).run(
            State {
                angle_rad: start,
                ..State::rest()
            },
            &time_s,
            0..n,
            Current::Held(0.0),
            None,
            |_, reading, _| {
                let e: f64 = StandardNormal.sample(&mut rng);
                let x = reading.angle_rad + 0.03 + noise * e;
                angle.push(if step > 0.0 {
                    (x / step).round() * step
                } else {
                    x
                });
            },
        );
        Record::new(
            "x",
            Kind::FreeSwing,
            time_s,
            [Some(angle), None, None],
            None,
            false,
        )
    }

    #[test]
    fn dry_viscous_and_quadratic_friction_give_their_terms() {
        let (total, gravity) = (VALUES[0], VALUES[2]);
        let omega = (gravity / total).sqrt();
        let period = std::f64::consts::TAU / omega;
        let (mu, viscous, drag) = (3e-4, 2e-4, 2.5e-5);
        for seed in 0..6 {
            let cases: [(Record, usize, f64); 3] = [
                (
                    swing(
                        &[(EffectId::BodyCoulombFriction, &[mu])],
                        0.0,
                        0.3,
                        1.2e-3,
                        0.0,
                        seed,
                    ),
                    0,
                    4.0 * mu / (gravity * period),
                ),
                (
                    swing(&[], viscous, 0.3, 1.2e-3, 0.0, seed),
                    1,
                    viscous / (2.0 * total),
                ),
                (
                    swing(
                        &[(EffectId::BodyQuadraticDrag, &[drag])],
                        0.0,
                        0.5,
                        1.2e-3,
                        0.0,
                        seed,
                    ),
                    2,
                    4.0 * drag * omega / (3.0 * std::f64::consts::PI * total),
                ),
            ];
            for (record, term, expected) in cases {
                let found = decay(&record).expect("a swing");
                let best = found.laws[0];
                let mut has = [false; 3];
                has[term] = true;
                let single = found
                    .laws
                    .iter()
                    .find(|law| law.has == has)
                    .expect("fitted");
                let ratio = single.coefficients[term].value / expected;
                assert!(
                    (ratio - 1.0).abs() < 0.03,
                    "seed {seed} term {term}: {ratio}"
                );
                assert!(best.has[term], "seed {seed} term {term}: {:?}", found.laws);
                assert!(
                    (found.period_drift_percent.value).abs()
                        < 4.0 * found.period_drift_percent.std + 0.1,
                    "seed {seed} term {term}: {:?}",
                    found.period_drift_percent
                );
            }
        }
    }

    #[test]
    fn the_large_angle_effect_is_taken_out_of_the_period() {
        let exact = std::f64::consts::TAU * (VALUES[0] / VALUES[2]).sqrt();
        let record = swing(
            &[(EffectId::BodyQuadraticDrag, &[5e-5])],
            0.0,
            0.9,
            1e-4,
            0.0,
            1,
        );
        let found = decay(&record).expect("a swing");
        assert!(found.periods[0].value / exact > 1.04);
        for point in &found.small_swing_periods {
            let error = point.value / exact - 1.0;
            assert!(
                error.abs() < 1e-3 + 4.0 * point.std / exact,
                "{point:?} {error}"
            );
        }
    }

    #[test]
    fn the_errors_are_the_scatter_and_survive_an_encoder() {
        for (noise, step, bias) in [(1.2e-3, 0.0, 0.0), (0.0, 0.01, 1e-3)] {
            let (mut squares, mut count) = (0.0, 0.0);
            let clean = swing(&[], 2e-4, 0.3, 1e-6, 0.0, 0);
            let truth = decay(&clean).expect("a swing");
            for seed in 0..10 {
                let found = decay(&swing(
                    &[],
                    2e-4,
                    0.3 + 1e-4 * seed as f64,
                    noise,
                    step,
                    seed,
                ))
                .expect("a swing");
                for (point, truth) in found.amplitudes.iter().zip(&truth.amplitudes) {
                    let scale = (0.3 + 1e-4 * seed as f64) / 0.3;
                    let error = (point.value - scale * truth.value) / point.std.hypot(bias);
                    squares += error * error;
                    count += 1.0;
                }
            }
            let rms = f64::sqrt(squares / count);
            // Rounding errors are bounded and partly cancel: the stated errors may be too large.
            let least = if step > 0.0 { 0.2 } else { 0.8 };
            assert!(
                (least..1.25).contains(&rms),
                "noise {noise} step {step}: {rms}"
            );
        }
    }

    #[test]
    fn a_contact_that_bends_shortens_the_period_of_small_swings() {
        let effects: [(EffectId, &[f64]); 1] = [(EffectId::BodyPreslidingFriction, &[4e-4, 0.02])];
        let found = decay(&swing(&effects, 2e-4, 0.35, 1.2e-3, 0.0, 3)).expect("a swing");
        let drift = found.period_drift_percent;
        assert!(
            drift.value < -5.0 * drift.std && drift.value < -0.5,
            "{drift:?}"
        );
    }

    #[test]
    fn what_is_no_swing_gives_nothing() {
        let time_s: Vec<f64> = (0..500).map(|k| 0.01 * k as f64).collect();
        for angle in [vec![0.0; 500], vec![f64::NAN; 500], time_s.clone()] {
            let outputs = [Some(angle), None, None];
            let record = Record::new("x", Kind::FreeSwing, time_s.clone(), outputs, None, false);
            assert!(decay(&record).is_none());
        }
    }
}
