//! The channels that a log can have: their column names and units.

use std::f64::consts::{PI, TAU};

/// A channel of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Time of the sample, s.
    Time,
    /// Body angle, rad.
    Angle,
    /// Body rate, rad/s.
    Rate,
    /// Wheel speed relative to the body, rad/s.
    WheelSpeed,
    /// Wheel angle relative to the body, rad.
    WheelAngle,
    /// Motor current, A.
    Current,
}

/// The name of a unit, and the factor that converts a number from it to SI.
type Unit = (&'static str, f64);

const SPEED_UNITS: &[Unit] = &[
    ("rad/s", 1.0),
    ("mrad/s", 1e-3),
    ("deg/s", PI / 180.0),
    ("rev/s", TAU),
    ("rpm", TAU / 60.0),
];

/// The unit of a command that is a dimensionless number.
pub(crate) const NORMALISED: &str = "1";

impl Channel {
    /// All channels, time first.
    pub const ALL: [Channel; 6] = [
        Channel::Time,
        Channel::Angle,
        Channel::Rate,
        Channel::WheelSpeed,
        Channel::WheelAngle,
        Channel::Current,
    ];

    /// The key in `columns`, `units`, `scale`, `sign`, `offset` and `constants`; also the channel in
    /// "experiment/channel" in reports.
    pub fn key(self) -> &'static str {
        match self {
            Channel::Time => "time",
            Channel::Angle => "angle",
            Channel::Rate => "rate",
            Channel::WheelSpeed => "wheel_speed",
            Channel::WheelAngle => "wheel_angle",
            Channel::Current => "current",
        }
    }

    /// The channel with this key.
    pub fn from_key(key: &str) -> Option<Channel> {
        Channel::ALL
            .into_iter()
            .find(|channel| channel.key() == key)
    }

    /// The column name that needs no mapping.
    pub fn standard_name(self) -> &'static str {
        match self {
            Channel::Time => "time_s",
            Channel::Angle => "angle_rad",
            Channel::Rate => "rate_rad_s",
            Channel::WheelSpeed => "wheel_speed_rad_s",
            Channel::WheelAngle => "wheel_angle_rad",
            Channel::Current => "current_A",
        }
    }

    /// The SI unit, as `units` in bench.toml writes it.
    pub fn si_unit(self) -> &'static str {
        self.units()[0].0
    }

    /// The name of the unit whose factor to SI is `scale`, within a hundredth; `None` if `units` knows no such unit.
    pub fn unit_with(self, scale: f64) -> Option<&'static str> {
        let mut units = self.units().iter();
        let found = units.find(|(_, known)| (known / scale - 1.0).abs() < 0.01);
        found.map(|(name, _)| *name)
    }

    /// The units that `units` accepts for this channel, SI first.
    pub(crate) fn units(self) -> &'static [Unit] {
        match self {
            Channel::Time => &[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("ns", 1e-9)],
            Channel::Angle | Channel::WheelAngle => &[
                ("rad", 1.0),
                ("mrad", 1e-3),
                ("deg", PI / 180.0),
                ("rev", TAU),
            ],
            Channel::Rate | Channel::WheelSpeed => SPEED_UNITS,
            // "1": a command without unit, such as a share of the largest duty.
            Channel::Current => &[("A", 1.0), ("mA", 1e-3), (NORMALISED, 1.0)],
        }
    }

    /// Parts of names under which this channel's column is often found, the best first. They are only used to
    /// propose a mapping in an error message, never to choose a column.
    fn usual_names(self) -> &'static [&'static str] {
        match self {
            Channel::Time => &["time", "t_", "millis", "stamp", "t"],
            Channel::Angle => &[
                "angle", "pend", "theta", "alpha", "pitch", "deg", "pos", "rad",
            ],
            Channel::Rate => &["rate", "gyro", "dtheta", "dalpha", "vel", "deg_s", "rad_s"],
            Channel::WheelSpeed => &["wheel", "rpm", "motor", "omega", "phi", "speed"],
            Channel::WheelAngle => &["wheel_angle", "wheel_pos", "encoder", "phi"],
            Channel::Current => &["current", "amp", "curr", "i_", "u", "i"],
        }
    }

    /// The column that probably belongs to this channel; columns in `used` are left out.
    pub(crate) fn likely_column<'a>(self, columns: &'a [String], used: &[&str]) -> Option<&'a str> {
        let free = || columns.iter().filter(|name| !used.contains(&name.as_str()));
        self.usual_names().iter().find_map(|part| {
            free()
                .find(|name| {
                    let name = name.to_lowercase();
                    if part.len() <= 2 {
                        name == *part || (part.ends_with('_') && name.starts_with(part))
                    } else {
                        name.contains(part)
                    }
                })
                .map(String::as_str)
        })
    }
}
