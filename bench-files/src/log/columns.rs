//! From the columns of a file to the channels of a log.

use super::samples::Log;
use crate::channel::Channel;

/// The column of a channel, and its conversion to SI: scale · column + offset.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColumnUse {
    pub channel: Channel,
    pub name: String,
    /// Factor of unit and sign together.
    pub scale: f64,
    /// The factor of the unit that bench.toml or the file's line of units states, if one does.
    pub stated_unit: Option<f64>,
    /// Offset in SI units.
    pub offset: f64,
    /// Whether this kind of experiment holds the channel still. It is then read into the samples beside the log, and a cell
    /// that is not a number is NaN there.
    pub is_beside: bool,
}

impl ColumnUse {
    /// The factor for numbers that have this unit in their own cell; `None` if the channel cannot have it, or another
    /// one is stated.
    pub fn scale_in(&self, unit: &str) -> Option<f64> {
        let units = self.channel.units();
        let (_, factor) = units.iter().find(|(name, _)| *name == unit)?;
        let stated = self.stated_unit.unwrap_or(*factor);
        (stated == *factor).then(|| self.scale / self.stated_unit.unwrap_or(1.0) * factor)
    }
}

/// Assigns the columns to channels: the first log has the channels that the kind of experiment uses, the second those
/// that the experiment holds still. With `time_is_ahead`, the time comes before the columns.
pub(crate) fn by_channel(
    series: Vec<Vec<f64>>,
    uses: &[ColumnUse],
    time_is_ahead: bool,
) -> (Log, Log) {
    let mut log = Log::default();
    let mut beside = Log::default();
    let mut series = series.into_iter();
    if time_is_ahead {
        log.time_s = series.next().unwrap_or_default();
    }
    for (column, samples) in uses.iter().zip(series) {
        let log = if column.is_beside {
            &mut beside
        } else {
            &mut log
        };
        log.set(column.channel, samples);
    }
    (log, beside)
}
