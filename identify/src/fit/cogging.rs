//! Starts for a fit of cogging. Its order, a whole number, cannot be found by descent from afar; nor can the tooth at
//! which the wheel rests when a window begins (see [`super::settled`]).

use plant::{EffectId, Model};
use rayon::prelude::*;

use super::comparison::traces;
use super::solver::Minimum;
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

/// Starts for a fit of cogging, one for each order that shows most in the wheel speed, the most promising first; none
/// if no log has the wheel speed.
///
/// A torque a sin(nφ + ψ) against the wheel causes the speed error −(a/j_w) ∫ sin(nφ + ψ) dt, with φ the integral of
/// the measured wheel speed. For every whole order n up to 60, the residual is projected on ∫cos(nφ) dt and
/// ∫sin(nφ) dt, piece by piece. A parabola is removed first, because the start of the piece, a constant torque and
/// one that changes slowly absorb it. The order is a whole number: a common multiple of poles and slots.
///
/// Pieces are whole windows, in which few teeth in one turn show, and stretches of [`SHORTEST_STRETCH_S`], in which
/// the slow misfit of a long window is nearly a parabola. Where the two find different orders, both are starts.
pub fn cogging_starts(records: &[&Record], model: &Model, minimum: &Minimum) -> Vec<CoggingStart> {
    let wheel_inertia = minimum.values[plant::WHEEL_INERTIA];
    let errors = speed_errors(records, model, minimum);
    let mut short: Vec<SpeedError> = errors.iter().flat_map(SpeedError::pieces).collect();
    // In the order of time, as stretches are.
    let first_s = |piece: &SpeedError| piece.time_s[0];
    short.sort_by(|one, other| {
        let by_time = first_s(one).total_cmp(&first_s(other));
        one.record.cmp(&other.record).then(by_time)
    });
    let mut starts: Vec<CoggingStart> = [short, errors]
        .into_par_iter()
        .filter_map(|pieces| start_in(pieces, wheel_inertia))
        .collect();
    starts.dedup_by_key(|start| start.parameters[1]);
    starts
}

/// The start with the order of the largest trace in these pieces.
fn start_in(pieces: Vec<SpeedError>, wheel_inertia: f64) -> Option<CoggingStart> {
    const HIGHEST_ORDER: usize = 60;
    let mut windows: Vec<(SpeedError, Turns)> = pieces
        .into_iter()
        .filter_map(SpeedError::without_trend)
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
            remove_trend(&window.time_s, &mut cosine);
            remove_trend(&window.time_s, &mut sine);
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

/// Fewest samples of a piece: a parabola and two projections have five unknowns.
const FEWEST_SAMPLES: usize = 6;
/// Samples of a short piece in a coarse log.
const SAMPLES_OF_A_PIECE: usize = 16;

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

/// The residual of the wheel speed in one window, with the wheel's angle. Where the body moves too, its rate shows the
/// same torque, often more clearly: the residual of the rate is then another one, in the wheel speed that goes with it.
struct SpeedError {
    /// Index of the record.
    record: usize,
    time_s: Vec<f64>,
    wheel_angle_rad: Vec<f64>,
    /// Measured minus model, rad/s.
    error: Vec<f64>,
    noise_std: f64,
    /// Noise of the measured wheel speed, of which the wheel's angle is the integral, rad/s.
    speed_noise_std: f64,
}

impl SpeedError {
    /// The same error with its parabola removed; `None` if there are too few samples.
    fn without_trend(mut self) -> Option<SpeedError> {
        if self.error.len() < FEWEST_SAMPLES {
            return None;
        }
        remove_trend(&self.time_s, &mut self.error);
        Some(self)
    }

    /// The same error in pieces of [`SHORTEST_STRETCH_S`], or of [`SAMPLES_OF_A_PIECE`] where that is longer.
    fn pieces(&self) -> Vec<SpeedError> {
        let mut pieces = vec![];
        let mut from = 0;
        while from < self.time_s.len() {
            let end_s = self.time_s[from] + SHORTEST_STRETCH_S;
            let to = self.time_s.partition_point(|&time_s| time_s < end_s);
            let to = to.max(from + SAMPLES_OF_A_PIECE).min(self.time_s.len());
            pieces.push(SpeedError {
                record: self.record,
                time_s: self.time_s[from..to].to_vec(),
                wheel_angle_rad: self.wheel_angle_rad[from..to].to_vec(),
                error: self.error[from..to].to_vec(),
                noise_std: self.noise_std,
                speed_noise_std: self.speed_noise_std,
            });
            from = to;
        }
        pieces
    }

    /// Time in s over which the phase of a ripple of this order stays within [`IN_PHASE_RAD`]. The wheel's angle is the
    /// integral of its measured speed; noise σ with sampling interval h makes it drift by σ √(h t).
    fn in_phase_s(&self, order: f64) -> f64 {
        let last = self.time_s.len() - 1;
        let interval_s = (self.time_s[last] - self.time_s[0]) / last as f64;
        let walk_s = (IN_PHASE_RAD / (order * self.speed_noise_std)).powi(2) / interval_s;
        walk_s.max(SHORTEST_STRETCH_S)
    }
}

fn speed_errors(records: &[&Record], model: &Model, minimum: &Minimum) -> Vec<SpeedError> {
    let [total, wheel] = [plant::TOTAL_INERTIA, plant::WHEEL_INERTIA].map(|at| minimum.values[at]);
    let mut found = vec![];
    for (index, (record, windows)) in records.iter().zip(&minimum.windows).enumerate() {
        let Some(speed) = record.channel(Output::WheelSpeed) else {
            continue;
        };
        let traces = traces(record, windows, model, &minimum.values);
        let angle_rad = record.wheel_angles();
        for window in windows {
            for (channel, trace) in record.channels.iter().zip(&traces) {
                // A torque between body and wheel turns the body the other way.
                let scale = match channel.output {
                    Output::WheelSpeed => 1.0,
                    Output::Rate => -(total - wheel) / wheel,
                    _ => continue,
                };
                let mut one = SpeedError {
                    record: index,
                    time_s: vec![],
                    wheel_angle_rad: vec![],
                    error: vec![],
                    noise_std: channel.noise_std * scale.abs(),
                    speed_noise_std: speed.noise_std,
                };
                for k in window.samples.clone() {
                    let error = channel.samples[k] - trace.predicted[k];
                    if error.is_finite() && record.weight[k] > 0.0 {
                        one.time_s.push(record.time_s[k]);
                        one.wheel_angle_rad.push(angle_rad[k]);
                        one.error.push(scale * error);
                    }
                }
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
fn integrals(window: &SpeedError, turns: &Turns, n: f64) -> (Vec<f64>, Vec<f64>) {
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

/// Subtracts the least-squares parabola.
fn remove_trend(time_s: &[f64], values: &mut [f64]) {
    let count = time_s.len() as f64;
    let middle_s = time_s.iter().sum::<f64>() / count;
    let mut square: Vec<f64> = time_s.iter().map(|t| (t - middle_s).powi(2)).collect();
    remove_line(time_s, &mut square);
    remove_line(time_s, values);
    let own: f64 = square.iter().map(|q| q * q).sum();
    if own > 0.0 {
        let shared: f64 = square
            .iter()
            .zip(&*values)
            .map(|(q, value)| q * value)
            .sum();
        for (value, q) in values.iter_mut().zip(&square) {
            *value -= shared / own * q;
        }
    }
}

/// Subtracts the least-squares line.
fn remove_line(time_s: &[f64], values: &mut [f64]) {
    let line = StraightLine::through(time_s.iter().copied().zip(values.iter().copied()));
    for (t, value) in time_s.iter().zip(values) {
        *value -= line.at(*t);
    }
}
