//! A command of the program to the firmware.

use crate::fields::{Reader, Writer};
use crate::{Frame, VERSION};

/// Bytes of the message with its CRC.
pub const COMMAND_BYTES: usize = 12;

/// The task of the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Task {
    /// Send the readings of the sensors; the motor gets no current.
    #[default]
    Watch,
    /// Arm the controller, which then balances.
    Balance,
    /// Arm the controller and drive with this current, µA, under the same limits and trips.
    Drive {
        /// µA, positive drives the wheel forward.
        current_ua: i32,
    },
}

/// A command of the program. The program repeats it well within its lease, because the motor must stop if the line
/// falls silent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// The task.
    pub task: Task,
    /// The number of the command. A task that has tripped begins again only for another number.
    pub wish: u8,
    /// Number of steps from one frame to the next; 0 counts as 1.
    pub every: u8,
    /// Time in ms after this command at which the firmware switches the motor off, unless another command comes.
    pub lease_ms: u16,
}

impl Command {
    /// The message as a frame.
    pub fn frame(&self) -> Frame {
        let (task, current_ua) = match self.task {
            Task::Watch => (0, 0),
            Task::Balance => (1, 0),
            Task::Drive { current_ua } => (2, current_ua),
        };
        let mut message = Writer::new();
        message.put(&[VERSION, task, self.wish, self.every]);
        message.put(&self.lease_ms.to_le_bytes());
        message.put(&current_ua.to_le_bytes());
        Frame::of(message)
    }

    /// Reads a message that was received whole: its length and its CRC are right.
    pub(crate) fn read(bytes: &[u8]) -> Option<Command> {
        if bytes.len() != COMMAND_BYTES {
            return None;
        }
        let mut fields = Reader::new(bytes);
        if fields.byte() != VERSION {
            return None;
        }
        let task = fields.byte();
        let wish = fields.byte();
        let every = fields.byte();
        let lease_ms = u16::from_le_bytes(fields.take());
        let current_ua = i32::from_le_bytes(fields.take());
        let task = match task {
            0 => Task::Watch,
            1 => Task::Balance,
            2 => Task::Drive { current_ua },
            _ => return None,
        };
        Some(Command {
            task,
            wish,
            every,
            lease_ms,
        })
    }
}
