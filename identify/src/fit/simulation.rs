//! The simulation of one window of a log. Its start comes from the window's nuisance parameters, and from what the log
//! says about the time before the window.

use plant::{Current, EarlyStep, Model, Plant, Reading, Scalar, Smoothing, State};

use super::unknowns::{Nuisance, Window};
use crate::records::{Record, RecordedCurrent};

/// The start of a window as its local unknowns say.
struct Start<S> {
    /// With the current before it.
    state: State<S>,
    /// A current that is held, in A.
    held_a: S,
    /// The zero of the angle in rad.
    angle_zero: S,
    /// See [`Nuisance::PastMotion`].
    motion_before: S,
}

/// The steps of the command within a window whose instants are unknowns of the fit, when they came. `values` are the
/// window's nuisance parameters.
pub(crate) fn early_steps<S: Scalar>(
    record: &Record,
    window: &Window,
    values: &[S],
) -> Vec<EarlyStep<S>> {
    let mut steps = vec![];
    if record.unknown_steps.is_empty() {
        return steps;
    }
    for (local, &value) in Nuisance::of(record).iter().zip(values) {
        let Nuisance::EarlyStep(at) = *local else {
            continue;
        };
        if local.lies_in(record, window) {
            let step = &record.unknown_steps[at];
            steps.push(EarlyStep {
                sample_s: step.sample_s,
                change_a: step.change_a,
                earlier_s: share_of_interval(value) * (step.interval_s + 2.0 * step.margin_s)
                    - step.margin_s,
            });
        }
    }
    steps
}

/// The share of an interval before a quantile `z` of the standard normal distribution: every instant of the interval is
/// then as likely as any other, and none lies outside. The logistic curve is within 0.01 of the distribution function
/// (Bowling et al. 2009).
fn share_of_interval<S: Scalar>(z: S) -> S {
    S::constant(1.0) / (S::constant(1.0) + (z * -STEEPNESS).exp())
}

/// The quantile whose [`share_of_interval`] this is; `share` lies between 0 and 1.
pub(super) fn quantile_of(share: f64) -> f64 {
    (share / (1.0 - share)).ln() / STEEPNESS
}

/// See [`share_of_interval`].
const STEEPNESS: f64 = 1.702;

fn start_of<S: Scalar>(nuisances: &[Nuisance], values: &[S]) -> Start<S> {
    let mut state = State::rest();
    let mut current = S::zero();
    let mut angle_zero = S::zero();
    let mut motion_before = S::zero();
    for (local, &value) in nuisances.iter().zip(values) {
        match local {
            Nuisance::Angle => state.angle_rad = value,
            Nuisance::Rate => state.rate_rad_s = value,
            Nuisance::WheelSpeed => state.wheel_speed_rad_s = value,
            Nuisance::Current => current = value,
            Nuisance::AngleZero => angle_zero = value,
            Nuisance::WheelAngle => state.wheel_angle_rad = value,
            Nuisance::EarlyStep(_) => {}
            Nuisance::PastMotion => motion_before = value,
            Nuisance::PastCurrent => state.current_a = value,
        }
    }
    Start {
        state,
        held_a: current,
        angle_zero,
        motion_before,
    }
}

/// The plant of a record; without the motor's delay, lag and static stages if the record has the measured current.
pub(super) fn plant_of<S: Scalar>(
    record: &Record,
    model: &Model,
    values: &[S],
    smoothing: Smoothing,
) -> Plant<S> {
    let plant = Plant::smoothed(model, values, record.kind, smoothing).for_log(&record.name);
    if record.current_is_measured {
        plant.with_measured_current()
    } else {
        plant
    }
}

/// Distance over which presliding friction is simulated before a window begins, in units of its presliding distance
/// μ/σ. After this distance, e⁻⁴ of the initial state is left.
const MEMORY_DISTANCES: f64 = 4.0;

/// Adds to the start of a window the memory that the log provides: the wheel's angle for cogging, and the torque of
/// presliding friction.
fn with_memory<S: Scalar>(
    record: &Record,
    window: &Window,
    model: &Model,
    plant: &Plant<S>,
    start: State<S>,
) -> State<S> {
    let mut state = start;
    let first = window.samples.start;
    if model.find(|info| info.uses_wheel_angle).is_some() {
        state.wheel_angle_rad += S::constant(record.wheel_angle_before(first));
    }
    if first == 0 {
        return state;
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

/// Called at every sample of a window with its index, the sensors' reading and the state.
type EachSample<'a, S> = dyn FnMut(usize, &Reading<S>, &State<S>) + 'a;

/// Simulates a window for given parameters of the model and of the window, generic over the number type.
// `each` is not generic, so that the integrator is compiled once for each kind of number.
pub(super) fn run<S: Scalar>(
    record: &Record,
    window: &Window,
    model: &Model,
    (values, nuisances): (&[S], &[S]),
    smoothing: Smoothing,
    each: &mut EachSample<S>,
) {
    let start = start_of(&Nuisance::of(record), nuisances);
    let plant = plant_of(record, model, values, smoothing)
        .with_motion_before(start.motion_before)
        .with_early_steps(early_steps(record, window, nuisances));
    let (held, angle_zero) = (start.held_a, start.angle_zero);
    let start = with_memory(record, window, model, &plant, start.state);
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

/// Simulates a window without derivatives. `each` receives the sample's index, the model's reading and its state.
pub fn simulate(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    each: impl FnMut(usize, &Reading<f64>, &State<f64>),
) {
    simulate_smoothed(record, window, model, values, Smoothing::SIMULATION, each);
}

/// As [`simulate`], with another smoothing speed of dry friction.
pub fn simulate_smoothed(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    smoothing: Smoothing,
    mut each: impl FnMut(usize, &Reading<f64>, &State<f64>),
) {
    let numbers = (values, window.nuisances.as_slice());
    run(record, window, model, numbers, smoothing, &mut each);
}
