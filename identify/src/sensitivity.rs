//! One window of a log: simulated with exact derivatives, compared, summed into normal equations.

use nalgebra::{DMatrix, DVector};
use plant::{Current, Dual, EffectId, Kind, Model, Plant, Scalar, Smoothing, State};

use crate::record::{Output, Record, RecordedCurrent};

/// An unknown that belongs to one window: its start, or the current that nobody wrote down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Local {
    /// Body angle at the start, rad.
    Angle,
    /// Body rate at the start, rad/s.
    Rate,
    /// Wheel speed at the start, rad/s.
    WheelSpeed,
    /// Current held throughout, A.
    Current,
    /// Zero of a quantised angle, rad. Rounding or truncation: the zero of a channel with step q is
    /// known to ±q/2 only, so that it is an unknown of the log with standard deviation q/√12.
    AngleZero,
    /// Wheel angle at the start beyond the one that the measured wheel speed gives, rad. Its noise adds up
    /// to a random walk over the log, by which a window in the middle does not know where the wheel is.
    WheelAngle,
    /// Current that was commanded before the log began, A: nobody recorded it, and a delay or a lag carries
    /// it into the log. Only the window with the first sample has it.
    PastCurrent,
}

impl Local {
    /// The unknowns of every window of this record, as its kind and channels allow; the last is left out
    /// where it is [`Local::PastCurrent`] and the window does not begin with the log.
    pub fn of(record: &Record) -> Vec<Local> {
        let measures = |output| record.channel(output).is_some();
        let mut locals = vec![];
        if record.kind != Kind::SpinUp && (measures(Output::Angle) || measures(Output::Rate)) {
            locals.extend([Local::Angle, Local::Rate]);
        }
        if record.kind != Kind::FreeSwing && measures(Output::WheelSpeed) {
            locals.push(Local::WheelSpeed);
        }
        if matches!(record.current, RecordedCurrent::Unknown) {
            locals.push(Local::Current);
        }
        if angle_quantum(record).is_some() {
            locals.push(Local::AngleZero);
        }
        if matches!(record.kind, Kind::Balance | Kind::Driven) && measures(Output::WheelSpeed) {
            locals.push(Local::WheelAngle);
        }
        let is_commanded = matches!(record.current, RecordedCurrent::Known(_));
        if record.kind != Kind::FreeSwing && is_commanded && !record.current_is_measured {
            locals.push(Local::PastCurrent);
        }
        locals
    }

    /// Whether the motion of this model depends on the unknown.
    pub fn acts_on(self, model: &Model) -> bool {
        match self {
            Local::WheelAngle => model.find(|info| info.uses_wheel_angle).is_some(),
            Local::PastCurrent => model.find(|info| info.timing.is_some()).is_some(),
            _ => true,
        }
    }

    /// Standard deviation with which the unknown of a window that begins at the sample `first` is known
    /// beforehand, if it is.
    pub fn prior_std(self, record: &Record, first: usize) -> Option<f64> {
        match self {
            Local::AngleZero => angle_quantum(record).map(|quantum| quantum / 12f64.sqrt()),
            Local::WheelAngle => {
                let noise = record.channel(Output::WheelSpeed)?.noise_std;
                let span_s = record.time_s[first] - record.time_s[0];
                let steps = first.max(1) as f64;
                // At the first sample the angle is zero by definition.
                Some((noise * span_s / steps.sqrt()).max(LEAST_WHEEL_ANGLE_STD_RAD))
            }
            Local::PastCurrent => {
                // Like the commands that were recorded.
                let finite = record
                    .current_a
                    .iter()
                    .filter(|current| current.is_finite());
                let largest = finite.fold(0.0f64, |largest, current| largest.max(current.abs()));
                Some(largest.max(LEAST_CURRENT_A))
            }
            _ => None,
        }
    }
}

/// Stands for "no current" where a prior needs a width.
const LEAST_CURRENT_A: f64 = 1e-6;
/// Stands for "known exactly" among the wheel angles of windows.
const LEAST_WHEEL_ANGLE_STD_RAD: f64 = 1e-4;

/// The step of the angle in a log whose one window spans it.
fn angle_quantum(record: &Record) -> Option<f64> {
    match record.kind {
        Kind::FreeSwing | Kind::Driven => record.channel(Output::Angle)?.quantum,
        Kind::SpinUp | Kind::Balance => None,
    }
}

/// A stretch of a log that is simulated in one piece from its own start.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Its samples.
    pub samples: std::ops::Range<usize>,
    /// Values of the local unknowns, in the order of [`Local::of`].
    pub locals: Vec<f64>,
}

/// The unknowns of a fit: which positions of the parameter vector are free. A free parameter whose
/// description says so is moved in its logarithm.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// Positions in the parameter vector, increasing.
    pub free: Vec<usize>,
    /// For each free one: the fit moves ln(value).
    pub logarithmic: Vec<bool>,
    /// For each free one: where it may be, in the parameter's own unit.
    pub bounds: Vec<(f64, f64)>,
}

impl Unknowns {
    /// The unknowns at these positions of the parameter vector of `model`.
    pub fn new(model: &Model, free: &[usize]) -> Unknowns {
        let infos = model.parameters();
        Unknowns {
            free: free.to_vec(),
            logarithmic: free.iter().map(|&at| infos[at].logarithmic).collect(),
            bounds: free.iter().map(|&at| infos[at].bounds).collect(),
        }
    }

    /// The derivative of the parameter with respect to what the fit moves.
    pub fn slope(&self, unknown: usize, value: f64) -> f64 {
        if self.logarithmic[unknown] {
            value
        } else {
            1.0
        }
    }
}

/// Normal equations of one window: (Hgg Hgl; Hlg Hll) and right-hand sides, for the unknowns in the
/// order globals, acting locals. Residuals are divided by the noise of their channel.
#[derive(Clone, Debug)]
pub struct WindowNormal {
    /// Sum over the samples of sensitivity times its transpose, (p+l)×(p+l).
    pub hessian: DMatrix<f64>,
    /// Sum of sensitivity times residual, p+l.
    pub gradient: DVector<f64>,
    /// Sum of squared residuals; infinite if the simulation left the finite numbers.
    pub cost: f64,
    /// Which of the window's unknowns act, as indices into [`Window::locals`].
    pub locals: Vec<usize>,
}

/// What carries derivatives in the simulation of a window, in this order.
struct Lanes<'a> {
    /// Indices into the unknowns.
    globals: &'a [usize],
    /// The unknowns of the window on which the motion of the model depends, as indices into
    /// [`Window::locals`].
    locals: Vec<usize>,
}

impl Lanes<'_> {
    fn of<'a>(record: &Record, window: &Window, model: &Model, globals: &'a [usize]) -> Lanes<'a> {
        let locals = Local::of(record).into_iter().zip(&window.locals);
        let locals = locals
            .enumerate()
            .filter_map(|(index, (local, _))| local.acts_on(model).then_some(index))
            .collect();
        Lanes { globals, locals }
    }

    fn count(&self) -> usize {
        self.globals.len() + self.locals.len()
    }

    /// The lane of an unknown of the window, if it has one.
    fn of_local(&self, local: usize) -> Option<usize> {
        let at = self.locals.iter().position(|&acting| acting == local)?;
        Some(self.globals.len() + at)
    }
}

/// What a window's simulation hands out for one observation.
pub struct Observation<'a> {
    /// Index of the sample in the log.
    pub sample: usize,
    /// Index of the channel in the record.
    pub channel: usize,
    /// (measured − model)/noise.
    pub residual: f64,
    /// ∂(model/noise)/∂unknown, globals then acting locals.
    pub sensitivity: &'a [f64],
}

macro_rules! with_lanes {
    ($count:expr, $function:ident, $($argument:expr),*) => {
        match $count {
            0..=4 => $function::<4>($($argument),*),
            5..=6 => $function::<6>($($argument),*),
            7..=8 => $function::<8>($($argument),*),
            9..=10 => $function::<10>($($argument),*),
            11..=12 => $function::<12>($($argument),*),
            13..=16 => $function::<16>($($argument),*),
            _ => $function::<24>($($argument),*),
        }
    };
}

/// The most unknowns, globals and locals together, that one window can have.
pub const MAX_UNKNOWNS: usize = 24;

/// Whether an effect can show in an experiment of this kind: body terms do not while the body is
/// clamped, nor wheel terms while the wheel is locked.
pub fn acts(effect: EffectId, kind: Kind) -> bool {
    match effect.info().role {
        plant::Role::Body | plant::Role::Sensor => kind != Kind::SpinUp,
        plant::Role::Wheel | plant::Role::Motor => kind != Kind::FreeSwing,
    }
}

/// The free parameters that this record can say anything about, as indices into
/// [`Unknowns::free`].
pub fn relevant(record: &Record, model: &Model, unknowns: &Unknowns) -> Vec<usize> {
    let shows = |position: usize| match position {
        plant::TOTAL_INERTIA | plant::GRAVITY_TORQUE => record.kind != Kind::SpinUp,
        plant::WHEEL_INERTIA | plant::TORQUE_CONSTANT => record.kind != Kind::FreeSwing,
        _ => model
            .effect_at(position)
            .is_some_and(|effect| acts(effect, record.kind)),
    };
    (0..unknowns.free.len())
        .filter(|&unknown| shows(unknowns.free[unknown]))
        .collect()
}

/// Whether two models with their parameters move the same in experiments of this kind: the same
/// effects act there, with the same values.
pub fn moves_alike(kind: Kind, one: (&Model, &[f64]), other: (&Model, &[f64])) -> bool {
    let acting = |model: &Model, values: &[f64]| -> Vec<(EffectId, Vec<f64>)> {
        model
            .ranges()
            .filter(|&(effect, _)| acts(effect, kind))
            .map(|(effect, own)| (effect, values[own].to_vec()))
            .collect()
    };
    let base = 0..plant::BASE_PARAMETERS.len();
    one.1[base.clone()] == other.1[base] && acting(one.0, one.1) == acting(other.0, other.1)
}

/// The start of a window from its local unknowns: the state with the current before it, a held current, the
/// angle's zero.
fn start_state<S: Scalar>(locals: &[Local], values: &[S]) -> (State<S>, S, S) {
    let mut state = State::rest();
    let mut current = S::zero();
    let mut angle_zero = S::zero();
    for (local, &value) in locals.iter().zip(values) {
        match local {
            Local::Angle => state.angle_rad = value,
            Local::Rate => state.rate_rad_s = value,
            Local::WheelSpeed => state.wheel_speed_rad_s = value,
            Local::Current => current = value,
            Local::AngleZero => angle_zero = value,
            Local::WheelAngle => state.wheel_angle_rad = value,
            Local::PastCurrent => state.current_a = value,
        }
    }
    (state, current, angle_zero)
}

fn plant_of<S: Scalar>(
    record: &Record,
    model: &Model,
    values: &[S],
    smoothing: Smoothing,
) -> Plant<S> {
    let plant = Plant::smoothed(model, values, record.kind, smoothing);
    if record.current_is_measured {
        plant.with_measured_current()
    } else {
        plant
    }
}

/// Presliding friction is followed over this many times its presliding distance μ/σ before a window
/// begins; it has then forgotten what was before (e⁻⁴ of it is left).
const MEMORY_DISTANCES: f64 = 4.0;

/// The start of a window in the middle of a log with what the log says of the time before it: the
/// angle of the wheel for cogging, the torque of presliding friction.
fn with_memory<S: Scalar>(
    record: &Record,
    window: &Window,
    model: &Model,
    plant: &Plant<S>,
    start: State<S>,
) -> State<S> {
    let mut state = start;
    let first = window.samples.start;
    if first == 0 {
        return state;
    }
    if model.find(|info| info.uses_wheel_angle).is_some() {
        state.wheel_angle_rad += S::constant(record.wheel_angle_before(first));
    }
    if let Some(distance_rad) = plant.memory_distance_rad() {
        let mut far = MEMORY_DISTANCES * distance_rad;
        let mut travel: Vec<f64> = vec![];
        for step in record.body_travel_before(first) {
            travel.push(step);
            far -= step.abs();
            if far < 0.0 {
                break;
            }
        }
        for displacement in travel.into_iter().rev() {
            state.friction_torque =
                plant.remember(state.friction_torque, S::constant(displacement));
        }
    }
    state
}

fn current_of<S: Scalar>(record: &Record, held: S) -> Current<'_, S> {
    match &record.current {
        RecordedCurrent::Known(input) => Current::Recorded(input),
        RecordedCurrent::Unknown => Current::Held(held),
    }
}

fn run_lanes<const N: usize>(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    lanes: &Lanes,
    // Not generic, so that the integrator is compiled once for each number of lanes.
    each: &mut dyn FnMut(usize, &plant::Reading<Dual<N>>),
) {
    let mut duals: Vec<Dual<N>> = values.iter().map(|&value| Dual::constant(value)).collect();
    for (lane, &unknown) in lanes.globals.iter().enumerate() {
        let position = unknowns.free[unknown];
        let mut dual = Dual::constant(values[position]);
        dual.derivatives[lane] = unknowns.slope(unknown, values[position]);
        duals[position] = dual;
    }
    let locals = Local::of(record);
    let starts: Vec<Dual<N>> = window
        .locals
        .iter()
        .enumerate()
        .map(|(index, &value)| match lanes.of_local(index) {
            Some(lane) => Dual::variable(value, lane),
            None => Dual::constant(value),
        })
        .collect();
    let (start, held, angle_zero) = start_state(&locals, &starts);
    let plant = plant_of(record, model, &duals, Smoothing::SIMULATION);
    let start = with_memory(record, window, model, &plant, start);
    plant.run(
        start,
        &record.time_s,
        window.samples.clone(),
        current_of(record, held),
        None,
        |k, reading, _| {
            let mut reading = *reading;
            reading.angle_rad += angle_zero;
            each(k, &reading);
        },
    );
}

/// The normal equations of a window. Samples of weight 0 and missing measurements do not count.
pub fn normal(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    globals: &[usize],
) -> WindowNormal {
    normal_observed(
        record,
        window,
        model,
        values,
        unknowns,
        globals,
        &mut |_| {},
    )
}

/// As [`normal`]; every observation that counts is handed to `each` as well, sample by sample.
pub fn normal_observed(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    globals: &[usize],
    each: &mut dyn FnMut(Observation),
) -> WindowNormal {
    let lanes = Lanes::of(record, window, model, globals);
    with_lanes!(
        lanes.count(),
        normal_lanes,
        record,
        window,
        model,
        values,
        unknowns,
        lanes,
        each
    )
}

fn normal_lanes<const N: usize>(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    lanes: Lanes,
    each: &mut dyn FnMut(Observation),
) -> WindowNormal {
    let count = lanes.count();
    let mut hessian = [[0.0; N]; N];
    let mut gradient = [0.0; N];
    let mut cost = 0.0;
    if is_impossible(record, values) {
        return WindowNormal {
            hessian: DMatrix::zeros(count, count),
            gradient: DVector::zeros(count),
            cost: f64::INFINITY,
            locals: lanes.locals,
        };
    }
    run_lanes::<N>(
        record,
        window,
        model,
        values,
        unknowns,
        &lanes,
        &mut |k, reading| {
            let weight = record.weight[k];
            if weight == 0.0 {
                return;
            }
            for (index, channel) in record.channels.iter().enumerate() {
                let measured = channel.samples[k];
                if measured.is_nan() {
                    continue;
                }
                let output = channel.output.of(reading);
                let scale = weight / channel.noise_std;
                let residual = (measured - output.value) * scale;
                cost += residual * residual;
                let mut sensitivity = output.derivatives;
                for lane in &mut sensitivity {
                    *lane *= scale;
                }
                for row in 0..count {
                    gradient[row] += sensitivity[row] * residual;
                    // The lower triangle is filled by symmetry at the end.
                    for column in 0..N {
                        hessian[row][column] += sensitivity[row] * sensitivity[column];
                    }
                }
                each(Observation {
                    sample: k,
                    channel: index,
                    residual,
                    sensitivity: &sensitivity[..count],
                });
            }
        },
    );
    for (local, value, std) in priors(record, window) {
        cost += (value / std).powi(2);
        let Some(lane) = lanes.of_local(local) else {
            continue;
        };
        gradient[lane] -= value / (std * std);
        hessian[lane][lane] += 1.0 / (std * std);
    }
    if !cost.is_finite() {
        cost = f64::INFINITY;
    }
    WindowNormal {
        hessian: DMatrix::from_fn(count, count, |row, column| hessian[row][column]),
        gradient: DVector::from_fn(count, |row, _| gradient[row]),
        cost,
        locals: lanes.locals,
    }
}

/// The unknowns of a window that are known beforehand: index, value, standard deviation.
fn priors(record: &Record, window: &Window) -> Vec<(usize, f64, f64)> {
    let locals = Local::of(record).into_iter().zip(&window.locals);
    locals
        .enumerate()
        .filter_map(|(index, (local, &value))| {
            let std = local.prior_std(record, window.samples.start)?;
            Some((index, value, std))
        })
        .collect()
}

/// Whether the wheel alone would have more inertia than body and wheel together.
fn is_impossible(record: &Record, values: &[f64]) -> bool {
    matches!(record.kind, Kind::Balance | Kind::Driven)
        && values[plant::WHEEL_INERTIA] >= values[plant::TOTAL_INERTIA]
}

/// The cost of [`normal`] without derivatives.
pub fn window_cost(record: &Record, window: &Window, model: &Model, values: &[f64]) -> f64 {
    if is_impossible(record, values) {
        return f64::INFINITY;
    }
    let mut cost = 0.0;
    simulate(record, window, model, values, |k, reading, _| {
        let weight = record.weight[k];
        for channel in &record.channels {
            let measured = channel.samples[k];
            if weight > 0.0 && !measured.is_nan() {
                let scale = weight / channel.noise_std;
                cost += ((measured - channel.output.of(reading)) * scale).powi(2);
            }
        }
    });
    for (_, value, std) in priors(record, window) {
        cost += (value / std).powi(2);
    }
    if cost.is_finite() {
        cost
    } else {
        f64::INFINITY
    }
}

/// Simulates a window without derivatives; `each` gets the index of the sample and the model's
/// reading.
pub fn simulate(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    each: impl FnMut(usize, &plant::Reading<f64>, &State<f64>),
) {
    simulate_smoothed(record, window, model, values, Smoothing::SIMULATION, each);
}

/// As [`simulate`], with another smoothing of dry friction.
pub fn simulate_smoothed(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    smoothing: Smoothing,
    mut each: impl FnMut(usize, &plant::Reading<f64>, &State<f64>),
) {
    let (start, held, angle_zero) = start_state(&Local::of(record), &window.locals);
    let plant = plant_of(record, model, values, smoothing);
    let start = with_memory(record, window, model, &plant, start);
    plant.run(
        start,
        &record.time_s,
        window.samples.clone(),
        current_of(record, held),
        None,
        |k, reading, state| {
            let mut reading = *reading;
            reading.angle_rad += angle_zero;
            each(k, &reading, state);
        },
    );
}
