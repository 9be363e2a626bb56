//! The missing torque: the torque that a model lacks, from the measurements and without simulation.
//!
//! The accelerations that the model gives in the measured state, (α̈_m, φ̈_m), are compared with the measured
//! accelerations. Their difference, weighted with the inertias, is the missing torque:
//!
//! - on the body: f_b = Θ (α̈ − α̈_m) + j_w (φ̈ − φ̈_m), which does not involve the motor; Θ (α̈ − α̈_m) if the wheel
//!   is locked,
//! - on the wheel: f_w = j_w (α̈ − α̈_m + φ̈ − φ̈_m), motor and wheel friction together,
//! - on the body, from the command: f_b − f_w = (Θ − j_w)(α̈ − α̈_m), which needs no wheel speed and has the
//!   lowest noise, but in which an error of the motor's model looks like a torque on the body.
//!
//! All are evaluated in the weak form (Shinbrot, Trans. ASME 79 (1957)): multiplied by a short bump
//! ψ = (t − a)² (b − t)² and integrated by parts, ∫ψ α̈ = −∫ψ̇ α̇ = ∫ψ̈ α, so that no measurement is
//! differentiated. The result is the torque smoothed by the bump; its integral is that of the torque.
//! Unlike the residual of a free run, it has no memory: it shows where the model fails at that instant.

use plant::{Kind, Model, Plant, State, TOTAL_INERTIA, WHEEL_INERTIA, period_s};

use super::motion::MeasuredMotion;
use crate::fit::Window;
use crate::records::{Bump, FEWEST_HALF_SAMPLES, Output, Record, dot, half_samples};

/// Half of a bump's width, in periods of the pendulum: short against the time in which a swing passes any feature.
const HALF_BUMP_PERIODS: f64 = 1.0 / 16.0;
/// Half of a bump's width in a spin-up, as a share of the length of the log. A spin-up has no period; features shorter
/// than a hundredth of the log are not resolved.
const HALF_BUMP_LOGS: f64 = 1.0 / 100.0;
/// Number of bumps from which the noise is computed.
const NOISE_PROBES: usize = 32;

/// Which missing torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TorqueOn {
    /// On the body, from the momentum of body and wheel.
    Body,
    /// On the wheel: friction and motor.
    Wheel,
    /// On the body, with the motor's torque computed from the command.
    BodyByCommand,
}

impl TorqueOn {
    /// The channel of the torque, as in "experiment/channel".
    pub fn channel(self) -> &'static str {
        match self {
            TorqueOn::Body | TorqueOn::BodyByCommand => Output::Angle.name(),
            TorqueOn::Wheel => Output::WheelSpeed.name(),
        }
    }

    /// Weights of α̈ − α̈_m and φ̈ − φ̈_m in kg m²; `None` if this kind of experiment holds still the body on which the
    /// torque acts.
    pub(super) fn inertias(self, kind: Kind, values: &[f64]) -> Option<(f64, f64)> {
        let (total, wheel) = (values[TOTAL_INERTIA], values[WHEEL_INERTIA]);
        match (self, kind) {
            (TorqueOn::Body, Kind::FreeSwing) => Some((total, 0.0)),
            (TorqueOn::Body, Kind::Balance | Kind::Driven) => Some((total, wheel)),
            (TorqueOn::Wheel, Kind::SpinUp) => Some((0.0, wheel)),
            (TorqueOn::Wheel, Kind::Balance | Kind::Driven) => Some((wheel, wheel)),
            (TorqueOn::BodyByCommand, Kind::Balance | Kind::Driven) => Some((total - wheel, 0.0)),
            _ => None,
        }
    }
}

/// A missing torque in one record.
#[derive(Clone, Debug)]
pub struct ResidualTorque {
    /// Which torque.
    pub on: TorqueOn,
    /// The sample at the centre of each bump; increasing by [`ResidualTorque::stride`], except at gaps.
    pub centres: Vec<usize>,
    /// The torque in N m (in N m per kg m² if the scale of the torques is unknown), positive in the direction of positive
    /// speed.
    pub torque_nm: Vec<f64>,
    /// Standard deviation of each value from the noise of the sensors, same unit; the root mean square over the log.
    pub noise_std_nm: f64,
    /// Correlation of the noise between two bumps that are 0, 1, 2, … strides apart, as long as the bumps overlap.
    pub noise_correlation: Vec<f64>,
    /// Half-width of a bump in samples.
    pub half: usize,
    /// Samples from one bump to the next.
    pub stride: usize,
}

impl ResidualTorque {
    /// The weights, which sum to 1, with which the value at `centre` averages over the intervals from
    /// `centre − half` to `centre + half` of its record.
    pub fn weights(&self, record: &Record, centre: usize) -> Vec<f64> {
        Bump::around(&record.time_s, centre, self.half).intervals
    }
}

/// Half of the width of a bump for this record, in samples.
pub fn half_bump(record: &Record, values: &[f64]) -> usize {
    let n = record.len();
    let span_s = record.time_s[n - 1] - record.time_s[0];
    let half_s = match record.kind {
        Kind::SpinUp => HALF_BUMP_LOGS * span_s,
        _ => HALF_BUMP_PERIODS * period_s(values),
    };
    half_samples(record, half_s)
}

impl MeasuredMotion {
    /// All missing torques that this motion shows, with bumps of half-width `half` samples.
    pub fn residual_torques(
        &self,
        record: &Record,
        model: &Model,
        values: &[f64],
        half: usize,
    ) -> Vec<ResidualTorque> {
        [TorqueOn::Body, TorqueOn::Wheel, TorqueOn::BodyByCommand]
            .into_iter()
            .filter(|on| match (on, record.kind) {
                (TorqueOn::Body, Kind::FreeSwing) => true,
                (TorqueOn::Body | TorqueOn::Wheel, _) => self.wheel_speed_measured,
                // The torque from body and wheel contains this one.
                (TorqueOn::BodyByCommand, _) => !self.wheel_speed_measured,
            })
            .filter_map(|on| {
                let shape = (half, half / 2);
                residual_torque(record, &record.weight, self, model, values, on, shape)
            })
            .collect()
    }
}

/// The missing torques of `model` in a record, on the body and on the wheel, as its kind and channels allow. `windows`
/// are those of the fit, or empty.
pub fn residual_torques(
    record: &Record,
    windows: &[Window],
    model: &Model,
    values: &[f64],
) -> Vec<ResidualTorque> {
    if record.len() < 4 * FEWEST_HALF_SAMPLES {
        return vec![];
    }
    let half = half_bump(record, values);
    let Some(motion) = MeasuredMotion::new(record, windows, model, values, half) else {
        return vec![];
    };
    motion.residual_torques(record, model, values, half)
}

/// One missing torque of `model`, smoothed by bumps of half-width `half` samples that begin `stride`
/// samples apart. Bumps that contain a missing sample, or one of weight 0, are left out (an empty
/// `weight` counts all samples). `None` if this kind of experiment or its channels do not show the torque.
pub fn residual_torque(
    record: &Record,
    weight: &[f64],
    motion: &MeasuredMotion,
    model: &Model,
    values: &[f64],
    on: TorqueOn,
    (half, stride): (usize, usize),
) -> Option<ResidualTorque> {
    let (of_body, of_wheel) = on.inertias(record.kind, values)?;
    let shows_body = record.channel(Output::Angle).is_some() || motion.rate_measured;
    if (of_body != 0.0 && !shows_body) || (of_wheel != 0.0 && !motion.wheel_speed_measured) {
        return None;
    }
    let n = record.len();
    let stride = stride.max(1);
    if n < 2 * half + 2 {
        return None;
    }
    let plant = Plant::new(model, values, record.kind);
    let modelled = |state: &State<f64>| {
        let (body, wheel) = plant.derivative(state, state.current_a, 0.0);
        of_body * body + of_wheel * wheel
    };
    let torque: Vec<f64> = motion.state.iter().map(modelled).collect();
    let counts: Vec<bool> = (0..n - 1)
        .map(|k| {
            torque[k].is_finite()
                && motion.state[k].rate_rad_s.is_finite()
                && [k, k + 1]
                    .iter()
                    .all(|&k| weight.get(k).is_none_or(|&weight| weight > 0.0))
        })
        .collect();
    let by_angle = of_body != 0.0 && !motion.rate_measured;
    let (mut centres, mut torque_nm) = (vec![], vec![]);
    for centre in (half..n - half).step_by(stride) {
        let span = centre - half..centre + half;
        if !counts[span.clone()].iter().all(|counts| *counts) {
            continue;
        }
        let bump = Bump::around(&record.time_s, centre, half);
        let mut value = -dot(&bump.intervals, torque[span.clone()].iter().copied());
        if by_angle {
            let rate = &motion.angle_slope;
            let changes = (span.start + 1..span.end)
                .map(|k| 2.0 * (rate[k] - rate[k - 1]) / (motion.step_s[k] + motion.step_s[k - 1]));
            value += of_body * dot(&bump.samples, changes);
        } else if of_body != 0.0 {
            value += of_body
                * dot(
                    &bump.intervals,
                    motion.rate_slope[span.clone()].iter().copied(),
                );
        }
        if of_wheel != 0.0 {
            let changes = motion.wheel_speed_slope[span].iter().copied();
            value += of_wheel * dot(&bump.intervals, changes);
        }
        centres.push(centre);
        torque_nm.push(value);
    }
    if centres.is_empty() {
        return None;
    }
    let (noise_std_nm, noise_correlation) = noise(
        &record.time_s,
        motion,
        &centres,
        &modelled,
        (of_body, of_wheel),
        (half, stride),
    );
    Some(ResidualTorque {
        on,
        centres,
        torque_nm,
        noise_std_nm,
        noise_correlation,
        half,
        stride,
    })
}

/// Standard deviation of the weak form from the noise of the sensors, and its correlation between bumps. The weak form is
/// linear in the noise of every sample. The part that enters through the model is found by changing the state by one
/// standard deviation.
fn noise(
    time_s: &[f64],
    motion: &MeasuredMotion,
    centres: &[usize],
    modelled: &dyn Fn(&State<f64>) -> f64,
    (of_body, of_wheel): (f64, f64),
    (half, stride): (usize, usize),
) -> (f64, Vec<f64>) {
    let lags = (2 * half).div_ceil(stride);
    let mut covariance = vec![0.0; lags + 1];
    let every = centres.len().div_ceil(NOISE_PROBES).max(1);
    let probes = centres.iter().step_by(every);
    let count = probes.clone().count() as f64;
    for &centre in probes {
        let bump = Bump::around(time_s, centre, half);
        for output in Output::ALL {
            let std = motion.noise_std[output as usize];
            if std == 0.0 {
                continue;
            }
            let mut weight = vec![0.0; 2 * half + 1];
            for (index, k) in (centre - half..centre + half).enumerate() {
                let mut moved = motion.state[k];
                match output {
                    Output::Angle => moved.angle_rad += std,
                    Output::Rate => moved.rate_rad_s += std,
                    Output::WheelSpeed => moved.wheel_speed_rad_s += std,
                }
                let change = if motion.speeds_are_simulated && output != Output::Angle {
                    0.0
                } else {
                    modelled(&moved) - modelled(&motion.state[k])
                };
                weight[index] -= 0.5 * bump.intervals[index] * change;
                weight[index + 1] -= 0.5 * bump.intervals[index] * change;
                let of_slope = match output {
                    Output::Angle => 0.0,
                    Output::Rate => of_body,
                    Output::WheelSpeed => of_wheel,
                };
                let slope = std * of_slope * bump.intervals[index] / motion.step_s[k];
                weight[index] -= slope;
                weight[index + 1] += slope;
                if output == Output::Angle && !motion.rate_measured && index > 0 {
                    let (before, after) = (motion.step_s[k - 1], motion.step_s[k]);
                    let change = std * of_body * bump.samples[index - 1] * 2.0 / (before + after);
                    weight[index - 1] += change / before;
                    weight[index] -= change / before + change / after;
                    weight[index + 1] += change / after;
                }
            }
            for (lag, covariance) in covariance.iter_mut().enumerate() {
                let shift = lag * stride;
                let pairs = weight.iter().zip(weight.iter().skip(shift));
                *covariance += pairs.map(|(a, b)| a * b).sum::<f64>() / count;
            }
        }
    }
    let variance = covariance[0].max(1e-300);
    let correlation = covariance.iter().map(|value| value / variance).collect();
    (variance.sqrt(), correlation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::Nuisance;
    use plant::{Current, EffectId, Hold, Input};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const VALUES: [f64; 6] = [
        2.30344e-3, 1.36125e-4, 0.245158, 0.0335, 2.12e-5, 1.75204e-5,
    ];

    /// A simulated log with the noise of the sensors of the thesis' bench.
    fn record(
        kind: Kind,
        model: &Model,
        values: &[f64],
        outputs: [bool; 3],
        push: Option<&dyn Fn(f64) -> f64>,
        seed: u64,
        noise: f64,
    ) -> Record {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let step = 0.004;
        let n = 5000;
        let time_s: Vec<f64> = (0..n).map(|k| k as f64 * step).collect();
        let current: Vec<f64> = time_s.iter().map(|t| 0.5 * (2.0 * t).sin()).collect();
        let input = Input::new(&time_s, &current, Hold::Zero);
        let start = State {
            angle_rad: if kind == Kind::SpinUp { 0.0 } else { 0.35 },
            ..State::rest()
        };
        let drive = match kind {
            Kind::FreeSwing => Current::Held(0.0),
            _ => Current::Recorded(&input),
        };
        let mut series = [vec![], vec![], vec![]];
        Plant::new(model, values, kind).run(start, &time_s, 0..n, drive, push, |_, reading, _| {
            for (output, std) in Output::ALL.into_iter().zip([1.2e-3, 4e-3, 0.6]) {
                let e: f64 = StandardNormal.sample(&mut rng);
                series[output as usize].push(output.of(reading) + noise * std * e);
            }
        });
        let mut series = series.into_iter();
        let outputs = outputs.map(|measured| series.next().filter(|_| measured));
        Record::new("test", kind, time_s, outputs, Some(current), false)
    }

    /// The one window of a log whose start is known.
    fn whole(record: &Record) -> Vec<Window> {
        let nuisances = Nuisance::of(record)
            .iter()
            .map(|local| if *local == Nuisance::Angle { 0.35 } else { 0.0 })
            .collect();
        let samples = 0..record.len();
        vec![Window { samples, nuisances }]
    }

    fn rms(values: &[f64]) -> f64 {
        (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
    }

    const CASES: [(Kind, [bool; 3]); 6] = [
        (Kind::FreeSwing, [true, true, false]),
        (Kind::FreeSwing, [true, false, false]),
        (Kind::FreeSwing, [false, true, false]),
        (Kind::SpinUp, [false, false, true]),
        (Kind::Driven, [true, true, true]),
        (Kind::Driven, [true, false, false]),
    ];

    /// If the model is right, only noise is missing, and its size is the stated one.
    #[test]
    fn the_right_model_leaves_the_stated_noise() {
        let model = Model::base();
        for (kind, outputs) in CASES {
            let mut ratios = vec![];
            let mut correlations = vec![];
            for seed in 0..12 {
                let record = record(kind, &model, &VALUES, outputs, None, seed, 1.0);
                for missing in residual_torques(&record, &whole(&record), &model, &VALUES) {
                    let ratio = rms(&missing.torque_nm) / missing.noise_std_nm;
                    ratios.push(ratio);
                    // Noise of neighbouring bumps is correlated as stated.
                    let products: f64 = missing
                        .torque_nm
                        .windows(2)
                        .map(|pair| pair[0] * pair[1])
                        .sum::<f64>()
                        / missing.torque_nm.len() as f64;
                    let found = products / rms(&missing.torque_nm).powi(2);
                    correlations.push(found - missing.noise_correlation[1]);
                }
            }
            assert!(!ratios.is_empty());
            let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
            assert!((0.93..1.07).contains(&mean), "{kind:?} {outputs:?} {mean}");
            let mean = correlations.iter().sum::<f64>() / correlations.len() as f64;
            assert!(mean.abs() < 0.1, "{kind:?} {outputs:?} {mean}");
        }
    }

    /// The residual torque is the torque that acts and that the model lacks.
    #[test]
    fn a_torque_that_acts_is_found_in_its_place_and_size() {
        let model = Model::base();
        let push = |t: f64| 2e-2 * (-((t - 8.0) / 0.1).powi(2)).exp();
        for (kind, outputs) in CASES {
            // An angle that is integrated from the rate does not show a jump of the phase.
            if kind == Kind::SpinUp || outputs == [false, true, false] {
                continue;
            }
            let record = record(kind, &model, &VALUES, outputs, Some(&push), 1, 0.0);
            for missing in residual_torques(&record, &whole(&record), &model, &VALUES) {
                let (mut impulse, mut moment) = (0.0, 0.0);
                for (centre, torque) in missing.centres.iter().zip(&missing.torque_nm) {
                    let t = record.time_s[*centre];
                    if (t - 8.0).abs() < 0.6 && missing.on != TorqueOn::Wheel {
                        impulse += torque * 0.004 * missing.stride as f64;
                        moment += torque * 0.004 * missing.stride as f64 * (t - 8.0);
                    }
                }
                if missing.on != TorqueOn::Wheel {
                    let expected = 2e-2 * 0.1 * std::f64::consts::PI.sqrt();
                    let ratio = impulse / expected;
                    assert!((ratio - 1.0).abs() < 0.02, "{kind:?} {outputs:?} {ratio}");
                    assert!((moment / impulse).abs() < 2e-3, "{kind:?} {outputs:?}");
                } else {
                    // The push reaches the wheel only through the body's motion, which is measured.
                    assert!(
                        rms(&missing.torque_nm) < 1e-5,
                        "{}",
                        rms(&missing.torque_nm)
                    );
                }
            }
        }
    }

    /// If the model has the effect that acts, no torque is missing. This holds for every effect of the library: sensors
    /// are undone, lag and delay are carried along, presliding friction remembers the measured path.
    #[test]
    fn a_model_with_the_effect_that_acts_lacks_nothing() {
        for &effect in EffectId::ALL {
            let info = effect.info();
            let model = Model::base().with(effect);
            let mut values = VALUES.to_vec();
            let at = model.position(effect).expect("just added");
            if at >= 6 {
                values.extend(info.parameters.iter().map(|parameter| {
                    let (low, high) = parameter.plausible;
                    if low > 0.0 {
                        (low * high).sqrt()
                    } else {
                        0.3 * high
                    }
                }));
                if effect == EffectId::BackEmfLimit {
                    values[at..].copy_from_slice(&[12.0, 8.0]);
                }
            }
            let record = record(Kind::Driven, &model, &values, [true; 3], None, 2, 0.0);
            let with = residual_torques(&record, &[], &model, &values);
            let without = residual_torques(&record, &[], &Model::base(), &VALUES);
            let largest = without
                .iter()
                .map(|m| rms(&m.torque_nm))
                .fold(0.0, f64::max);
            for missing in with {
                let left = rms(&missing.torque_nm);
                assert!(
                    left < 0.1 * largest || left < 1e-5,
                    "{} on {:?}: {left:.2e} of {largest:.2e}",
                    info.name,
                    missing.on
                );
            }
        }
    }
}
