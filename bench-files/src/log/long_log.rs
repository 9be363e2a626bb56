//! A log that is too long to be kept in full: it is cleaned in pieces while it is read, and kept as averages.

use std::f64::consts::TAU;

use super::cleaning::cleaned;
use super::columns::{ColumnUse, by_channel};
use super::note::Note;
use super::samples::Log;
use crate::averages::{Averages, MOST_BLOCKS};
use crate::channel::Channel;

/// Number of rows in a piece. A log with fewer rows is kept in full.
pub(crate) const CHUNK_ROWS: usize = 1 << 18;
/// Number of rows that consecutive pieces share: the test for drop-outs needs two rows on either side.
const SHARED_ROWS: usize = 4;
/// Largest number of pauses that are reported.
const MOST_GAPS: usize = 8;

/// The part of a long log that has been read.
pub(crate) struct LongLog<'u> {
    uses: &'u [ColumnUse],
    time_is_ahead: bool,
    measured_current: bool,
    rows: usize,
    /// The channels of the averages; `true` marks those that the kind holds still.
    layout: Vec<(bool, Channel)>,
    averages: Option<Averages>,
    /// The last sample of every channel.
    last: Vec<f64>,
    notes: Vec<Note>,
}

impl<'u> LongLog<'u> {
    /// Nothing read yet.
    pub fn new(uses: &'u [ColumnUse], time_is_ahead: bool, measured_current: bool) -> LongLog<'u> {
        LongLog {
            uses,
            time_is_ahead,
            measured_current,
            rows: 0,
            layout: Vec::new(),
            averages: None,
            last: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// Whether a piece has been added.
    pub fn has_begun(&self) -> bool {
        self.averages.is_some()
    }

    /// Adds the rows of a piece, except the last ones, which remain in `series` as the beginning of the next piece.
    pub fn take(&mut self, series: &mut [Vec<f64>]) {
        self.piece(series.to_vec(), false);
        for samples in series {
            samples.drain(..samples.len() - SHARED_ROWS);
        }
    }

    /// Adds the last rows, and returns the averages of all. Notes are added to `notes`.
    pub fn finish(mut self, series: Vec<Vec<f64>>, notes: &mut Vec<Note>) -> (Log, Log) {
        self.piece(series, true);
        let (mut log, mut beside) = (Log::default(), Log::default());
        if let Some(averages) = self.averages {
            let block = averages.rows();
            let (time_s, series) = averages.series();
            log.time_s = time_s;
            for ((is_beside, channel), samples) in self.layout.into_iter().zip(series) {
                let log = if is_beside { &mut beside } else { &mut log };
                log.set(channel, samples);
            }
            if block > 1 {
                let rows = self.rows;
                notes.push(Note::Averaged { rows, block });
            }
        }
        notes.extend(self.notes);
        (log, beside)
    }

    fn piece(&mut self, series: Vec<Vec<f64>>, is_last: bool) {
        let rows = series.first().map_or(0, Vec::len);
        let (mut log, mut beside) = by_channel(series, self.uses, self.time_is_ahead);
        for note in cleaned(&mut log, &mut beside) {
            self.note(note);
        }
        if self.averages.is_none() {
            let is_there = |of: &Log, channel: &Channel| of.channel(*channel).is_some();
            let channels = || Channel::ALL.into_iter().filter(|one| *one != Channel::Time);
            let used = channels().filter(|one| is_there(&log, one));
            let still = channels().filter(|one| is_there(&beside, one));
            self.layout = used
                .map(|one| (false, one))
                .chain(still.map(|one| (true, one)))
                .collect();
            let command = (false, Channel::Current);
            let command = self.layout.iter().position(|one| *one == command);
            let command = command.filter(|_| !self.measured_current);
            self.averages = Some(Averages::new(self.layout.len(), command, MOST_BLOCKS));
        }
        let is_first = self.rows == 0;
        let half = SHARED_ROWS / 2;
        let from = if is_first { 0 } else { half };
        let to = if is_last { rows } else { rows - half };
        // Each piece is unwrapped by itself; the pieces are joined here.
        for (at, &(is_beside, channel)) in self.layout.iter().enumerate() {
            let log = if is_beside { &mut beside } else { &mut log };
            if !matches!(channel, Channel::Angle | Channel::WheelAngle) || is_first {
                continue;
            }
            if let Some(samples) = log.channel_mut(channel) {
                let turns = ((self.last[at] - samples[from - 1]) / TAU).round();
                if turns.is_finite() && turns != 0.0 {
                    samples.iter_mut().for_each(|angle| *angle += turns * TAU);
                }
            }
        }
        let columns: Vec<&[f64]> = self
            .layout
            .iter()
            .map(|&(is_beside, channel)| {
                let log = if is_beside { &beside } else { &log };
                log.channel(channel).unwrap_or(&[])
            })
            .collect();
        if let Some(averages) = &mut self.averages {
            for row in from..to {
                averages.push(log.time_s[row], columns.iter().map(|column| column[row]));
            }
        }
        self.last = columns.iter().map(|column| column[to - 1]).collect();
        self.rows += to - from;
    }

    /// Adds a note; it is merged with an earlier note of the same kind.
    fn note(&mut self, note: Note) {
        for known in &mut self.notes {
            match (known, &note) {
                (
                    Note::DropOuts { channel, times_s },
                    Note::DropOuts {
                        channel: other,
                        times_s: more,
                    },
                ) if channel == other => {
                    times_s.extend(more);
                    return;
                }
                (Note::AngleUnwrapped { count }, Note::AngleUnwrapped { count: more }) => {
                    *count += more;
                    return;
                }
                (known, note) if known == note => return,
                _ => {}
            }
        }
        let gaps = self
            .notes
            .iter()
            .filter(|note| matches!(note, Note::Gap { .. }));
        if matches!(note, Note::Gap { .. }) && gaps.count() >= MOST_GAPS {
            return;
        }
        self.notes.push(note);
    }
}
