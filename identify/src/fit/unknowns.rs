//! The unknowns of a fit: the parameters that all windows share, and the nuisance parameters of one window (its start,
//! and quantities that nobody recorded); and which of them a record depends on.

use plant::{EffectId, Kind, Model, Role, Timing};

use crate::records::{Output, Record, RecordedCurrent};

/// A nuisance parameter, which belongs to one window: its start, or a quantity that nobody recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nuisance {
    /// Body angle at the start, rad.
    Angle,
    /// Body rate at the start, rad/s.
    Rate,
    /// Wheel speed at the start, rad/s.
    WheelSpeed,
    /// Constant current during the whole window, A, if the current was not recorded.
    Current,
    /// Zero of a quantised angle, rad. Whether the sensor rounds or truncates is unknown, so the zero of a channel with
    /// step q is known to ±q/2 only: a nuisance parameter with prior standard deviation q/√12.
    AngleZero,
    /// Wheel angle at the start, relative to the measured one, or else to the integral of the measured wheel speed, rad. The
    /// integrated noise is a random walk, so a window in the middle of such a log does not know the wheel's angle exactly.
    WheelAngle,
    /// The instant at which the command made the step with this place among [`Record::unknown_steps`], as a quantile of the
    /// standard normal distribution: 0 in the middle of the interval between its sample and the one before, positive
    /// earlier.
    EarlyStep(usize),
    /// The share of its motion that the model had before the log began ([`plant::Plant::with_motion_before`]): a sensor
    /// with a delay shows it in the log. Only the window with the first sample has it.
    PastMotion,
    /// Current commanded before the log began, A. Nobody recorded it, but a delay or a lag carries it into the log. Only
    /// the window with the first sample has this nuisance parameter.
    PastCurrent,
}

impl Nuisance {
    /// The unknowns of every window of this record, as its kind and channels allow; the last ones, those of the
    /// time before the log ([`Nuisance::is_past`]), are left out where the window does not begin with the log.
    pub fn of(record: &Record) -> Vec<Nuisance> {
        let measures = |output| record.channel(output).is_some();
        let mut nuisances = vec![];
        if record.kind != Kind::SpinUp && (measures(Output::Angle) || measures(Output::Rate)) {
            nuisances.extend([Nuisance::Angle, Nuisance::Rate]);
        }
        if record.kind != Kind::FreeSwing && measures(Output::WheelSpeed) {
            nuisances.push(Nuisance::WheelSpeed);
        }
        if matches!(record.current, RecordedCurrent::Unknown) {
            nuisances.push(Nuisance::Current);
        }
        if angle_quantum(record).is_some() {
            nuisances.push(Nuisance::AngleZero);
        }
        // A spin-up begins where its angle is zero, and keeps to it; not where its teeth tell it window by window.
        let loses_turns = match record.kind {
            Kind::FreeSwing => false,
            Kind::SpinUp => record.teeth.is_some(),
            Kind::Balance | Kind::Driven => true,
        };
        if loses_turns && measures(Output::WheelSpeed) {
            nuisances.push(Nuisance::WheelAngle);
        }
        nuisances.extend((0..record.unknown_steps.len()).map(Nuisance::EarlyStep));
        nuisances.push(Nuisance::PastMotion);
        let is_commanded = matches!(record.current, RecordedCurrent::Known(_));
        if record.kind != Kind::FreeSwing && is_commanded && !record.current_is_measured {
            nuisances.push(Nuisance::PastCurrent);
        }
        nuisances
    }

    /// Whether it is of the time before the log.
    pub fn is_past(self) -> bool {
        matches!(self, Nuisance::PastMotion | Nuisance::PastCurrent)
    }

    /// Whether the motion of this model depends on the nuisance parameter.
    pub fn acts_on(self, model: &Model) -> bool {
        match self {
            Nuisance::WheelAngle => model.find(|info| info.uses_wheel_angle).is_some(),
            Nuisance::PastCurrent => model.find(|info| info.timing.is_some()).is_some(),
            Nuisance::PastMotion => model
                .find(|info| info.sensor_timing == Some(Timing::Delay))
                .is_some(),
            _ => true,
        }
    }

    /// Whether it can show in a window: a step of the command that the window does not contain cannot.
    pub(crate) fn lies_in(self, record: &Record, window: &Window) -> bool {
        let Nuisance::EarlyStep(at) = self else {
            return true;
        };
        let step = &record.unknown_steps[at];
        let times = &record.time_s[window.samples.clone()];
        let ends = times.first().zip(times.last());
        ends.is_some_and(|(first, last)| *first < step.sample_s && step.sample_s <= *last)
    }

    /// Largest magnitude that a fit tries: a quantile of a thousandth, beyond which an instant hardly moves and a step of the
    /// fit could not bring it back.
    pub(super) fn most(self) -> f64 {
        match self {
            Nuisance::EarlyStep(_) => 4.0,
            _ => f64::INFINITY,
        }
    }

    /// Prior standard deviation of this nuisance parameter, in its own unit, for a window that begins at the sample
    /// `first`; `None` if it has no prior.
    pub fn prior_std(self, record: &Record, first: usize) -> Option<f64> {
        match self {
            Nuisance::AngleZero => angle_quantum(record).map(|quantum| quantum / 12f64.sqrt()),
            Nuisance::WheelAngle => {
                if let Some(noise_rad) = record.wheel_angle_noise_rad() {
                    return Some(noise_rad.max(LEAST_WHEEL_ANGLE_STD_RAD));
                }
                let noise = record.channel(Output::WheelSpeed)?.noise_std;
                let span_s = record.time_s[first] - record.time_s[0];
                let steps = first.max(1) as f64;
                // At the first sample the angle is zero by definition.
                Some((noise * span_s / steps.sqrt()).max(LEAST_WHEEL_ANGLE_STD_RAD))
            }
            Nuisance::EarlyStep(_) => Some(1.0),
            // Held still or moving on: both are usual.
            Nuisance::PastMotion => Some(1.0),
            Nuisance::PastCurrent => {
                // The past command is assumed to be like the recorded commands.
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

/// Width of a prior for "no current", A.
const LEAST_CURRENT_A: f64 = 1e-6;
/// Width of a prior for a wheel angle that is known exactly, rad.
const LEAST_WHEEL_ANGLE_STD_RAD: f64 = 1e-4;

/// The quantisation step of the angle, in rad, for a log that is simulated in one window; `None` otherwise.
fn angle_quantum(record: &Record) -> Option<f64> {
    match record.kind {
        Kind::FreeSwing | Kind::Driven => record.channel(Output::Angle)?.quantum,
        Kind::SpinUp | Kind::Balance => None,
    }
}

/// A stretch of a log that is simulated in one piece with its own start.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The indices of its samples.
    pub samples: std::ops::Range<usize>,
    /// Values of the nuisance parameters, in the order of [`Nuisance::of`].
    pub nuisances: Vec<f64>,
}

/// The free parameters of a fit. A parameter that is described as logarithmic is adjusted through its logarithm.
#[derive(Clone, Debug)]
pub struct Unknowns {
    /// Positions in the parameter vector, increasing.
    pub free: Vec<usize>,
    /// For each free parameter: whether the fit adjusts ln(value).
    pub logarithmic: Vec<bool>,
    /// For each free parameter: its range, in its own unit.
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

    /// The derivative of the parameter with respect to the coordinate that the fit adjusts: 1, or the value itself.
    pub fn slope(&self, unknown: usize, value: f64) -> f64 {
        if self.logarithmic[unknown] {
            value
        } else {
            1.0
        }
    }
}

/// Whether an effect can show in an experiment of this kind: body terms, and sensors of the body, do not while the
/// body is clamped, nor wheel terms while the wheel is locked.
pub fn acts(effect: EffectId, kind: Kind) -> bool {
    if is_of_wheel(effect) {
        kind != Kind::FreeSwing
    } else {
        kind != Kind::SpinUp
    }
}

/// Whether an effect acts on the wheel, its motor or its sensor; else it is of the body.
pub fn is_of_wheel(effect: EffectId) -> bool {
    let info = effect.info();
    match info.role {
        Role::Body => false,
        Role::Wheel | Role::Motor => true,
        Role::Sensor => info.senses == Some(Output::WheelSpeed),
    }
}

/// The free parameters on which the predictions for this record depend, as indices into [`Unknowns::free`].
pub fn relevant(record: &Record, model: &Model, unknowns: &Unknowns) -> Vec<usize> {
    let shows = |position: usize| match position {
        plant::TOTAL_INERTIA | plant::GRAVITY_TORQUE => record.kind != Kind::SpinUp,
        plant::WHEEL_INERTIA | plant::TORQUE_CONSTANT => record.kind != Kind::FreeSwing,
        _ => model.range_at(position).is_some_and(|(effect, own)| {
            acts(effect, record.kind) && effect.is_of_log(position - own.start, &record.name)
        }),
    };
    (0..unknowns.free.len())
        .filter(|&unknown| shows(unknowns.free[unknown]))
        .collect()
}

/// Whether two models with their parameters move equally in experiments of this kind: the same effects act there,
/// with the same values.
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
