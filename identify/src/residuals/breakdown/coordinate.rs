//! The physical coordinates over which a residual is broken down, and their bins.

use plant::{GRAVITY_TORQUE, Kind, TOTAL_INERTIA};

use super::super::residual_torque::MeasuredMotion;
use crate::records::Record;

/// A coordinate over which a residual is broken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Coordinate {
    /// Body rate, rad/s, with its sign.
    Rate,
    /// Wheel speed, rad/s, with its sign.
    WheelSpeed,
    /// Body angle, rad.
    Angle,
    /// Motor current, A.
    Current,
    /// Wheel angle within one turn, rad, measured from where the log began.
    WheelAngle,
    /// Amplitude of the swing, rad: the angle at which the body would come to rest with its present energy.
    Amplitude,
    /// Time of the log, s.
    Time,
}

impl Coordinate {
    /// All coordinates. If several explain a torque equally well, the first of them is named: a torque that
    /// depends on speed also looks as if it depended on amplitude or time while a swing decays, but not the other way
    /// round.
    pub const ALL: [Coordinate; 7] = [
        Coordinate::Rate,
        Coordinate::WheelSpeed,
        Coordinate::Angle,
        Coordinate::Current,
        Coordinate::WheelAngle,
        Coordinate::Amplitude,
        Coordinate::Time,
    ];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Coordinate::Time => "time",
            Coordinate::Amplitude => "amplitude",
            Coordinate::Angle => "angle",
            Coordinate::Rate => "rate",
            Coordinate::WheelSpeed => "wheel_speed",
            Coordinate::WheelAngle => "wheel_angle",
            Coordinate::Current => "current",
        }
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Coordinate::Time => "s",
            Coordinate::Rate | Coordinate::WheelSpeed => "rad/s",
            Coordinate::Current => "A",
            Coordinate::Amplitude | Coordinate::Angle | Coordinate::WheelAngle => "rad",
        }
    }

    /// Whether a torque is the same function of this coordinate in every log.
    pub(super) fn is_common(self) -> bool {
        !matches!(self, Coordinate::Time | Coordinate::WheelAngle)
    }

    /// Whether the coordinate is itself a speed, so that its sign needs no separate coefficient.
    pub(super) fn is_speed(self) -> bool {
        matches!(self, Coordinate::Rate | Coordinate::WheelSpeed)
    }
}

/// Largest number of bins for one coordinate.
const MOST_BINS: usize = 32;
/// Smallest number of values in a bin.
const FEWEST_IN_BIN: usize = 20;
/// Number of bins for one turn of the wheel; they resolve cogging of up to 20 periods per turn.
const TURN_BINS: usize = 60;

/// The value of every coordinate in the middle of every interval of a record; empty if the record does not
/// contain it.
pub(super) fn coordinates(
    record: &Record,
    motion: &MeasuredMotion,
    values: &[f64],
) -> Vec<Vec<f64>> {
    let swings = matches!(record.kind, Kind::FreeSwing | Kind::Driven);
    let moves_body = record.kind != Kind::SpinUp;
    let moves_wheel = record.kind != Kind::FreeSwing && motion.wheel_speed_measured;
    let has_current = record.kind != Kind::FreeSwing && !record.current_a.is_empty();
    let stiffness = values[GRAVITY_TORQUE] / values[TOTAL_INERTIA];
    Coordinate::ALL
        .iter()
        .map(|coordinate| {
            let states = motion.state.iter();
            match coordinate {
                Coordinate::Rate if moves_body => states.map(|state| state.rate_rad_s).collect(),
                Coordinate::Angle if moves_body => states.map(|state| state.angle_rad).collect(),
                Coordinate::Amplitude if swings => states
                    .map(|state| {
                        // 1 − cos A = 1 − cos α + Θ α̇²/(2 G)
                        let half_height = (0.5 * state.angle_rad).sin().powi(2)
                            + 0.25 * state.rate_rad_s.powi(2) / stiffness;
                        2.0 * half_height.min(1.0).sqrt().asin()
                    })
                    .collect(),
                Coordinate::WheelSpeed if moves_wheel => {
                    states.map(|state| state.wheel_speed_rad_s).collect()
                }
                Coordinate::WheelAngle if moves_wheel => states
                    .map(|state| state.wheel_angle_rad.rem_euclid(std::f64::consts::TAU))
                    .collect(),
                Coordinate::Current if has_current => states.map(|state| state.current_a).collect(),
                Coordinate::Time => motion.time_s.clone(),
                _ => vec![],
            }
        })
        .collect()
}

/// Edges of bins with equal counts. One edge is at zero speed. A turn of the wheel is divided evenly instead.
pub(super) fn edges(
    coordinate: Coordinate,
    mut values: Vec<f64>,
    count: usize,
) -> Option<Vec<f64>> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let (first, last) = (*values.first()?, *values.last()?);
    if last - first <= 1e-9 * first.abs().max(last.abs()).max(1e-9) {
        return None;
    }
    if coordinate == Coordinate::WheelAngle {
        let turn = std::f64::consts::TAU;
        return Some(
            (0..=TURN_BINS)
                .map(|k| turn * k as f64 / TURN_BINS as f64)
                .collect(),
        );
    }
    let bins = (count / FEWEST_IN_BIN).clamp(2, MOST_BINS);
    let mut edges: Vec<f64> = (0..=bins)
        .map(|k| values[(k * (values.len() - 1)) / bins])
        .collect();
    if coordinate.is_speed() && first < 0.0 && last > 0.0 {
        let nearest =
            (1..edges.len() - 1).min_by(|&a, &b| edges[a].abs().total_cmp(&edges[b].abs()));
        if let Some(nearest) = nearest {
            edges[nearest] = 0.0;
        }
    }
    edges.dedup();
    (edges.len() > 2).then_some(edges)
}

pub(super) fn bin_of(edges: &[f64], value: f64) -> Option<usize> {
    value.is_finite().then(|| {
        edges
            .partition_point(|edge| *edge <= value)
            .clamp(1, edges.len() - 1)
            - 1
    })
}
