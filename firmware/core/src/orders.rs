//! The orders of the program at the other end of the line.

use generated::Current;
use serial_frame::{Command, Task};

/// The order in force.
#[derive(Clone, Debug)]
pub struct Orders {
    command: Command,
    /// Time at which the command came, µs.
    came_us: u32,
    /// Whether a command has come since the start.
    has_heard: bool,
    /// Whether the command has a new number that [`Orders::takes_new`] has not reported yet.
    is_new: bool,
    /// Whether the controller was armed for this command; it must not be armed again.
    was_armed: bool,
    /// Word of the current that the command asks for.
    current_word: i32,
    /// Steps since the last frame.
    since_frame: u8,
}

impl Orders {
    /// No order yet: watch, and send every frame.
    pub const fn new() -> Orders {
        Orders {
            command: Command {
                task: Task::Watch,
                wish: 0,
                every: 1,
                lease_ms: 0,
            },
            came_us: 0,
            has_heard: false,
            is_new: false,
            was_armed: false,
            current_word: 0,
            since_frame: u8::MAX,
        }
    }

    /// Replaces the order in force by this one.
    ///
    /// A program repeats its command, also to a board whose supply has just dropped and come back. The first command
    /// after the start may therefore be one that was under way before: if it asks for the motor, the controller is not
    /// armed for it, but for the next number. A program that begins says so with [`Task::Watch`].
    pub fn take(&mut self, command: Command, now_us: u32) {
        let is_first = !core::mem::replace(&mut self.has_heard, true);
        if is_first || command.wish != self.command.wish {
            self.is_new = true;
            self.was_armed = is_first && command.task != Task::Watch;
        }
        if let Task::Drive { current_ua } = command.task {
            self.current_word = word_of(current_ua);
        }
        self.command = command;
        self.came_us = now_us;
    }

    /// Ends a command whose lease is over: the motor is not driven any more, and the controller cannot be armed again
    /// for the same number.
    pub fn expire(&mut self, now_us: u32) {
        let age_us = now_us.wrapping_sub(self.came_us);
        if self.command.task != Task::Watch && age_us > u32::from(self.command.lease_ms) * 1000 {
            self.command.task = Task::Watch;
            self.was_armed = true;
        }
    }

    /// The task.
    pub fn task(&self) -> Task {
        self.command.task
    }

    /// Whether a command with a new number has come since the last call.
    pub fn takes_new(&mut self) -> bool {
        core::mem::take(&mut self.is_new)
    }

    /// Whether the controller may be armed for this command: only once.
    pub fn may_arm(&self) -> bool {
        !self.was_armed
    }

    /// The controller was armed.
    pub fn armed(&mut self) {
        self.was_armed = true;
    }

    /// Word of the current that is asked for.
    pub fn current_word(&self) -> i32 {
        self.current_word
    }

    /// Whether a frame is due in this step.
    pub fn is_frame_due(&mut self) -> bool {
        self.since_frame = self.since_frame.saturating_add(1);
        if self.since_frame < self.command.every.max(1) {
            return false;
        }
        self.since_frame = 0;
        true
    }
}

impl Default for Orders {
    fn default() -> Self {
        Orders::new()
    }
}

/// The module's word for a current in µA. Beyond the range of the word it is the end of the range, which the module
/// limits further.
fn word_of(current_ua: i32) -> i32 {
    let word = (i64::from(current_ua) << Current::FRAC_NBITS) / 1_000_000;
    word.clamp(i64::from(i32::MIN + 1), i64::from(i32::MAX)) as i32
}
