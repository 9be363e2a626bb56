//! Where a fit of cogging may start: its order is a whole number, which no fit can find from afar, and so is
//! the tooth on which the wheel rests while a window begins.

use plant::{EffectId, Model};
use rayon::prelude::*;

use super::comparison::traces;
use super::sensitivity::normal;
use super::solver::Minimum;
use super::unknowns::{Nuisance, Unknowns, Window};
use super::windows::guess;
use crate::records::{Output, Record, StraightLine};

/// Where a fit of cogging may start.
#[derive(Clone, Debug, PartialEq)]
pub struct CoggingStart {
    /// Torque in N m, order, phase in rad.
    pub parameters: Vec<f64>,
    /// χ² that it takes from the wheel speed to first order.
    pub gain: f64,
}

impl CoggingStart {
    /// The parameters of an effect that is such a ripple: what this start does not give is as the effect
    /// states it.
    pub fn parameters_of(&self, effect: EffectId) -> Vec<f64> {
        let info = effect.info();
        let mut parameters = info.starts[0].to_vec();
        if let Some(ripple) = info.ripple {
            for (place, value) in [ripple.amplitude, ripple.order, ripple.phase]
                .into_iter()
                .zip(&self.parameters)
            {
                parameters[place] = *value;
            }
        }
        parameters
    }
}

/// A start for cogging: the order whose trace is largest in the wheel speed; `None` where no log shows
/// the wheel's speed.
///
/// A torque a sin(nφ + ψ) against the wheel leaves the speed error −(a/j_w) ∫ sin(nφ + ψ) dt. For every
/// whole order n up to 60 the residual is projected on ∫cos(nφ) dt and ∫sin(nφ) dt, window by window and
/// without the straight line that a window's start and a constant torque take up; φ is the integral of
/// the measured wheel speed. A cogging order is a whole number: a common multiple of poles and slots.
pub fn cogging_start(
    records: &[&Record],
    model: &Model,
    minimum: &Minimum,
) -> Option<CoggingStart> {
    const HIGHEST_ORDER: usize = 60;
    let wheel_inertia = minimum.values[plant::WHEEL_INERTIA];
    let mut windows: Vec<(WheelSpeedError, Turns)> = wheel_speed_errors(records, model, minimum)
        .into_iter()
        .map(|window| {
            let turns = Turns::new(&window.wheel_angle_rad);
            (window, turns)
        })
        .collect();
    let mut starts: Vec<CoggingStart> = vec![];
    for order in 1..=HIGHEST_ORDER {
        let n = order as f64;
        let (mut cc, mut ss, mut cs, mut ce, mut se) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (window, turns) in &mut windows {
            turns.next_order();
            let (mut cosine, mut sine) = integrals(window, turns, n);
            remove_line(&window.time_s, &mut cosine);
            remove_line(&window.time_s, &mut sine);
            let weight = 1.0 / window.noise_std.powi(2);
            for ((c, s), error) in cosine.iter().zip(&sine).zip(&window.error) {
                cc += weight * c * c;
                ss += weight * s * s;
                cs += weight * c * s;
                ce += weight * c * error;
                se += weight * s * error;
            }
        }
        let determinant = cc * ss - cs * cs;
        if determinant <= 0.0 {
            continue;
        }
        let a = (ss * ce - cs * se) / determinant;
        let b = (cc * se - cs * ce) / determinant;
        let amplitude = a.hypot(b) * wheel_inertia;
        starts.push(CoggingStart {
            parameters: vec![amplitude.max(1e-12), n, (-a).atan2(-b)],
            gain: a * ce + b * se,
        });
    }
    starts.into_iter().max_by(|x, y| x.gain.total_cmp(&y.gain))
}

/// What the wheel speed of one window lacks, over the angle of the wheel.
struct WheelSpeedError {
    time_s: Vec<f64>,
    wheel_angle_rad: Vec<f64>,
    /// Measured − model without its straight line, rad/s.
    error: Vec<f64>,
    noise_std: f64,
}

fn wheel_speed_errors(
    records: &[&Record],
    model: &Model,
    minimum: &Minimum,
) -> Vec<WheelSpeedError> {
    let mut found = vec![];
    for (record, windows) in records.iter().zip(&minimum.windows) {
        let traces = traces(record, windows, model, &minimum.values);
        let channels = record.channels.iter().zip(&traces);
        let Some((channel, trace)) = channels
            .into_iter()
            .find(|(channel, _)| channel.output == Output::WheelSpeed)
        else {
            continue;
        };
        let angle_rad = record.wheel_angles();
        for window in windows {
            let mut one = WheelSpeedError {
                time_s: vec![],
                wheel_angle_rad: vec![],
                error: vec![],
                noise_std: channel.noise_std,
            };
            for k in window.samples.clone() {
                let error = channel.samples[k] - trace.predicted[k];
                if error.is_finite() && record.weight[k] > 0.0 {
                    one.time_s.push(record.time_s[k]);
                    one.wheel_angle_rad.push(angle_rad[k]);
                    one.error.push(error);
                }
            }
            if one.error.len() > 4 {
                remove_line(&one.time_s, &mut one.error);
                found.push(one);
            }
        }
    }
    found
}

/// cos nφ and sin nφ at every sample, order by order: e^{inφ} = e^{i(n−1)φ} e^{iφ}.
struct Turns {
    first: Vec<(f64, f64)>,
    /// (cos nφ, sin nφ).
    of_order: Vec<(f64, f64)>,
}

impl Turns {
    /// At order 0.
    fn new(angle_rad: &[f64]) -> Turns {
        let pair = |angle: &f64| {
            let (sin, cos) = angle.sin_cos();
            (cos, sin)
        };
        Turns {
            first: angle_rad.iter().map(pair).collect(),
            of_order: vec![(1.0, 0.0); angle_rad.len()],
        }
    }

    fn next_order(&mut self) {
        for ((cos, sin), (c, s)) in self.of_order.iter_mut().zip(&self.first) {
            (*cos, *sin) = (*cos * c - *sin * s, *sin * c + *cos * s);
        }
    }
}

/// ∫ cos nφ dt and ∫ sin nφ dt over a window, sample by sample, with the wheel turning evenly between
/// samples: the antiderivative over φ where it turns, the function itself where it rests.
fn integrals(window: &WheelSpeedError, turns: &Turns, n: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut cosine, mut sine) = (vec![0.0], vec![0.0]);
    let mut sums = (0.0, 0.0);
    for k in 1..window.time_s.len() {
        let turned = window.wheel_angle_rad[k] - window.wheel_angle_rad[k - 1];
        let step_s = window.time_s[k] - window.time_s[k - 1];
        let (from, to) = (turns.of_order[k - 1], turns.of_order[k]);
        if turned.abs() > 1e-6 {
            let scale = step_s / (n * turned);
            sums.0 += (to.1 - from.1) * scale;
            sums.1 += (from.0 - to.0) * scale;
        } else {
            sums.0 += from.0 * step_s;
            sums.1 += from.1 * step_s;
        }
        cosine.push(sums.0);
        sine.push(sums.1);
    }
    (cosine, sine)
}

/// Subtracts the least-squares line.
fn remove_line(time_s: &[f64], values: &mut [f64]) {
    let line = StraightLine::through(time_s.iter().copied().zip(values.iter().copied()));
    for (t, value) in time_s.iter().zip(values) {
        *value -= line.at(*t);
    }
}

/// Wheel angles that are tried for the start of a window, in standard deviations of what is known of it.
const TRIED_STD: [f64; 5] = [0.0, -2.0, -1.0, 1.0, 2.0];

/// The windows with their starts moved to where the model fits best, among the given ones, those that the
/// samples show, and the same a little further on the wheel. Cogging pulls the wheel towards a tooth; a
/// window that starts on the wrong side of it is a local minimum, and so is one that starts with the speed
/// which a model without cogging needed. Windows of a model without cogging stay as they are.
pub fn settled(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: Vec<Vec<Window>>,
) -> Vec<Vec<Window>> {
    if model.find(|info| info.ripple.is_some()).is_none() {
        return windows;
    }
    let unknowns = Unknowns::new(model, &[]);
    let settle = |record: &Record, window: Window| -> Window {
        let nuisances = Nuisance::of(record);
        let wheel_angle = nuisances
            .iter()
            .position(|&local| local == Nuisance::WheelAngle);
        let shift = wheel_angle.and_then(|at| {
            let std = Nuisance::WheelAngle.prior_std(record, window.samples.start)?;
            Some((at, std))
        });
        let guessed = guess(record, values, window.samples.clone());
        let mut tried = vec![window, guessed];
        if let Some((at, std)) = shift {
            for mut start in tried.clone() {
                tried.extend(TRIED_STD.map(|shift| {
                    start.nuisances[at] = shift * std;
                    start.clone()
                }));
            }
        }
        let cost = |window: &Window| normal(record, window, model, values, &unknowns, &[]).cost;
        let mut costs = tried.iter().map(cost).enumerate();
        let first = costs.next().unwrap_or((0, 0.0));
        let best = costs.fold(
            first,
            |best, next| if next.1 < best.1 { next } else { best },
        );
        tried.swap_remove(best.0)
    };
    records
        .iter()
        .zip(windows)
        .map(|(record, list)| {
            let has_wheel = record.channel(Output::WheelSpeed).is_some();
            list.into_par_iter()
                .map(|window| {
                    if has_wheel {
                        settle(record, window)
                    } else {
                        window
                    }
                })
                .collect()
        })
        .collect()
}
