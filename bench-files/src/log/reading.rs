//! The samples of a log, from the rows of its file.

use super::cleaning::cleaned;
use super::columns::{ColumnUse, by_channel};
use super::long_log::{CHUNK_ROWS, LongLog};
use super::note::{LoadReport, Note};
use super::samples::Log;
use crate::channel::Channel;
use crate::csv_table::OpenTable;
use crate::error::{Error, Problem, shortened};

/// Smallest number of samples of a log in its window: the test for drop-outs needs two samples on
/// either side.
pub const MIN_SAMPLES: usize = 5;

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
    /// The channels whose cells have their unit behind their number.
    pub in_cells: Vec<Channel>,
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
    // Whether the cells of a column have their unit behind their number.
    let mut has_unit: Vec<Option<bool>> = vec![None; uses.len()];

    let rows = table.read_rows(&names, |row| {
        let mut cell = |k: usize| -> Result<f64, Error> {
            let column = &uses[k];
            let (number, unit) = if let Some(number) = row.plain_number(k) {
                (number, None)
            } else if let Some((number, unit)) = row.number_with_unit(k) {
                (number, Some(unit))
            } else if column.is_beside {
                return Ok(f64::NAN);
            } else {
                (row.number(k)?, None)
            };
            let scale = match unit {
                Some(unit) => column.scale_in(unit),
                None => Some(column.scale),
            };
            // A number without a unit among others that have one could be in any unit.
            let is_like_the_first = *has_unit[k].get_or_insert(unit.is_some()) == unit.is_some();
            let Some(scale) = scale.filter(|_| is_like_the_first) else {
                if row.is_clock(k) {
                    row.number(k)?;
                }
                let (cell, key) = (shortened(row.text(k)), column.channel.key());
                return Err(row.error(k, Problem::UnitInCell { cell, key }));
            };
            let value = scale * number + column.offset;
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
                    hint: starts_again(before_s, time_s, uses.first()),
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
        ..LoadReport::default()
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
    let in_cells = uses.iter().zip(has_unit);
    let in_cells = in_cells.filter(|(_, has_unit)| *has_unit == Some(true));
    Ok(SamplesOfLog {
        log,
        beside,
        report,
        in_cells: in_cells.map(|(column, _)| column.channel).collect(),
    })
}

/// Numbers at which counters of 16, 31 and 32 bits start again.
const COUNTERS: [f64; 3] = [65_536.0, 2_147_483_648.0, 4_294_967_296.0];

/// The remark that a time goes backwards because its counter starts again, as a board's micros() does after 71 minutes.
fn starts_again(before_s: f64, after_s: f64, time: Option<&ColumnUse>) -> String {
    let raw = |time_s: f64| time.map_or(f64::NAN, |time| (time_s - time.offset) / time.scale);
    let (before, after) = (raw(before_s), raw(after_s));
    // A hundredth of the range is far more than one step.
    let is_end = |size: &&f64| {
        before < **size && before > 0.99 * **size && (0.0..0.01 * **size).contains(&after)
    };
    match COUNTERS.iter().find(is_end) {
        Some(size) => format!(
            "; here its counter starts again after {size:.0}: add {size:.0} to the column from this line on"
        ),
        None => String::new(),
    }
}
