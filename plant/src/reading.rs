//! The readings of the sensors.

/// The readings of the sensors at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<S> {
    /// Measured body angle, rad.
    pub angle_rad: S,
    /// Measured body rate, rad/s.
    pub rate_rad_s: S,
    /// Measured wheel speed, rad/s.
    pub wheel_speed_rad_s: S,
}

/// A measured output of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Output {
    /// Body angle, rad.
    Angle,
    /// Body rate, rad/s.
    Rate,
    /// Wheel speed, rad/s.
    WheelSpeed,
}

impl Output {
    /// All outputs.
    pub const ALL: [Output; 3] = [Output::Angle, Output::Rate, Output::WheelSpeed];

    /// The channel, as in "experiment/channel".
    pub fn name(self) -> &'static str {
        match self {
            Output::Angle => "angle",
            Output::Rate => "rate",
            Output::WheelSpeed => "wheel_speed",
        }
    }

    /// SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Output::Angle => "rad",
            Output::Rate | Output::WheelSpeed => "rad/s",
        }
    }

    /// This output's part of a reading, to be changed.
    #[inline(always)]
    pub fn part_of<S>(self, reading: &mut Reading<S>) -> &mut S {
        match self {
            Output::Angle => &mut reading.angle_rad,
            Output::Rate => &mut reading.rate_rad_s,
            Output::WheelSpeed => &mut reading.wheel_speed_rad_s,
        }
    }

    /// The value of this output in a reading.
    #[inline(always)]
    pub fn of<S: Copy>(self, reading: &Reading<S>) -> S {
        match self {
            Output::Angle => reading.angle_rad,
            Output::Rate => reading.rate_rad_s,
            Output::WheelSpeed => reading.wheel_speed_rad_s,
        }
    }
}
