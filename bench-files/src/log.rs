//! Logs: CSV with a header line, one sample per line, increasing times.

use std::fmt;

use crate::channel::Channel;
use crate::csv_table::OpenTable;
use crate::drop_out::drop_outs;
use crate::error::{Error, Problem, shortened};
use crate::long_log::{CHUNK_ROWS, LongLog};

/// Smallest number of samples of a log in its window: the test for drop-outs needs two samples on
/// either side.
pub const MIN_SAMPLES: usize = 5;
/// The samples of one experiment in SI units. All vectors have the length of `time_s`; a lost sample
/// is NaN in its channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time of each sample, s, strictly increasing; the zero is that of the file.
    pub time_s: Vec<f64>,
    /// Body angle α, rad, 0 hanging, as measured.
    pub angle_rad: Option<Vec<f64>>,
    /// Body rate α̇, rad/s, as measured.
    pub rate_rad_s: Option<Vec<f64>>,
    /// Wheel speed φ̇ relative to the body, rad/s, as measured.
    pub wheel_speed_rad_s: Option<Vec<f64>>,
    /// Wheel angle φ relative to the body, rad, unwrapped, as measured.
    pub wheel_angle_rad: Option<Vec<f64>>,
    /// Motor current, A: the command, or the measured current (see
    /// [`CurrentMeaning`](crate::CurrentMeaning)). Never NaN.
    pub current_a: Option<Vec<f64>>,
}

impl Log {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample. Never the case for a log from [`Bench::load`](crate::Bench::load).
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Time from the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// The samples of a channel, in SI.
    pub fn channel(&self, channel: Channel) -> Option<&[f64]> {
        match channel {
            Channel::Time => Some(&self.time_s),
            Channel::Angle => self.angle_rad.as_deref(),
            Channel::Rate => self.rate_rad_s.as_deref(),
            Channel::WheelSpeed => self.wheel_speed_rad_s.as_deref(),
            Channel::WheelAngle => self.wheel_angle_rad.as_deref(),
            Channel::Current => self.current_a.as_deref(),
        }
    }

    pub(crate) fn channel_mut(&mut self, channel: Channel) -> Option<&mut Vec<f64>> {
        match channel {
            Channel::Time => Some(&mut self.time_s),
            Channel::Angle => self.angle_rad.as_mut(),
            Channel::Rate => self.rate_rad_s.as_mut(),
            Channel::WheelSpeed => self.wheel_speed_rad_s.as_mut(),
            Channel::WheelAngle => self.wheel_angle_rad.as_mut(),
            Channel::Current => self.current_a.as_mut(),
        }
    }
}

impl Log {
    /// Sets the samples of a channel.
    pub(crate) fn set(&mut self, channel: Channel, samples: Vec<f64>) {
        match channel {
            Channel::Time => self.time_s = samples,
            Channel::Angle => self.angle_rad = Some(samples),
            Channel::Rate => self.rate_rad_s = Some(samples),
            Channel::WheelSpeed => self.wheel_speed_rad_s = Some(samples),
            Channel::WheelAngle => self.wheel_angle_rad = Some(samples),
            Channel::Current => self.current_a = Some(samples),
        }
    }
}

/// A note about a log: no error, but something that the user should know.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Samples of a sensor were lost; they are NaN in the [`Log`].
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
    /// Samples in the file.
    pub rows_in_file: usize,
    /// Notes for the user.
    pub notes: Vec<Note>,
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

/// The column of a channel, and its conversion to SI: scale · column + offset.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColumnUse {
    pub channel: Channel,
    pub name: String,
    /// Factor of unit and sign together.
    pub scale: f64,
    /// Offset in SI units.
    pub offset: f64,
    /// Whether this kind of experiment holds the channel still. It is then read into [`SamplesOfLog::beside`], and a cell
    /// that is not a number is NaN there.
    pub is_beside: bool,
}

/// The part of a file that is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Window {
    /// First time, s.
    pub from_s: Option<f64>,
    /// Last time, s.
    pub until_s: Option<f64>,
    /// Time from row to row for a file without a time column, s.
    pub time_step_s: Option<f64>,
    /// Whether the current is measured; otherwise it is a command that is held from row to row.
    pub measured_current: bool,
}

/// The samples of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SamplesOfLog {
    /// The channels that the kind uses.
    pub log: Log,
    /// The channels that the kind holds still.
    pub beside: Log,
    pub report: LoadReport,
}

/// Reads the samples of these columns in the window (both ends included). The time must be the first column,
/// unless the window has a time step.
pub(crate) fn read(
    mut table: OpenTable,
    uses: &[ColumnUse],
    window: Window,
) -> Result<SamplesOfLog, Error> {
    let Window {
        from_s,
        until_s,
        time_step_s,
        measured_current,
    } = window;
    let names: Vec<String> = uses.iter().map(|column| column.name.clone()).collect();
    // With a time step, the time comes before the columns; otherwise it is the first of them.
    let ahead = usize::from(time_step_s.is_some());
    let mut series: Vec<Vec<f64>> = vec![Vec::new(); ahead + uses.len()];
    let mut values = vec![0.0; ahead + uses.len()];
    let mut long = LongLog::new(uses, ahead > 0, measured_current);
    let mut rows_in_window = 0_usize;
    let mut merged = 0_usize;
    // Number of lines that were averaged into the last sample.
    let mut in_last = 1.0_f64;
    let mut first_s = f64::NAN;
    let mut before_s = f64::NEG_INFINITY;

    let rows = table.read_rows(&names, |row| {
        let cell = |k: usize| -> Result<f64, Error> {
            let column = &uses[k];
            let number = match row.number(k) {
                Err(_) if column.is_beside => return Ok(f64::NAN),
                number => number?,
            };
            let value = column.scale * number + column.offset;
            if value.is_finite() {
                Ok(value)
            } else {
                let cell = shortened(row.text(k));
                Err(row.error(k, Problem::NotFinite { cell }))
            }
        };
        let time_s = match time_step_s {
            Some(step_s) => step_s * row.index as f64,
            None => cell(0)?,
        };
        if time_s < before_s {
            return Err(row.error(
                0,
                Problem::TimeBackwards {
                    before_s,
                    after_s: time_s,
                },
            ));
        }
        let repeated = time_s == before_s;
        before_s = time_s;
        if row.index == 0 {
            first_s = time_s;
        }
        if from_s.is_some_and(|from| time_s < from) || until_s.is_some_and(|until| time_s > until) {
            return Ok(());
        }
        rows_in_window += 1;
        values[0] = time_s;
        for (k, value) in values.iter_mut().enumerate().skip(1) {
            *value = cell(k - ahead)?;
        }
        if repeated && rows_in_window > 1 {
            merged += 1;
            in_last += 1.0;
            for (samples, value) in series.iter_mut().zip(&values) {
                if let Some(mean) = samples.last_mut() {
                    *mean += (value - *mean) / in_last;
                }
            }
        } else {
            in_last = 1.0;
            if series
                .first()
                .is_some_and(|time_s| time_s.len() == CHUNK_ROWS)
            {
                long.take(&mut series);
            }
            for (samples, value) in series.iter_mut().zip(&values) {
                samples.push(*value);
            }
        }
        Ok(())
    })?;

    let kept = rows_in_window - merged;
    if 2 * merged > rows_in_window {
        return Err(table.header_error(
            Some(&uses[0].name),
            Problem::TimeTooCoarse {
                merged,
                rows: rows_in_window,
            },
        ));
    }
    if kept < MIN_SAMPLES {
        let remark = if rows == 0 {
            "; the file holds only a header line".to_string()
        } else {
            format!("; the file covers {first_s} s to {before_s} s")
        };
        return Err(Error::in_file(
            table.path(),
            Problem::TooFewSamples {
                found: kept,
                needed: MIN_SAMPLES,
                remark,
            },
        ));
    }

    let mut report = LoadReport {
        rows_in_file: rows,
        notes: Vec::new(),
    };
    if merged > 0 {
        report.notes.push(Note::MergedRows { count: merged });
    }
    let (log, beside) = if long.has_begun() {
        long.finish(series, &mut report.notes)
    } else {
        let (mut log, mut beside) = by_channel(series, uses, ahead > 0);
        report.notes.extend(cleaned(&mut log, &mut beside));
        (log, beside)
    };
    Ok(SamplesOfLog {
        log,
        beside,
        report,
    })
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

/// Unwraps angles, computes the wheel's speed if only its angle was logged, and removes lost samples. Returns notes on
/// what was done.
pub(crate) fn cleaned(log: &mut Log, beside: &mut Log) -> Vec<Note> {
    let mut notes = gaps(&log.time_s);
    if let Some(angle) = &mut beside.angle_rad {
        unwrap_turns(angle);
    }
    for angle in [&mut log.wheel_angle_rad, &mut beside.wheel_angle_rad]
        .into_iter()
        .flatten()
    {
        unwrap_wheel(angle);
    }
    speed_from_angle(log, &mut notes);
    if let Some(angle) = &mut log.angle_rad {
        let count = unwrap_turns(angle);
        if count > 0 {
            notes.push(Note::AngleUnwrapped { count });
        }
    }
    // The current is an input, not a state: it can really jump for one sample.
    for channel in [Channel::Angle, Channel::Rate, Channel::WheelSpeed] {
        let time_s = std::mem::take(&mut log.time_s);
        if let Some(samples) = log.channel_mut(channel) {
            let found = drop_outs(&time_s, samples);
            if !found.is_empty() {
                for &i in &found {
                    samples[i] = f64::NAN;
                }
                notes.push(Note::DropOuts {
                    channel,
                    times_s: found.iter().map(|&i| time_s[i]).collect(),
                });
            }
        }
        log.time_s = time_s;
    }
    notes
}

/// Computes the wheel's speed if only its angle was logged: differences over one sample on either side (one-sided
/// at the ends). Their noise is that of the angle divided by the time between.
fn speed_from_angle(log: &mut Log, notes: &mut Vec<Note>) {
    if log.wheel_speed_rad_s.is_some() {
        return;
    }
    let Some(angle) = &log.wheel_angle_rad else {
        return;
    };
    let last = angle.len() - 1;
    let speed = (0..=last).map(|k| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (angle[after] - angle[before]) / (log.time_s[after] - log.time_s[before])
    });
    log.wheel_speed_rad_s = Some(speed.collect());
    notes.push(Note::SpeedFromAngle);
}

/// Pauses of more than twenty usual intervals. In an irregular log, intervals vary, but not that much.
fn gaps(time_s: &[f64]) -> Vec<Note> {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return Vec::new();
    }
    let (_, median, _) = intervals.select_nth_unstable_by(middle, f64::total_cmp);
    let longest = 20.0 * *median;
    time_s
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > longest)
        .take(8)
        .map(|pair| Note::Gap {
            from_s: pair[0],
            to_s: pair[1],
        })
        .collect()
}

/// Whether a column stays within one turn (and a hundredth for its noise), as the reading of a sensor with a range of one
/// turn does.
fn is_within_a_turn(angle_rad: &[f64]) -> bool {
    let finite = angle_rad.iter().copied().filter(|angle| angle.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
        (low.min(angle), high.max(angle))
    });
    high - low <= 1.01 * std::f64::consts::TAU
}

/// Unwraps the angle of a wheel: between two samples, the shorter way is assumed.
fn unwrap_wheel(angle_rad: &mut [f64]) {
    use std::f64::consts::TAU;
    if !is_within_a_turn(angle_rad) {
        return;
    }
    let mut turns = 0.0;
    let mut before = angle_rad.first().copied().unwrap_or(0.0);
    for angle in angle_rad.iter_mut() {
        turns -= ((*angle - before) / TAU).round();
        before = *angle;
        *angle += turns * TAU;
    }
}

/// Removes the jumps of a sensor with a range of one turn, and counts them.
///
/// A jump between two samples is a wrap if it is nearer to one full turn than to zero
/// or two turns. Half a turn within one sample is faster than any pendulum at a usable
/// sampling rate; a drop-out from upright to zero is a jump of half a turn. A column that covers more
/// than one turn does not come from such a sensor.
fn unwrap_turns(angle_rad: &mut [f64]) -> usize {
    use std::f64::consts::{PI, TAU};
    if !is_within_a_turn(angle_rad) {
        return 0;
    }
    let mut turns = 0.0;
    let mut count = 0;
    let mut before = angle_rad.first().copied().unwrap_or(0.0);
    for angle in angle_rad.iter_mut() {
        let jump = *angle - before;
        before = *angle;
        if jump.abs() > 1.5 * PI && jump.abs() < 2.5 * PI {
            turns -= jump.signum();
            count += 1;
        }
        *angle += turns * TAU;
    }
    count
}
