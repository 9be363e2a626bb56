//! The decay of a free swing: amplitude, decay rate and period, half cycle by half cycle, from the angle alone and
//! without a model.
//!
//! Opposite half cycles are averaged, and so are periods between rising and between falling crossings. This removes
//! the unknown zero of the angle.
//!
//! The decay is compared with dA/dt = −(C + V A + Q A²): C = 4 μ/(G T) for dry friction, V = r_b/(2 Θ)
//! for viscous friction, Q = 4 c ω/(3 π Θ) for quadratic drag (energy lost in a cycle; Nayfeh & Mook,
//! 3.3). The period of small swings follows from the measured one through the complete elliptic
//! integral, T₀ = T agm(1, cos(A/2)) (Abramowitz & Stegun 17.6.3). A friction that depends on speed
//! alone does not change T₀; a contact that bends before it slides does, and so does a spring.

mod half_cycles;
mod law;
mod point;

use plant::Kind;

use self::half_cycles::{Crossing, dying_part, half_cycles};
use self::law::laws;
use crate::records::{Output, Record, angle_samples, median, noise_std};

pub use self::law::DecayLaw;
pub use self::point::{AtAmplitude, Estimate};

/// The decay of a free swing.
#[derive(Clone, Debug)]
pub struct FreeDecay {
    /// Amplitude (value, rad) of each pair of half cycles.
    pub amplitudes: Vec<AtAmplitude>,
    /// Relative decay rate −Ȧ/A in 1/s.
    pub rates: Vec<AtAmplitude>,
    /// Measured period in s.
    pub periods: Vec<AtAmplitude>,
    /// Period of small swings in s: the measured period, corrected for the amplitude.
    pub small_swing_periods: Vec<AtAmplitude>,
    /// Every law of one, two or three terms in which no coefficient is negative beyond its error, the best first.
    pub laws: Vec<DecayLaw>,
    /// Change of the period of small swings from the largest to the smallest amplitude, percent.
    pub period_drift_percent: Estimate,
}

/// Half cycles with an amplitude below this many standard deviations of the noise are not used.
const LEAST_OVER_NOISE: f64 = 5.0;
/// Half cycles with an amplitude below this many steps of a quantised angle are not used.
const LEAST_OVER_QUANTUM: f64 = 3.0;
/// Smallest number of half cycles for a result.
const FEWEST_HALF_CYCLES: usize = 8;
/// Number of periods averaged at each end of the swing to compute the drift.
const DRIFT_PERIODS: usize = 5;

/// The decay of a free swing; `None` if fewer than eight half cycles stand out of the noise, and for other kinds of
/// experiment.
pub fn decay(record: &Record) -> Option<FreeDecay> {
    if record.kind != Kind::FreeSwing {
        return None;
    }
    let angle = angle_samples(record)?;
    let channel = record.channel(Output::Angle);
    let noise = channel.map_or_else(|| noise_std(&angle), |channel| channel.noise_std);
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
    // The zero of the angle: first the middle of the range, then the value that makes opposite peaks equal.
    let (low, high) = samples
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, x)| {
            (low.min(*x), high.max(*x))
        });
    shift(&mut samples, 0.5 * (low + high));
    let mut found = half_cycles(&samples, least, noise, quantum);
    for _ in 0..2 {
        let middles = found
            .1
            .windows(3)
            .map(|three| 0.25 * (three[0].angle + 2.0 * three[1].angle + three[2].angle));
        shift(&mut samples, median(middles)?);
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
            // The first and the third peak pair do not overlap.
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
    Some(FreeDecay {
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
pub(super) fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..20 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

/// The drift from the first periods to the last ones. Its error follows from the errors of the crossings:
/// consecutive periods share most of their crossings.
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
