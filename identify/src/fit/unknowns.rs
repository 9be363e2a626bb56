//! The unknowns of a fit: parameters that all windows share, and those of one window alone (its start, and
//! what nobody recorded); and which of them a record can say anything about.

use plant::{EffectId, Kind, Model, Role, Timing};

use crate::records::{Output, Record, RecordedCurrent};

/// An unknown that belongs to one window: its start, or the current that nobody wrote down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nuisance {
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
    /// The share of its motion that the model had before the log began ([`plant::Plant::with_motion_before`]): a sensor
    /// with a delay shows it in the log. Only the window with the first sample has it.
    PastMotion,
    /// Current that was commanded before the log began, A: nobody recorded it, and a delay or a lag carries
    /// it into the log. Only the window with the first sample has it.
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
        if matches!(record.kind, Kind::Balance | Kind::Driven) && measures(Output::WheelSpeed) {
            nuisances.push(Nuisance::WheelAngle);
        }
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

    /// Whether the motion of this model depends on the unknown.
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

    /// Standard deviation with which the unknown of a window that begins at the sample `first` is known
    /// beforehand, if it is.
    pub fn prior_std(self, record: &Record, first: usize) -> Option<f64> {
        match self {
            Nuisance::AngleZero => angle_quantum(record).map(|quantum| quantum / 12f64.sqrt()),
            Nuisance::WheelAngle => {
                let noise = record.channel(Output::WheelSpeed)?.noise_std;
                let span_s = record.time_s[first] - record.time_s[0];
                let steps = first.max(1) as f64;
                // At the first sample the angle is zero by definition.
                Some((noise * span_s / steps.sqrt()).max(LEAST_WHEEL_ANGLE_STD_RAD))
            }
            // Held still or moving on: both are usual.
            Nuisance::PastMotion => Some(1.0),
            Nuisance::PastCurrent => {
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
    /// Values of the local unknowns, in the order of [`Nuisance::of`].
    pub nuisances: Vec<f64>,
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

/// The free parameters that this record can say anything about, as indices into
/// [`Unknowns::free`].
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
