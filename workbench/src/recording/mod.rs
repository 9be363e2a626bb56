//! From the firmware's frames on a serial line to a log of the bench.
//!
//! The program commands a task (watch, balance, drive) and repeats the command, because the firmware switches the
//! motor off when the commands stop. Every frame becomes a row; frames that did not arrive are counted
//! by their sequence numbers and marked in the row that follows them.

mod experiment;
mod line;
mod log_text;
mod run;
mod start;
mod words;

use std::path::{Path, PathBuf};

use bench_files::{BenchOutline, NewExperiment, file_name};
use identify::Progress;
use serde::{Deserialize, Serialize};

pub use experiment::RecordedExperiment;
pub use run::{RecordEnd, RecordedSample};

use crate::bench_hardware::Preset;
use crate::error::Error;
use experiment::Part;
use line::Line;
use run::{Run, Wanted};
use words::Words;

/// The settings of [`record`]: the experiment, and the line to the firmware.
#[derive(Clone, Debug)]
pub struct RecordSettings {
    /// The serial device.
    pub port: PathBuf,
    /// Bits per second; without effect on a USB port of the chip itself.
    pub baud: u32,
    /// The experiment.
    pub experiment: RecordedExperiment,
    /// Currents, A. `spin-up` records one log for each; `coast-down` and `current-step` use the first. If empty, the
    /// currents are the usual shares of the current limit.
    pub currents_a: Vec<f64>,
    /// Length of a log, s; `None`: [`RecordedExperiment::usual_seconds`].
    pub seconds: Option<f64>,
    /// The log's name; `None`: after the experiment.
    pub name: Option<String>,
    /// A row is recorded in one of this many steps of the controller; 0 counts as 1.
    pub every: u8,
    /// The emitted crate that runs in the firmware. With `None`, the words of the frames are taken from `[hardware]`;
    /// they agree with the firmware unless `[hardware]` was changed after the module was generated.
    pub module: Option<PathBuf>,
    /// The bench that supplies what `[hardware]` does not state of sensors and drive. With `None`, incomplete hardware
    /// is refused.
    pub preset: Option<Preset>,
}

/// The result of [`record`]: the logs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordReport {
    /// The bench.toml that has the new entries.
    pub bench: PathBuf,
    /// The logs, in the order in which they were recorded.
    pub logs: Vec<RecordedLog>,
}

/// A log that was written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedLog {
    /// Its name in bench.toml, or its key under `[bring_up]`.
    pub name: String,
    /// The kind of the experiment; "bring-up" for a recording of raw counts.
    pub kind: String,
    /// The file.
    pub file: PathBuf,
    /// Rows in it.
    pub rows: usize,
    /// Time from the first to the last of them, s.
    pub duration_s: f64,
    /// Frames that the firmware sent in that time and that did not arrive whole.
    pub lost_frames: u64,
    /// Number of damaged frames in that time: sequences of bytes between two ends of frames that were no valid frame.
    pub damaged_frames: u64,
    /// Time in the log at which the experiment begins (`from`), s.
    pub from_s: Option<f64>,
    /// The reason why the record ended.
    pub end: RecordEnd,
    /// Remarks for the user; sentences.
    pub notes: Vec<String>,
}

/// Smallest number of rows of a log that is written.
const ROWS_MIN: usize = bench_files::MIN_SAMPLES;

/// Records an experiment and adds it to the bench.toml of `bench` (its folder, or that file). `sample` is called with
/// every frame as it arrives. Cancelling ends the record, and the rows so far are written.
///
/// # Errors
/// A bench.toml that cannot be read, hardware that is not stated ([`Error::Hardware`]), a port that
/// cannot be opened or is silent, a controller that does not arm ([`Error::Record`]). After the first log of several, a note
/// of the last log says it instead.
pub fn record(
    bench: &Path,
    settings: &RecordSettings,
    progress: &Progress,
    sample: &mut dyn FnMut(&RecordedSample),
) -> Result<RecordReport, Error> {
    let mut outline = BenchOutline::read(bench)?;
    let words = Words::of(&outline, settings)?;
    let parts = experiment::parts(settings, &words).map_err(|reason| Error::Record {
        port: settings.port.clone(),
        reason,
    })?;
    bench_files::can_write_into(&outline.folder)?;
    let line = Line::open(&settings.port, settings.baud)?;
    let mut run = Run::new(line, &words, settings.every);
    let mut logs: Vec<RecordedLog> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let got = run.part(part, progress, sample);
        run.let_go();
        let got = match got {
            Ok(got) => got,
            Err(error) => {
                not_recorded(&mut logs, &parts[index..], error)?;
                break;
            }
        };
        let is_called_off = got.end == RecordEnd::CalledOff;
        if got.rows.len() < ROWS_MIN {
            if is_called_off && !logs.is_empty() {
                break;
            }
            if is_called_off {
                progress.check()?;
            }
            let error = Error::Record {
                port: settings.port.clone(),
                reason: format!(
                    "only {} frames came, fewer than the {ROWS_MIN} that a log needs: nothing was written ({})",
                    got.rows.len(),
                    got.end
                ),
            };
            not_recorded(&mut logs, &parts[index..], error)?;
            break;
        }
        logs.push(kept(&mut outline, part, &words, got)?);
        if is_called_off {
            break;
        }
    }
    Ok(RecordReport {
        bench: outline.file,
        logs,
    })
}

/// The logs that were recorded before an error are kept: the last of them says which ones are missing, and why. Where there
/// is none, the error is that of the whole record.
fn not_recorded(logs: &mut [RecordedLog], missing: &[Part], error: Error) -> Result<(), Error> {
    let Some(last) = logs.last_mut() else {
        return Err(error);
    };
    let names: Vec<&str> = missing.iter().map(|part| part.name.as_str()).collect();
    last.notes
        .push(format!("not recorded: {} ({error})", names.join(", ")));
    Ok(())
}

/// Writes a log and its entry.
fn kept(
    outline: &mut BenchOutline,
    part: &Part,
    words: &Words,
    got: Wanted,
) -> Result<RecordedLog, Error> {
    let mut notes = part.notes.clone();
    let (name, file, kind) = match part.bring_up {
        Some(key) => (
            key.to_owned(),
            file_name(&key.replace('_', "-")),
            "bring-up",
        ),
        None => {
            let name = outline.free_name(&part.name);
            let file = file_name(&name);
            (name, file, part.kind.name())
        }
    };
    let path = outline.folder.join(&file);
    let from_s = start::of(part, &got.rows, words, &mut notes);
    let text = match part.bring_up {
        Some(_) => log_text::raw_counts(&got.rows, words.has_pivot_encoder),
        None => log_text::log(part.kind, &got.rows, words),
    };
    bench_files::write_atomically(&path, text.as_bytes())?;
    let lost_frames: u64 = got.rows.iter().map(|row| u64::from(row.lost_before)).sum();
    match part.bring_up {
        Some(key) => outline.set_bring_up(key, &file)?,
        None => outline.add_experiment(&NewExperiment {
            name: name.clone(),
            kind: part.kind,
            file,
            from_s,
            comment: format!(
                "Recorded by flywheel record: {} rows, {lost_frames} frames lost; ended: {}.",
                got.rows.len(),
                got.end
            ),
        })?,
    }
    Ok(RecordedLog {
        name,
        kind: kind.to_owned(),
        file: path,
        rows: got.rows.len(),
        duration_s: got.rows.last().map_or(0.0, |row| row.time_s),
        lost_frames,
        damaged_frames: got.damaged,
        from_s,
        end: got.end,
        notes,
    })
}
