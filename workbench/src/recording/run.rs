//! The course of a record: commands out, frames in, from the first row to the last.

use std::fmt;
use std::time::{Duration, Instant};

use identify::Progress;
use plant::Kind;
use serde::{Deserialize, Serialize};
use serial_frame::{Command, Task, Telemetry};

use super::experiment::Part;
use super::line::Line;
use super::words::Words;
use crate::error::Error;

/// Time for which the firmware continues to drive the motor after the last command, ms.
const LEASE_MS: u16 = 1000;
/// Interval of the repeated commands. Several in a row must be lost before the lease ends.
const RENEWAL: Duration = Duration::from_millis(100);
/// The line counts as silent after this time without a frame.
const SILENCE: Duration = Duration::from_secs(3);
/// Longest wait for the first row, in which a person may have to hold the body where the controller arms.
const PATIENCE: Duration = Duration::from_secs(60);
/// Longest wait for a wheel to come to rest. A wheel that no hand stops coasts for a minute or two.
const REST_PATIENCE: Duration = Duration::from_secs(180);
/// A wheel slower than this (rad/s) counts as at rest. The fit of a spin-up estimates the wheel's speed at the first
/// sample, so the log need not begin at exactly zero.
const REST_RAD_S: f64 = 10.0;
/// Time after which a command counts as in force though no two frames came at its pace: a line may lose most of them.
const SETTLING: Duration = Duration::from_secs(1);
/// If the time stamps of two frames differ by more than this, in µs, the firmware has restarted.
const RESTART_US: u32 = 10_000_000;

/// Status words of the emitted module.
const NOT_ALIGNED: u8 = 0;
const READY: u8 = 1;
const RUNNING: u8 = 2;

/// The status of the controller in words.
pub(super) fn status_text(status: u8) -> String {
    let text = match status {
        NOT_ALIGNED => {
            "the attitude is not known: hold the body still for a moment, upright where an encoder on the \
             pivot shows it"
        }
        READY => {
            "ready, but not armed: hold the body upright and still (if it is, an axis in [hardware] is wrong: record hanging, \
             tilted and wheel-spun, and run `flywheel bring-up`)"
        }
        RUNNING => "running",
        3 => "tripped: the body leaned too far",
        4 => "tripped: the gyroscope's words, or the counts of the pivot's encoder, stood still",
        5 => "tripped: gyroscope or accelerometer was at the end of its range",
        6 => "tripped: the wheel's speed was unknown, or at the end of its sensor's range",
        7 => "tripped: the accelerometer showed no gravity",
        8 => "tripped: the current stayed at its limit",
        9 => "tripped: a missed tick or a bus error",
        other => return format!("status {other}, which this program does not know"),
    };
    text.to_owned()
}

/// The reason why a record ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RecordEnd {
    /// The record has its full length.
    Complete,
    /// The user ended the record.
    CalledOff,
    /// The controller stopped running; with its status.
    NotRunning(u8),
    /// The wheel reached the largest speed that its sensor shows.
    WheelBeyondSensor,
    /// No more frames came.
    Silent,
    /// The firmware restarted.
    Restarted,
}

impl fmt::Display for RecordEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RecordEnd::Complete => f.write_str("full length"),
            RecordEnd::CalledOff => f.write_str("called off by the user"),
            RecordEnd::NotRunning(READY) => f.write_str("the controller was disarmed"),
            RecordEnd::NotRunning(status) => f.write_str(&status_text(*status)),
            RecordEnd::WheelBeyondSensor => {
                f.write_str("the wheel reached the largest speed that its sensor shows")
            }
            RecordEnd::Silent => f.write_str("the line fell silent"),
            RecordEnd::Restarted => f.write_str("the firmware restarted"),
        }
    }
}

/// One frame in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordedSample {
    /// Time since the record began, s; `None` before that.
    pub time_s: Option<f64>,
    /// Body angle from upright, rad.
    pub from_upright_rad: f64,
    /// Body rate, rad/s.
    pub rate_rad_s: f64,
    /// Wheel speed relative to the body, rad/s.
    pub wheel_speed_rad_s: f64,
    /// The commanded current, A.
    pub current_a: f64,
    /// The controller's status.
    pub status: u8,
}

/// A row of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Time since the first row, s.
    pub time_s: f64,
    pub frame: Telemetry,
    /// Number of frames that were lost between the row before and this one.
    pub lost_before: u32,
}

/// The rows of a part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wanted {
    pub rows: Vec<Row>,
    pub damaged: u64,
    pub end: RecordEnd,
}

/// An open line on which parts are recorded one after another.
pub(super) struct Run<'w> {
    line: Line,
    words: &'w Words,
    every: u8,
    wish: u8,
    command: Command,
    sent: Option<Instant>,
    heard: Instant,
}

impl<'w> Run<'w> {
    pub fn new(line: Line, words: &'w Words, every: u8) -> Run<'w> {
        let every = every.max(1);
        Run {
            line,
            words,
            every,
            // Another program may have sent a command before. Its number differs from this one in 255 of 256 cases, and
            // the firmware then begins the task.
            wish: std::process::id() as u8,
            command: Command {
                task: Task::Watch,
                wish: 0,
                every,
                lease_ms: LEASE_MS,
            },
            sent: None,
            heard: Instant::now(),
        }
    }

    /// Records one log.
    pub fn part(
        &mut self,
        part: &Part,
        progress: &Progress,
        sample: &mut dyn FnMut(&RecordedSample),
    ) -> Result<Wanted, Error> {
        self.heard = Instant::now();
        let mut got = Wanted {
            rows: Vec::new(),
            damaged: 0,
            end: RecordEnd::CalledOff,
        };
        if part.from_rest && !self.until_at_rest(part, progress, sample)? {
            return Ok(got);
        }
        if let Some(first) = self.until_begun(part, progress, sample)? {
            // What came before the first row, such as the rest of a frame or the text of a boot loader, is none of the log's.
            let damaged = self.line.damaged;
            got.end = self.rows(part, first, progress, sample, &mut got.rows)?;
            got.damaged = self.line.damaged - damaged;
        }
        Ok(got)
    }

    /// Asks the firmware to switch the motor off. If the firmware does not receive this command, it switches the motor
    /// off when the lease ends.
    pub fn let_go(&mut self) {
        self.ask(Task::Watch, false);
        for _ in 0..3 {
            let _ = self.line.send(&self.command);
        }
    }

    /// Begins a task on a firmware that may just have started. After its start a firmware does not arm for the first
    /// command if that asks for the motor, because it may be one from before the start: so it first hears another.
    fn begin(&mut self, task: Task) -> Result<(), Error> {
        self.ask(Task::Watch, true);
        // Some may be lost on the line.
        for _ in 0..3 {
            self.line.send(&self.command)?;
        }
        self.ask(task, true);
        Ok(())
    }

    /// Sends this task from now on. With `is_new` the firmware begins it anew; otherwise it only changes.
    fn ask(&mut self, task: Task, is_new: bool) {
        if is_new {
            self.wish = self.wish.wrapping_add(1);
        }
        self.command = Command {
            task,
            wish: self.wish,
            every: self.every,
            lease_ms: LEASE_MS,
        };
        self.sent = None;
    }

    /// The next frame; `None` if none came for a moment. The command is repeated in time.
    fn next(&mut self) -> Result<Option<Telemetry>, Error> {
        if self.sent.is_none_or(|sent| sent.elapsed() >= RENEWAL) {
            self.line.send(&self.command)?;
            self.sent = Some(Instant::now());
        }
        let frame = self.line.next()?;
        if frame.is_some() {
            self.heard = Instant::now();
        }
        Ok(frame)
    }

    fn is_silent(&self) -> bool {
        self.heard.elapsed() > SILENCE
    }

    fn silent(&self) -> Error {
        self.line.broken(match self.line.has_damage() {
            false => {
                "no byte that ends a frame came: is this the firmware's port, and does the firmware run?"
            }
            true => "bytes came, but no whole frame: is --baud the firmware's?",
        })
    }

    /// Waits until the wheel is nearly at rest; `false` if the user cancelled.
    fn until_at_rest(
        &mut self,
        part: &Part,
        progress: &Progress,
        sample: &mut dyn FnMut(&RecordedSample),
    ) -> Result<bool, Error> {
        self.ask(Task::Watch, true);
        let began = Instant::now();
        while began.elapsed() < REST_PATIENCE {
            if (progress.cancelled)() {
                return Ok(false);
            }
            let Some(frame) = self.next()? else {
                if self.is_silent() {
                    return Err(self.silent());
                }
                continue;
            };
            sample(&self.in_si(&frame, None));
            let speed_rad_s = self.words.wheel_speed_rad_s(&frame);
            if speed_rad_s.abs() < REST_RAD_S && !self.words.is_wheel_unknown(&frame) {
                return Ok(true);
            }
            (progress.say)(&format!(
                "{}: waiting for the wheel to stop, {speed_rad_s:.0} rad/s",
                part.name
            ));
        }
        Err(self.line.broken(
            "the wheel does not come to rest: stop it by hand; if it stands still, its speed is measured wrongly: \
             correct [hardware.wheel_speed]",
        ))
    }

    /// Sends the first task and waits for the first row; `None` if the user cancelled.
    fn until_begun(
        &mut self,
        part: &Part,
        progress: &Progress,
        sample: &mut dyn FnMut(&RecordedSample),
    ) -> Result<Option<Telemetry>, Error> {
        self.ask(Task::Watch, true);
        let began = Instant::now();
        let mut status = NOT_ALIGNED;
        let mut last = None;
        let mut commanded = began;
        let mut is_in_force = false;
        while began.elapsed() < PATIENCE {
            if (progress.cancelled)() {
                return Ok(None);
            }
            let Some(frame) = self.next()? else {
                if self.is_silent() {
                    return Err(self.silent());
                }
                continue;
            };
            sample(&self.in_si(&frame, None));
            let before: Option<Telemetry> = last.replace(frame);
            // Opening the port restarts some boards.
            let Some(before) =
                before.filter(|one| frame.time_us.wrapping_sub(one.time_us) <= RESTART_US)
            else {
                self.begin(part.stretches[0].task)?;
                (commanded, is_in_force) = (Instant::now(), false);
                continue;
            };
            status = frame.status;
            // The first frames may still come at the pace of an earlier command: nothing is lost between them.
            let steps = frame.sequence.wrapping_sub(before.sequence);
            is_in_force |= steps == u16::from(self.every) || commanded.elapsed() > SETTLING;
            if !is_in_force {
                continue;
            }
            // An encoder on the pivot shows the angle from its first count on, in every position of the body.
            let is_known = status != NOT_ALIGNED || self.words.has_pivot_encoder;
            let is_begun =
                (!part.needs_running || status == RUNNING) && (!part.needs_attitude || is_known);
            if is_begun {
                return Ok(Some(frame));
            }
            (progress.say)(&format!("{}: {}", part.name, status_text(status)));
        }
        Err(self.line.broken(&format!(
            "the controller did not begin within {} s: {}",
            PATIENCE.as_secs(),
            status_text(status)
        )))
    }

    /// Collects rows until the part ends, and returns the reason for the end.
    fn rows(
        &mut self,
        part: &Part,
        first: Telemetry,
        progress: &Progress,
        sample: &mut dyn FnMut(&RecordedSample),
        rows: &mut Vec<Row>,
    ) -> Result<RecordEnd, Error> {
        let total_s: f64 = part.stretches.iter().map(|one| one.seconds).sum();
        let mut stretch = 0;
        let mut ends_s = part.stretches[0].seconds;
        let mut last = first;
        let (mut passed_us, mut time_s, mut lost) = (0_u64, 0.0, 0);
        let mut said_s = f64::NEG_INFINITY;
        let mut next = Some(first);
        loop {
            if let Some(frame) = next {
                let step_us = frame.time_us.wrapping_sub(last.time_us);
                let is_repeated = step_us > RESTART_US && is_one_of(rows, &frame);
                if step_us > RESTART_US && !is_repeated {
                    return Ok(RecordEnd::Restarted);
                }
                if part.needs_running && frame.status != RUNNING {
                    return Ok(RecordEnd::NotRunning(frame.status));
                }
                if part.kind == Kind::SpinUp && self.words.is_wheel_unknown(&frame) {
                    return Ok(RecordEnd::WheelBeyondSensor);
                }
                // A frame that arrives twice gives one row, also where others came between.
                if rows.is_empty() || step_us > 0 && !is_repeated {
                    passed_us += u64::from(step_us);
                    time_s = passed_us as f64 / 1e6;
                    let lost_before = match rows.is_empty() {
                        true => 0,
                        false => lost_between(&last, &frame, self.every),
                    };
                    lost += lost_before;
                    rows.push(Row {
                        time_s,
                        frame,
                        lost_before,
                    });
                    sample(&self.in_si(&frame, Some(time_s)));
                    last = frame;
                }
                if time_s >= total_s {
                    return Ok(RecordEnd::Complete);
                }
                if time_s >= ends_s {
                    stretch += 1;
                    ends_s += part.stretches[stretch].seconds;
                    self.ask(part.stretches[stretch].task, false);
                }
                if time_s - said_s > 0.2 {
                    said_s = time_s;
                    (progress.say)(&format!(
                        "{}: {time_s:.1} of {total_s} s, {} rows, {lost} frames lost",
                        part.name,
                        rows.len()
                    ));
                }
            } else if self.is_silent() {
                return Ok(RecordEnd::Silent);
            }
            if (progress.cancelled)() {
                return Ok(RecordEnd::CalledOff);
            }
            next = match self.next() {
                Ok(frame) => frame,
                // If the plug is pulled, the record ends, and the rows so far are kept.
                Err(_) => return Ok(RecordEnd::Silent),
            };
        }
    }

    fn in_si(&self, frame: &Telemetry, time_s: Option<f64>) -> RecordedSample {
        RecordedSample {
            time_s,
            from_upright_rad: self.words.angle_from_upright_rad(frame),
            rate_rad_s: self.words.rate_rad_s(frame),
            wheel_speed_rad_s: self.words.wheel_speed_rad_s(frame),
            current_a: self.words.current_a(frame),
            status: frame.status,
        }
    }
}

/// Whether one of these rows is this frame: a line that sends what it has sent before. A firmware that has restarted sends
/// no such frame: times, numbers and readings would all have to agree.
fn is_one_of(rows: &[Row], frame: &Telemetry) -> bool {
    rows.iter().rev().any(|row| row.frame == *frame)
}

/// Number of frames that the firmware sent between these two, for one frame every `every` steps.
fn lost_between(last: &Telemetry, frame: &Telemetry, every: u8) -> u32 {
    let steps = u32::from(frame.sequence.wrapping_sub(last.sequence));
    steps.div_ceil(u32::from(every)).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_missed_by_their_numbers_across_the_wrap() {
        let frame = |sequence| Telemetry {
            sequence,
            ..Telemetry::default()
        };
        for (last, next, every, lost) in [
            (5, 6, 1, 0),
            (5, 9, 1, 3),
            (65_534, 1, 1, 2),
            (10, 15, 5, 0),
            (10, 30, 5, 3),
            // A firmware that sends a frame in every step.
            (10, 11, 5, 0),
        ] {
            assert_eq!(lost_between(&frame(last), &frame(next), every), lost);
        }
    }
}
