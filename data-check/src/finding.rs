//! The result of a check: findings.

use serde::{Deserialize, Serialize};

/// The kind of finding, by the name that `accept` and the JSON use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FindingId {
    /// The rate is not the derivative of the angle.
    RateFactor,
    /// Two channels have the same samples.
    SameColumn,
    /// The angle's unit contradicts the motion of a pendulum.
    AngleFactor,
    /// The angle is not counted from hanging.
    AngleZero,
    /// Nothing states the unit of a column, or its name states another one.
    UnitUnstated,
    /// The unit of the time contradicts the period of a pendulum, or the sample time of the controller.
    TimeFactor,
    /// Time stamps vary, leave gaps or repeat.
    TimeStamps,
    /// The wheel speeds up against its current.
    CurrentSign,
    /// The current's unit contradicts what a motor can do.
    CurrentFactor,
    /// The wheel's speed contradicts other logs, the wheel's inertia or what a motor can do.
    WheelSpeedFactor,
    /// Wheel and body do not exchange momentum: one of them has the wrong sign.
    WheelSign,
    /// The wheel turns although it is locked.
    WheelTurns,
    /// The body moves although it is clamped.
    BodyMoves,
    /// The body is held still before its release.
    HeldStart,
    /// The swing gains energy: a hand moves the body.
    Hand,
    /// Two experiments have the same samples.
    SameData,
    /// A channel ends at a limit.
    Clipped,
    /// A channel stands still while the motion goes on.
    Frozen,
    /// A channel jumps farther than it can move: two logs in one file.
    Jump,
    /// A channel starts again from the other end of its range.
    Wrapped,
    /// A channel has only a few levels.
    Quantised,
    /// A channel is delayed against another.
    LateChannel,
    /// A channel repeats old samples.
    Stale,
    /// The logged current is not that of the controller.
    Gains,
    /// The controller gave several commands per row of a balance log.
    SparseCommands,
    /// Masses and lengths are given without the values that turn them into a torque.
    KnownMissing,
    /// A value of `[known]` is not possible for such a bench.
    KnownRange,
    /// `accept` contains a name that is not a finding.
    UnknownFinding,
}

impl FindingId {
    /// All findings.
    pub const ALL: [FindingId; 28] = [
        FindingId::RateFactor,
        FindingId::SameColumn,
        FindingId::AngleFactor,
        FindingId::AngleZero,
        FindingId::UnitUnstated,
        FindingId::TimeFactor,
        FindingId::TimeStamps,
        FindingId::CurrentSign,
        FindingId::CurrentFactor,
        FindingId::WheelSpeedFactor,
        FindingId::WheelSign,
        FindingId::WheelTurns,
        FindingId::BodyMoves,
        FindingId::HeldStart,
        FindingId::Hand,
        FindingId::SameData,
        FindingId::Clipped,
        FindingId::Frozen,
        FindingId::Jump,
        FindingId::Wrapped,
        FindingId::Quantised,
        FindingId::LateChannel,
        FindingId::Stale,
        FindingId::Gains,
        FindingId::SparseCommands,
        FindingId::KnownMissing,
        FindingId::KnownRange,
        FindingId::UnknownFinding,
    ];

    /// Its name in `accept` and in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            FindingId::RateFactor => "rate-factor",
            FindingId::SameColumn => "same-column",
            FindingId::AngleFactor => "angle-factor",
            FindingId::AngleZero => "angle-zero",
            FindingId::UnitUnstated => "unit-unstated",
            FindingId::TimeFactor => "time-factor",
            FindingId::TimeStamps => "time-stamps",
            FindingId::CurrentSign => "current-sign",
            FindingId::CurrentFactor => "current-factor",
            FindingId::WheelSpeedFactor => "wheel-speed-factor",
            FindingId::WheelSign => "wheel-sign",
            FindingId::WheelTurns => "wheel-turns",
            FindingId::BodyMoves => "body-moves",
            FindingId::HeldStart => identify::HELD_START,
            FindingId::Hand => "hand",
            FindingId::SameData => "same-data",
            FindingId::Clipped => "clipped",
            FindingId::Frozen => "frozen",
            FindingId::Jump => "jump",
            FindingId::Wrapped => "wrapped",
            FindingId::Quantised => "quantised",
            FindingId::LateChannel => "late-channel",
            FindingId::Stale => "stale",
            FindingId::Gains => "gains",
            FindingId::SparseCommands => identify::SPARSE_COMMANDS,
            FindingId::KnownMissing => "known-missing",
            FindingId::KnownRange => "known-range",
            FindingId::UnknownFinding => "unknown-finding",
        }
    }
    /// The meaning of the finding and its remedy, in one sentence. The sentence of a [`Finding`] adds the numbers.
    pub fn meaning(self) -> &'static str {
        match self {
            FindingId::RateFactor => {
                "The rate is not the derivative of the angle. A factor of -1 shows a wrong sign, 57.3 degrees, 1000 milliseconds; state `units` or `sign` of one of the two."
            }
            FindingId::SameColumn => {
                "Two channels have the same samples: both are mapped to one column; mend `columns`."
            }
            FindingId::AngleFactor => {
                "The angle's unit contradicts the motion of a pendulum, whose period grows with its amplitude; state `units`."
            }
            FindingId::AngleZero => {
                "Gravity is not zero at the angle 0: the angle is counted from upright or from elsewhere; state `offset`."
            }
            FindingId::UnitUnstated => {
                "Nothing states the unit of a column, and the log cannot tell it; or the column's name says another unit than the one in which it is read. State `units`."
            }
            FindingId::TimeFactor => {
                "The time's unit contradicts the period of the pendulum or the controller's sample time; state `units`."
            }
            FindingId::TimeStamps => {
                "Time stamps vary, leave gaps or repeat: log the time of the measurement, or state `time_step`. Or commands change between two rows: the fit takes their instants as unknown."
            }
            FindingId::CurrentSign => {
                "The wheel speeds up against its current: `sign = { current = -1 }`, or the wheel's."
            }
            FindingId::CurrentFactor => {
                "The current's unit contradicts what a motor can do, mostly by 1000: `units = { current = \"mA\" }`."
            }
            FindingId::WheelSpeedFactor => {
                "The wheel's speed contradicts other logs, its inertia or what a motor can do, mostly by 9.55: `units = { wheel_speed = \"rpm\" }`."
            }
            FindingId::WheelSign => {
                "Wheel and body do not exchange momentum: one of them has the wrong `sign`."
            }
            FindingId::WheelTurns => {
                "The wheel turns in a swing in which it should be locked, by its sensor or by the period of the swing: the experiment is `driven`, with `constants = { current = 0.0 }`."
            }
            FindingId::BodyMoves => {
                "The body moves in a spin-up in which it should be clamped: the experiment is `driven`."
            }
            FindingId::HeldStart => {
                "The body is held still before its release. A hold of less than half a period is left out of every fit; `from` cuts a longer one off."
            }
            FindingId::Hand => {
                "The swing gains energy, or a wheel without a current gains speed: a hand or a motor is on it; cut it off with `from` and `until`."
            }
            FindingId::SameData => {
                "Two experiments have the same samples; one of them names the wrong `file`."
            }
            FindingId::Clipped => {
                "A channel ends at a limit: the sensor was set to too small a range; repeat, or cut with `from` and `until`."
            }
            FindingId::Frozen => {
                "A channel stands still while the motion goes on: the sensor or its bus had stopped."
            }
            FindingId::Jump => {
                "A channel jumps farther than it can move in one sample: two logs stand in one file, a sensor lost its count, or samples were lost; keep one part with `from` and `until`."
            }
            FindingId::Wrapped => {
                "A channel jumps from one end of its range to the other, as an angle does at 360 degrees. Jumps by a full turn are taken out when the file is read: state the unit in which a turn is one, or map the wheel's angle as such."
            }
            FindingId::Quantised => {
                "A channel has few levels: its steps are larger than its noise."
            }
            FindingId::LateChannel => {
                "A channel comes later than the others, by a filter or a delay on its way."
            }
            FindingId::Stale => "A channel repeats old samples: its sensor is slower than the log.",
            FindingId::Gains => {
                "The logged current is not that of the controller in `[controller]`: its gains have another unit or sign, or the log another current."
            }
            FindingId::SparseCommands => {
                "The controller gave several commands per row of a balance log, and those between the rows are unknown: the log is left out of every fit. Log every command, or the measured current."
            }
            FindingId::KnownMissing => {
                "Masses and lengths are given, but a value is missing that turns them into a torque, mostly `gravity`; state it."
            }
            FindingId::KnownRange => {
                "A value of `[known]` is impossible for such a bench; mostly its unit is wrong."
            }
            FindingId::UnknownFinding => "`accept` names something that is no finding.",
        }
    }
}

/// The consequence of a finding for the commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The model would be wrong, and the data leave no doubt: the commands compute nothing from them.
    Refuse,
    /// A warning; the commands go on.
    Warn,
}

/// One fault of the data of a bench.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The experiment; `None` if the finding concerns the whole bench.
    pub experiment: Option<String>,
    /// The channel; `None` if the finding concerns all channels.
    pub channel: Option<String>,
    /// The kind of finding.
    pub finding: FindingId,
    /// The factor by which the samples are too large, if there is one: 57.3 for degrees that are read as
    /// radians, −1 for a wrong sign.
    pub factor: Option<f64>,
    /// Whether the commands go on.
    pub severity: Severity,
    /// The finding in one sentence.
    pub sentence: String,
    /// The remedy; if possible, the text for bench.toml.
    pub fix: String,
}

impl Finding {
    /// A warning for the whole bench without channel, factor or remedy; the `with_` functions add them.
    pub(crate) fn warning(finding: FindingId, sentence: impl Into<String>) -> Finding {
        Finding {
            experiment: None,
            channel: None,
            finding,
            factor: None,
            severity: Severity::Warn,
            sentence: sentence.into(),
            fix: String::new(),
        }
    }

    /// As [`Finding::warning`], but the commands do not go on.
    pub(crate) fn refusal(finding: FindingId, sentence: impl Into<String>) -> Finding {
        Finding {
            severity: Severity::Refuse,
            ..Finding::warning(finding, sentence)
        }
    }

    pub(crate) fn in_experiment(self, name: &str) -> Finding {
        Finding {
            experiment: Some(name.to_owned()),
            ..self
        }
    }

    pub(crate) fn with_channel(self, channel: &str) -> Finding {
        Finding {
            channel: Some(channel.to_owned()),
            ..self
        }
    }

    pub(crate) fn with_factor(self, factor: f64) -> Finding {
        Finding {
            factor: Some(factor),
            ..self
        }
    }

    pub(crate) fn with_fix(self, fix: impl Into<String>) -> Finding {
        Finding {
            fix: fix.into(),
            ..self
        }
    }

    /// "experiment/channel", "experiment" or nothing.
    pub fn place(&self) -> String {
        match (&self.experiment, &self.channel) {
            (Some(experiment), Some(channel)) => format!("{experiment}/{channel}"),
            (Some(experiment), None) => experiment.clone(),
            (None, Some(channel)) => channel.clone(),
            (None, None) => String::new(),
        }
    }
}
