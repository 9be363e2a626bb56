//! From the bytes of the line back to messages.

use crate::{Command, FRAME_BYTES_MAX, MESSAGE_BYTES_MAX, Telemetry, crc16};

/// The reason why the bytes between two zeros are no message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// More bytes than the longest frame has.
    TooLong,
    /// COBS cannot be undone, or the CRC differs: bytes were lost or changed.
    Damaged,
    /// The frame is whole, but its message has another length, version or task.
    Unknown,
}

/// Joins the bytes of the line, one at a time, to frames.
#[derive(Clone, Debug)]
pub struct Receiver {
    bytes: [u8; FRAME_BYTES_MAX],
    /// Number of bytes received; larger than the buffer if the frame is too long.
    length: usize,
}

impl Receiver {
    /// A receiver before the first byte. The first bytes may be the end of a frame, which is then refused as damaged.
    pub const fn new() -> Receiver {
        Receiver {
            bytes: [0; FRAME_BYTES_MAX],
            length: 0,
        }
    }

    /// Takes a byte from the firmware, and returns a message if the byte ends one. Of several zeros
    /// in a row only the first ends a message.
    pub fn telemetry(&mut self, byte: u8) -> Option<Result<Telemetry, Refusal>> {
        self.message(byte, Telemetry::read)
    }

    /// Takes a byte that the program sent.
    pub fn command(&mut self, byte: u8) -> Option<Result<Command, Refusal>> {
        self.message(byte, Command::read)
    }

    fn message<T>(
        &mut self,
        byte: u8,
        read: impl FnOnce(&[u8]) -> Option<T>,
    ) -> Option<Result<T, Refusal>> {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            // A length of one beyond the buffer records that more bytes came.
            self.length = (self.length + 1).min(FRAME_BYTES_MAX + 1);
            return None;
        }
        let length = core::mem::take(&mut self.length);
        if length == 0 {
            return None;
        }
        let Some(stuffed) = self.bytes.get(..length) else {
            return Some(Err(Refusal::TooLong));
        };
        Some(unstuffed(stuffed, read))
    }
}

impl Default for Receiver {
    fn default() -> Self {
        Receiver::new()
    }
}

/// Undoes COBS and compares the CRC. `read` receives the whole message.
fn unstuffed<T>(stuffed: &[u8], read: impl FnOnce(&[u8]) -> Option<T>) -> Result<T, Refusal> {
    // The buffer has one byte more than the longest message, because a damaged frame may be that long.
    let mut message = [0; MESSAGE_BYTES_MAX + 2];
    let report = cobs::decode(stuffed, &mut message).map_err(|_| Refusal::Damaged)?;
    let message = message.get(..report.frame_size()).ok_or(Refusal::Damaged)?;
    let (body, crc) = message.split_last_chunk::<2>().ok_or(Refusal::Damaged)?;
    if crc16(body) != u16::from_le_bytes(*crc) {
        return Err(Refusal::Damaged);
    }
    read(message).ok_or(Refusal::Unknown)
}
