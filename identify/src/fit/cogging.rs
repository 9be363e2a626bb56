//! Starts for a fit of cogging. Two quantities cannot be found by descent from afar: the order of the cogging, which
//! is a whole number, and the tooth at which the wheel rests when a window begins.

use parallel::parallel_map;
use plant::{EffectId, Model};

use super::comparison::traces_that_count;
use super::sensitivity::{counts, window_cost};
use super::solver::Minimum;
use super::unknowns::{Nuisance, Window};
use super::windows::guess;
use crate::records::{Output, Record, StraightLine};

/// A start for a fit of cogging.
#[derive(Clone, Debug, PartialEq)]
pub struct CoggingStart {
    /// Torque in N m, order, phase in rad.
    pub parameters: Vec<f64>,
    /// The gain in χ² that it promises in the wheel speed, to first order.
    pub gain: f64,
}

impl CoggingStart {
    /// The parameters of `effect` at this start. Parameters that the start does not determine take the values that the
    /// effect states.
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

/// The start for a fit of cogging: the order with the largest trace in the wheel speed; `None` if no log has
/// the wheel speed. Logs that are read by the teeth of their motor have their start already.
///
/// A torque a sin(nφ + ψ) against the wheel causes the speed error −(a/j_w) ∫ sin(nφ + ψ) dt, with φ the integral of
/// the measured wheel speed. For every whole order n up to 60, the residual is projected on ∫cos(nφ) dt and
/// ∫sin(nφ) dt, window by window. A straight line is removed first, because the window's start and a constant
/// torque absorb it. The order is a whole number: a common multiple of poles and slots.
pub fn cogging_start(
    records: &[&Record],
    model: &Model,
    minimum: &Minimum,
) -> Option<CoggingStart> {
    const HIGHEST_ORDER: usize = 60;
    let wheel_inertia = minimum.values[plant::WHEEL_INERTIA];
    if let Some(teeth) = records.iter().find_map(|record| record.teeth) {
        return Some(CoggingStart {
            parameters: vec![
                teeth.per_inertia * wheel_inertia,
                teeth.order,
                teeth.phase_rad,
            ],
            gain: teeth.gain,
        });
    }
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
        let mut stretches: Vec<Stretch> = vec![];
        for (window, turns) in &mut windows {
            turns.next_order();
            let (mut cosine, mut sine) = integrals(window, turns, n);
            remove_line(&window.time_s, &mut cosine);
            remove_line(&window.time_s, &mut sine);
            let weight = 1.0 / window.noise_std.powi(2);
            let longest_s = window.in_phase_s(n);
            for (k, &time_s) in window.time_s.iter().enumerate() {
                let goes_on = stretches.last().is_some_and(|stretch| {
                    stretch.record == window.record && time_s - stretch.start_s < longest_s
                });
                if !goes_on {
                    stretches.push(Stretch {
                        record: window.record,
                        start_s: time_s,
                        sums: Projection::default(),
                    });
                }
                if let Some(stretch) = stretches.last_mut() {
                    stretch
                        .sums
                        .add(weight, (cosine[k], sine[k]), window.error[k]);
                }
            }
        }
        starts.extend(start_of_order(n, &stretches, wheel_inertia));
    }
    starts.into_iter().max_by(|x, y| x.gain.total_cmp(&y.gain))
}

/// The start for one order. The phase is taken as constant over all logs, unless stretches with phases of their own
/// gain plainly more: in long logs, the phase can be lost from stretch to stretch.
fn start_of_order(order: f64, stretches: &[Stretch], wheel_inertia: f64) -> Option<CoggingStart> {
    let mut all = Projection::default();
    // At the beginning of a log, the wheel's angle is known best.
    let mut first = Projection::default();
    let (mut gain, mut weight, mut square, mut count) = (0.0, 0.0, 0.0, 0.0);
    let mut record = None;
    for stretch in stretches {
        all.join(&stretch.sums);
        if record != Some(stretch.record) {
            first.join(&stretch.sums);
            record = Some(stretch.record);
        }
        if let Some(found) = stretch.sums.solved() {
            let own = stretch.sums.cc + stretch.sums.ss;
            gain += found.gain;
            weight += own;
            square += own * (found.a * found.a + found.b * found.b);
            count += 1.0;
        }
    }
    let start = |amplitude: f64, phase: f64, gain: f64| CoggingStart {
        parameters: vec![(amplitude * wheel_inertia).max(1e-12), order, phase],
        gain,
    };
    let whole = all.solved()?;
    // The gain beyond what noise gives: the mean of χ² with two unknowns per stretch, plus three of its standard
    // deviations.
    let apart = gain - 2.0 * count - 6.0 * count.sqrt();
    if apart > PLAINLY_MORE * whole.gain.max(1.0)
        && let Some(first) = first.solved()
    {
        let amplitude = ((square - 4.0 * count).max(0.0) / weight).sqrt();
        return Some(start(amplitude, first.phase(), apart));
    }
    Some(start(whole.a.hypot(whole.b), whole.phase(), whole.gain))
}

/// Factor by which stretches with phases of their own must gain more than stretches with a common phase.
const PLAINLY_MORE: f64 = 2.0;
/// Limit for the error of the ripple's phase in rad that the integrated noise of the wheel speed causes over a
/// stretch.
const IN_PHASE_RAD: f64 = 0.5;
/// Shortest stretch, s: the length of the windows in which cogging is compared.
const SHORTEST_STRETCH_S: f64 = 0.25;

/// A part of a log over which the wheel's angle is known precisely enough.
struct Stretch {
    record: usize,
    start_s: f64,
    sums: Projection,
}

/// Sums of a projection on two series.
#[derive(Clone, Copy, Default)]
struct Projection {
    cc: f64,
    ss: f64,
    cs: f64,
    ce: f64,
    se: f64,
}

/// The result of a projection.
struct Projected {
    a: f64,
    b: f64,
    /// Gain in χ².
    gain: f64,
}

impl Projected {
    fn phase(&self) -> f64 {
        (-self.a).atan2(-self.b)
    }
}

impl Projection {
    fn add(&mut self, weight: f64, (c, s): (f64, f64), error: f64) {
        self.cc += weight * c * c;
        self.ss += weight * s * s;
        self.cs += weight * c * s;
        self.ce += weight * c * error;
        self.se += weight * s * error;
    }

    fn join(&mut self, other: &Projection) {
        self.cc += other.cc;
        self.ss += other.ss;
        self.cs += other.cs;
        self.ce += other.ce;
        self.se += other.se;
    }

    fn solved(&self) -> Option<Projected> {
        let determinant = self.cc * self.ss - self.cs * self.cs;
        if determinant <= 0.0 {
            return None;
        }
        let a = (self.ss * self.ce - self.cs * self.se) / determinant;
        let b = (self.cc * self.se - self.cs * self.ce) / determinant;
        Some(Projected {
            a,
            b,
            gain: a * self.ce + b * self.se,
        })
    }
}

/// The residual of the wheel speed in one window, with the wheel's angle.
struct WheelSpeedError {
    /// Index of the record.
    record: usize,
    time_s: Vec<f64>,
    wheel_angle_rad: Vec<f64>,
    /// Measured minus model, with its straight line removed, rad/s.
    error: Vec<f64>,
    noise_std: f64,
}

impl WheelSpeedError {
    /// Time in s over which the phase of a ripple of this order stays within [`IN_PHASE_RAD`]. The wheel's angle is the
    /// integral of its measured speed; noise σ with sampling interval h makes it drift by σ √(h t).
    fn in_phase_s(&self, order: f64) -> f64 {
        let last = self.time_s.len() - 1;
        let interval_s = (self.time_s[last] - self.time_s[0]) / last as f64;
        let walk_s = (IN_PHASE_RAD / (order * self.noise_std)).powi(2) / interval_s;
        walk_s.max(SHORTEST_STRETCH_S)
    }
}

fn wheel_speed_errors(
    records: &[&Record],
    model: &Model,
    minimum: &Minimum,
) -> Vec<WheelSpeedError> {
    let mut found = vec![];
    for (index, (record, windows)) in records.iter().zip(&minimum.windows).enumerate() {
        let traces = traces_that_count(record, windows, model, &minimum.values);
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
                record: index,
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

/// ∫ cos nφ dt and ∫ sin nφ dt over a window, sample by sample. The wheel is taken to turn evenly between samples. The
/// antiderivative over φ is used where it turns, the function itself where it rests.
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

/// Wheel angles that are tried for the start of a window, in standard deviations of its prior.
const TRIED_STD: [f64; 5] = [0.0, -2.0, -1.0, 1.0, 2.0];

/// Moves the start of every window to where the model fits best. Three kinds of start are compared: the given ones,
/// those guessed from the samples, and those with the wheel turned a little. Cogging pulls the wheel towards a
/// tooth. A window that starts on the wrong side of the tooth is in a local minimum; so is one that starts with
/// the speed that a model without cogging needed. Windows of a model without cogging are returned unchanged.
pub fn settled(
    records: &[&Record],
    model: &Model,
    values: &[f64],
    windows: Vec<Vec<Window>>,
) -> Vec<Vec<Window>> {
    if model.find(|info| info.ripple.is_some()).is_none() {
        return windows;
    }
    let settle = |record: &Record, window: Window| -> Window {
        if !counts(record, &window) {
            return window;
        }
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
        let cost = |window: &Window| window_cost(record, window, model, values);
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
            parallel_map(list, |window| {
                if has_wheel {
                    settle(record, window)
                } else {
                    window
                }
            })
        })
        .collect()
}
