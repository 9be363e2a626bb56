//! The equations of motion, integrated over windows of samples. They serve logs that are too short or too coarse for
//! the test functions ("bumps") of the weak form.
//!
//! Integration over time turns accelerations into measured rates, up to a constant c of each window. The result is
//! linear in the ratios of the parameters:
//!
//! ```text
//! α̇ = c − (G/Θ) ∫sin α − (G'/Θ) ∫cos α − (r_b/Θ) α                       wheel locked
//! α̇ = c − (G/D) ∫sin α − (G'/D) ∫cos α − (r_b/D) α − (τ/D) ∫i + (r_w/D) ∫φ̇   all free
//! φ̇ + α̇ = c + (τ/j_w) ∫i − (r_w/j_w) ∫φ̇                                  wheel driven
//! ```
//!
//! If the rate was not measured, the equations that contain it are integrated once more, and each window has its own
//! constant and slope. Both are projected out of every term. A handful of samples is enough.

use plant::{Kind, Output};

use super::ratios::Ratios;
use super::rows::Rows;
use crate::records::{Record, angle_samples};

/// Smallest number of samples in a window: five for the unknowns of an equation, two for those of the window.
const FEWEST_SAMPLES: usize = 5;
/// Largest number of windows used per record; more do not improve a start.
const MOST_WINDOWS: usize = 64;

/// Computes the ratios from the integrated equations, over windows of at most `window_samples` samples.
pub(crate) fn integrated_ratios(records: &[&Record], window_samples: usize) -> Ratios {
    let mut locked = Rows::new(3);
    let mut free = Rows::new(5);
    let mut wheel = Rows::new(2);
    for record in records {
        let Some(motion) = Motion::of(record) else {
            continue;
        };
        for window in windows(record.len(), window_samples) {
            if record.weight[window.clone()].iter().any(|w| *w <= 0.0) {
                continue;
            }
            motion.body_rows(record, window.clone(), &mut locked, &mut free);
            motion.wheel_rows(record, window, &mut wheel);
        }
    }
    Ratios::of_solutions(locked.solve(), free.solve(), wheel.solve())
}

/// Windows of about equal length over `n` samples, at most [`MOST_WINDOWS`] of them, spread over the log.
fn windows(n: usize, window_samples: usize) -> Vec<std::ops::Range<usize>> {
    let length = window_samples.clamp(FEWEST_SAMPLES, n.max(FEWEST_SAMPLES));
    let count = n / length;
    let step = count.div_ceil(MOST_WINDOWS).max(1);
    (0..count)
        .step_by(step)
        .map(|index| index * length..(index + 1) * length)
        .collect()
}

/// The place of the charge among the terms of a body that moves freely.
const CHARGE_TERM: usize = 3;

/// The measured series of a record with gaps filled, and their running integrals.
struct Motion {
    angle: Option<Vec<f64>>,
    rate: Option<Vec<f64>>,
    wheel_speed: Option<Vec<f64>>,
    charge: Option<Vec<f64>>,
    /// Whether the current is held from sample to sample: the charge is then a broken line.
    is_held: bool,
}

impl Motion {
    fn of(record: &Record) -> Option<Motion> {
        if record.len() < FEWEST_SAMPLES || record.kind == Kind::Balance {
            return None;
        }
        let filled = |output| record.channel(output).map(|c| without_gaps(&c.samples));
        Some(Motion {
            angle: angle_samples(record).map(|angle| without_gaps(&angle)),
            rate: filled(Output::Rate),
            wheel_speed: filled(Output::WheelSpeed),
            charge: record.charge(),
            is_held: !record.current_is_measured,
        })
    }

    /// The running integral of the charge. Where the current is held, the trapezoidal rule is exact; a cubic through the
    /// corners of a broken line is not.
    fn integral_of_charge(&self, time_s: &[f64], charge: &[f64]) -> Vec<f64> {
        if !self.is_held {
            return integral(time_s, charge);
        }
        let mut sum = vec![0.0; charge.len()];
        for k in 1..charge.len() {
            let step_s = time_s[k] - time_s[k - 1];
            sum[k] = sum[k - 1] + 0.5 * (charge[k - 1] + charge[k]) * step_s;
        }
        sum
    }

    fn body_rows(
        &self,
        record: &Record,
        window: std::ops::Range<usize>,
        locked: &mut Rows,
        free: &mut Rows,
    ) {
        let Some(angle) = self.angle.as_ref().filter(|_| record.kind != Kind::SpinUp) else {
            return;
        };
        let time_s = &record.time_s[window.clone()];
        let angle = &angle[window.clone()];
        let sine: Vec<f64> = angle.iter().map(|angle| angle.sin()).collect();
        let cosine: Vec<f64> = angle.iter().map(|angle| angle.cos()).collect();
        let mut terms = vec![
            integral(time_s, &sine),
            integral(time_s, &cosine),
            angle.to_vec(),
        ];
        if record.kind != Kind::FreeSwing {
            let (Some(charge), Some(speed)) = (&self.charge, &self.wheel_speed) else {
                return;
            };
            terms.push(charge[window.clone()].to_vec());
            terms.push(integral(time_s, &speed[window.clone()]));
        }
        let mut left = match &self.rate {
            Some(rate) => rate[window].to_vec(),
            None => {
                let charge = (record.kind != Kind::FreeSwing).then_some(CHARGE_TERM);
                terms = terms
                    .iter()
                    .enumerate()
                    .map(|(at, term)| {
                        if Some(at) == charge {
                            self.integral_of_charge(time_s, term)
                        } else {
                            integral(time_s, term)
                        }
                    })
                    .collect();
                angle.to_vec()
            }
        };
        let own = if self.rate.is_some() { 1 } else { 2 };
        project_out(time_s, own, &mut left);
        for term in &mut terms {
            project_out(time_s, own, term);
        }
        for k in 0..left.len() {
            let [sine, cosine, turn] = [0, 1, 2].map(|at| -terms[at][k]);
            match terms.get(3).zip(terms.get(4)) {
                None => locked.push(&[sine, cosine, turn], left[k]),
                Some((charge, spin)) => {
                    free.push(&[sine, cosine, turn, -charge[k], spin[k]], left[k]);
                }
            }
        }
    }

    fn wheel_rows(&self, record: &Record, window: std::ops::Range<usize>, wheel: &mut Rows) {
        let (Some(speed), Some(charge)) = (&self.wheel_speed, &self.charge) else {
            return;
        };
        let time_s = &record.time_s[window.clone()];
        let speed = &speed[window.clone()];
        let mut left = speed.to_vec();
        let mut drive = charge[window.clone()].to_vec();
        let mut spin = integral(time_s, speed);
        let mut own = 1;
        if record.kind != Kind::SpinUp {
            // The speed over ground, or its integral where only the body's angle is known.
            let body = match (&self.rate, &self.angle) {
                (Some(rate), _) => rate,
                (None, Some(angle)) => {
                    for series in [&mut left, &mut spin] {
                        *series = integral(time_s, series);
                    }
                    drive = self.integral_of_charge(time_s, &drive);
                    own = 2;
                    angle
                }
                (None, None) => return,
            };
            for (left, body) in left.iter_mut().zip(&body[window]) {
                *left += body;
            }
        }
        for series in [&mut left, &mut drive, &mut spin] {
            project_out(time_s, own, series);
        }
        for k in 0..left.len() {
            wheel.push(&[drive[k], -spin[k]], left[k]);
        }
    }
}

/// The series with each missing sample interpolated linearly between its neighbours.
fn without_gaps(samples: &[f64]) -> Vec<f64> {
    let mut filled = samples.to_vec();
    let known: Vec<usize> = (0..samples.len())
        .filter(|&k| samples[k].is_finite())
        .collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return vec![0.0; samples.len()];
    };
    filled[..first].fill(samples[first]);
    filled[last..].fill(samples[last]);
    for pair in known.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let slope = (samples[to] - samples[from]) / (to - from) as f64;
        for (k, value) in filled[from..to].iter_mut().enumerate() {
            *value = samples[from] + slope * k as f64;
        }
    }
    filled
}

/// Relative difference up to which neighbouring sampling intervals count as equal.
const EQUAL_STEPS: f64 = 1e-3;

/// The running integral of sampled values. Where samples are equally spaced, the cubic through the four samples around
/// each interval is integrated; elsewhere, the trapezoidal rule is used.
fn integral(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let step = |k: usize| time_s[k + 1] - time_s[k];
    let mut sum = vec![0.0; n];
    for k in 1..n {
        let own = step(k - 1);
        let is_inner = k >= 2
            && k + 1 < n
            && (step(k - 2) - own).abs() < EQUAL_STEPS * own
            && (step(k) - own).abs() < EQUAL_STEPS * own;
        let area = if is_inner {
            let inner = 13.0 * (values[k - 1] + values[k]);
            (inner - values[k - 2] - values[k + 1]) / 24.0
        } else {
            0.5 * (values[k - 1] + values[k])
        };
        sum[k] = sum[k - 1] + area * own;
    }
    sum
}

/// Projects the mean out of a series, and also its linear trend over time if `own` is 2.
fn project_out(time_s: &[f64], own: usize, series: &mut [f64]) {
    let n = series.len().max(1) as f64;
    let mean_t = time_s.iter().sum::<f64>() / n;
    let mean = series.iter().sum::<f64>() / n;
    let (mut tt, mut ty) = (0.0, 0.0);
    for (t, value) in time_s.iter().zip(series.iter()) {
        tt += (t - mean_t) * (t - mean_t);
        ty += (t - mean_t) * (value - mean);
    }
    let slope = if own == 2 && tt > 0.0 { ty / tt } else { 0.0 };
    for (t, value) in time_s.iter().zip(series) {
        *value -= mean + slope * (t - mean_t);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::{Current, Hold, Input, Model, Plant, State};

    /// Θ, j_w, G, τ, r_b, r_w.
    const VALUES: [f64; 6] = [2.3e-3, 1.36e-4, 0.245, 0.0335, 5e-4, 1.75e-5];

    fn log(kind: Kind, n: usize, step_s: f64, with_rate: bool) -> Record {
        let time_s: Vec<f64> = (0..n).map(|k| k as f64 * step_s).collect();
        let current: Vec<f64> = (0..n).map(|k| if k % 7 < 3 { 0.6 } else { -0.3 }).collect();
        let input = Input::new(&time_s, &current, Hold::Zero);
        let plant = Plant::new(&Model::base(), &VALUES, kind);
        let start = State {
            angle_rad: if kind == Kind::SpinUp { 0.0 } else { 0.5 },
            ..State::rest()
        };
        let drive = match kind {
            Kind::FreeSwing => Current::Held(0.0),
            _ => Current::Recorded(&input),
        };
        let mut series: [Vec<f64>; 3] = Default::default();
        plant.run(start, &time_s, 0..n, drive, None, |_, reading, _| {
            series[0].push(reading.angle_rad);
            series[1].push(reading.rate_rad_s);
            series[2].push(reading.wheel_speed_rad_s);
        });
        let [angle, rate, speed] = series;
        let rate = with_rate.then_some(rate);
        let outputs = [Some(angle), rate, Some(speed)];
        Record::new("x", kind, time_s, outputs, Some(current), false)
    }

    fn near(found: Option<f64>, truth: f64, what: &str) {
        let found = found.expect(what);
        assert!(
            (found / truth - 1.0).abs() < 0.03,
            "{what}: {found} {truth}"
        );
    }

    /// A dozen samples of a spin-up, forty of a third of a period, ten samples a period.
    #[test]
    fn short_and_coarse_logs_give_the_ratios_within_three_percent() {
        let [total, wheel, gravity, torque, _, wheel_friction] = VALUES;
        let spin_up = log(Kind::SpinUp, 11, 0.02, false);
        let found = integrated_ratios(&[&spin_up], 64);
        near(found.torque_over_wheel, torque / wheel, "τ/j_w");
        let long = log(Kind::SpinUp, 40, 0.4, false);
        let found = integrated_ratios(&[&long], 64);
        near(found.torque_over_wheel, torque / wheel, "τ/j_w");
        near(found.friction_over_wheel, wheel_friction / wheel, "r_w/j_w");
        for (n, step_s, with_rate) in [(40, 0.005, true), (120, 0.005, false), (60, 0.06, true)] {
            let swing = log(Kind::FreeSwing, n, step_s, with_rate);
            let found = integrated_ratios(&[&swing], 64);
            near(found.gravity_over_total, gravity / total, "G/Θ");
        }
        for with_rate in [true, false] {
            let driven = log(Kind::Driven, 200, 0.01, with_rate);
            let found = integrated_ratios(&[&driven], 64);
            near(found.gravity_over_free, gravity / (total - wheel), "G/D");
            near(found.torque_over_free, torque / (total - wheel), "τ/D");
            near(found.torque_over_wheel, torque / wheel, "τ/j_w");
        }
    }

    #[test]
    fn what_says_nothing_gives_nothing() {
        let short = log(Kind::SpinUp, 3, 0.01, false);
        assert_eq!(integrated_ratios(&[&short], 64), Ratios::default());
        let mut lost = log(Kind::FreeSwing, 40, 0.01, false);
        lost.channels[0].samples.fill(f64::NAN);
        let found = integrated_ratios(&[&lost], 64);
        assert_eq!(found.gravity_over_total, None);
    }
}
