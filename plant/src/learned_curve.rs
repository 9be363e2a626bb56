//! A learned curve over one coordinate of the motion, as plain data for the description of its effect.

use nalgebra::DMatrix;

use crate::spline::Spline;

/// The coordinate over which a torque was learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LearnedCoordinate {
    /// Body angle, rad; the torque acts on the body.
    Angle,
    /// Body rate, rad/s; the torque acts on the body.
    Rate,
    /// Wheel speed, rad/s; the torque acts on the wheel.
    WheelSpeed,
    /// Wheel angle within one turn, rad; the torque acts on the wheel.
    WheelAngle,
}

/// Most knots of a learned curve.
pub const MOST_KNOTS: usize = 24;

/// Fewest knots of a learned curve.
pub const FEWEST_KNOTS: usize = 4;

impl LearnedCoordinate {
    /// All coordinates.
    pub const ALL: [LearnedCoordinate; 4] = [
        LearnedCoordinate::Angle,
        LearnedCoordinate::Rate,
        LearnedCoordinate::WheelSpeed,
        LearnedCoordinate::WheelAngle,
    ];

    /// The name on the command line and in `[learned.NAME]`.
    pub fn name(self) -> &'static str {
        match self {
            LearnedCoordinate::Angle => "angle",
            LearnedCoordinate::Rate => "rate",
            LearnedCoordinate::WheelSpeed => "wheel_speed",
            LearnedCoordinate::WheelAngle => "wheel_angle",
        }
    }

    /// The coordinate of this name.
    pub fn from_name(name: &str) -> Option<LearnedCoordinate> {
        LearnedCoordinate::ALL
            .into_iter()
            .find(|one| one.name() == name)
    }

    /// The name of the effect in lists of effects.
    pub fn effect_name(self) -> &'static str {
        match self {
            LearnedCoordinate::Angle => "learned-angle",
            LearnedCoordinate::Rate => "learned-rate",
            LearnedCoordinate::WheelSpeed => "learned-wheel-speed",
            LearnedCoordinate::WheelAngle => "learned-wheel-angle",
        }
    }

    /// The coordinate whose effect has this name.
    pub fn from_effect_name(name: &str) -> Option<LearnedCoordinate> {
        LearnedCoordinate::ALL
            .into_iter()
            .find(|one| one.effect_name() == name)
    }

    /// SI unit of the coordinate.
    pub fn unit(self) -> &'static str {
        match self {
            LearnedCoordinate::Angle | LearnedCoordinate::WheelAngle => "rad",
            LearnedCoordinate::Rate | LearnedCoordinate::WheelSpeed => "rad/s",
        }
    }

    /// In words: "the body's angle".
    pub fn words(self) -> &'static str {
        match self {
            LearnedCoordinate::Angle => "the body's angle",
            LearnedCoordinate::Rate => "the body's rate",
            LearnedCoordinate::WheelSpeed => "the wheel's speed",
            LearnedCoordinate::WheelAngle => "the wheel's angle",
        }
    }

    /// Length after which the torque repeats.
    pub fn period(self) -> Option<f64> {
        (self == LearnedCoordinate::WheelAngle).then_some(std::f64::consts::TAU)
    }
}

/// The shape of a learned curve, and the smoothness that is assumed of it before the logs are read.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedCurve {
    /// The coordinate.
    pub coordinate: LearnedCoordinate,
    /// The spline whose values are the parameters.
    pub spline: Spline,
    /// Quadratic form of the parameters, in 1/(N m)², that a fit adds to its cost. It keeps the curve smooth and apart
    /// from the model's own terms. `None` for a curve that is only simulated.
    pub penalty: Option<DMatrix<f64>>,
}

impl LearnedCurve {
    /// Whether the logs have shown the torque at this value of the coordinate.
    pub fn has_seen(&self, value: f64) -> bool {
        let knots = self.spline.knots();
        self.coordinate.period().is_some() || (knots[0] <= value && value <= knots[knots.len() - 1])
    }
}
