//! What a reader of a log did and saw, for the user.

use std::fmt;

use crate::channel::Channel;

/// A note about a log: no error, but something that the user should know.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Samples of a sensor were lost; they are NaN in the log.
    DropOuts {
        /// The sensor.
        channel: Channel,
        /// The times of the samples, s.
        times_s: Vec<f64>,
    },
    /// Lines that repeat the time of the line before were averaged with it.
    MergedRows {
        /// Number of removed lines.
        count: usize,
    },
    /// Jumps of the angle by a full turn were removed.
    AngleUnwrapped {
        /// Number of jumps.
        count: usize,
    },
    /// The angle was shifted by full turns, so that it lies around its equilibrium.
    AngleTurned {
        /// The added angle, rad.
        added_rad: f64,
    },
    /// A spin-up without a current column: the current was not recorded.
    CurrentNotRecorded,
    /// The wheel's speed comes from differences of its angle.
    SpeedFromAngle,
    /// A unit that bench.toml does not state was taken from the file's line of units.
    UnitFromFile {
        /// The channel.
        channel: Channel,
        /// The unit, as `units` in bench.toml writes it.
        unit: &'static str,
    },
    /// The current column is a command without unit (`units = { current = "1" }`).
    NormalisedCommand,
    /// A `sign` that is neither 1 nor −1 was used as a factor.
    SignIsAFactor {
        /// The channel.
        channel: Channel,
        /// The factor.
        factor: f64,
    },
    /// The log has more rows than are kept; its samples are averages.
    Averaged {
        /// Number of rows read.
        rows: usize,
        /// Number of rows in an average.
        block: usize,
    },
    /// A pause in the log, much longer than the usual time between two samples.
    Gap {
        /// Time of the last sample before it, s.
        from_s: f64,
        /// Time of the first sample after it, s.
        to_s: f64,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::DropOuts { channel, times_s } => {
                let n = times_s.len();
                let noun = if n == 1 { "drop-out" } else { "drop-outs" };
                write!(f, "{n} {noun} of {} left out, at t = ", channel.key())?;
                for (i, time) in times_s.iter().take(8).enumerate() {
                    let comma = if i == 0 { "" } else { ", " };
                    write!(f, "{comma}{}", rounded(*time))?;
                }
                if n > 8 {
                    write!(f, ", … {}", rounded(times_s[n - 1]))?;
                }
                write!(f, " s")
            }
            Note::MergedRows { count } => write!(
                f,
                "{count} {} the time of the line before, averaged with it",
                if *count == 1 {
                    "line repeats"
                } else {
                    "lines repeat"
                }
            ),
            Note::AngleUnwrapped { count } => {
                let jumps = if *count == 1 { "jump" } else { "jumps" };
                write!(f, "{count} {jumps} of the angle by a full turn taken out")
            }
            Note::AngleTurned { added_rad } => {
                write!(f, "{added_rad:.3} rad (full turns) added to the angle")
            }
            Note::CurrentNotRecorded => write!(
                f,
                "the current was not recorded; if it was held, constants = {{ current = … }} says at what"
            ),
            Note::UnitFromFile { channel, unit } => {
                write!(
                    f,
                    "{} is in {unit}, according to the file's own line of units",
                    channel.key()
                )
            }
            Note::SpeedFromAngle => write!(
                f,
                "the wheel's speed is not logged: it comes from differences of the wheel's angle"
            ),
            Note::NormalisedCommand => write!(
                f,
                "the current is a command without unit: torque_constant is torque per unit of \
                 command, and a drive that sets voltage, not current, shows up as wheel friction"
            ),
            Note::SignIsAFactor { channel, factor } => write!(
                f,
                "sign of {} is {factor}, neither 1 nor -1: used as a factor",
                channel.key()
            ),
            Note::Averaged { rows, block } => write!(
                f,
                "a log of {rows} rows is used as averages of {block}; of the current each keeps the integral"
            ),
            Note::Gap { from_s, to_s } => write!(
                f,
                "nothing was recorded from {} to {} s",
                rounded(*from_s),
                rounded(*to_s)
            ),
        }
    }
}

/// A time for a message, rounded to microseconds.
fn rounded(time_s: f64) -> f64 {
    (time_s * 1e6).round() / 1e6
}

/// The report on the reading of a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadReport {
    /// What bench.toml states about the numbers of the columns that are used.
    pub stated: Vec<Stated>,
    /// Samples in the file.
    pub rows_in_file: usize,
    /// Notes for the user.
    pub notes: Vec<Note>,
    /// The columns that were taken for SI because nothing states their unit.
    pub unstated: Vec<UnstatedUnit>,
}

/// What bench.toml states about the numbers of a column that is used. A cure that names one of these keys must know what
/// the key says already.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// The channel.
    pub channel: Channel,
    /// The unit under `units`.
    pub unit: Option<&'static str>,
    /// The factor to SI of the unit in which the column is read: that of `units`, else that of the file's own line of
    /// units, else 1.
    pub to_si: f64,
    /// The factor under `scale`.
    pub scale: Option<f64>,
    /// The factor under `sign`.
    pub sign: Option<f64>,
}

/// A column that is taken for SI: neither bench.toml nor the file's line of units nor its cells state a unit, and its
/// name is not the standard one.
#[derive(Clone, Debug, PartialEq)]
pub struct UnstatedUnit {
    /// The channel.
    pub channel: Channel,
    /// The column.
    pub column: String,
    /// The unit of this channel that the column's name ends with, as `units` in bench.toml writes it.
    pub name_says: Option<&'static str>,
}

impl LoadReport {
    /// Number of samples that dropped out, over all channels.
    pub fn drop_out_count(&self) -> usize {
        self.notes
            .iter()
            .map(|note| match note {
                Note::DropOuts { times_s, .. } => times_s.len(),
                _ => 0,
            })
            .sum()
    }
}
