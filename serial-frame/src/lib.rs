//! The frames between firmware and program on the serial line. `no_std`, no heap: both ends use it.
//!
//! A frame is a little-endian message with a CRC-16 at its end. COBS removes the zero bytes from it, and one zero byte
//! ends the frame. A receiver that missed bytes, or started late, is in step again after the next zero: a damaged frame
//! fails its CRC or its length, and is counted and discarded.
//!
//! # From firmware to program: [`Telemetry`]
//! | bytes | type | field |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | status, the emitted module's `Status` |
//! | 2–3 | u16 | sequence, one more each step, also where a frame was not sent |
//! | 4–7 | u32 | time in µs, wraps |
//! | 8–25 | 9 × i16 | gyroscope, accelerometer, magnetometer x y z; −32768 in each of the last: none |
//! | 26–27 | u16 | wheel sensor |
//! | 28–29 | u16 | duty |
//! | 30–41 | 3 × i32 | angle from upright, rate, wheel speed: words of the emitted module |
//! | 42–43 | u16 | CRC |
//!
//! Where an encoder on the pivot shows the body, its count stands in the place of the gyroscope's x, as its bits; the
//! gyroscope's y and z and the accelerometer are −32768.
//!
//! # From program to firmware: [`Command`]
//! | bytes | type | field |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | task: 0 watch, 1 balance, 2 drive with the current below |
//! | 2 | u8 | wish: a task is begun once for each new number |
//! | 3 | u8 | every how many steps a frame is sent, from 1 |
//! | 4–5 | u16 | lease in ms: so long after this frame the motor is let go, unless another frame comes |
//! | 6–9 | i32 | current in µA |
//! | 10–11 | u16 | CRC |
//!
//! The CRC is CRC-16/CCITT-FALSE (catalogued as CRC-16/IBM-3740): polynomial 0x1021, begun with 0xFFFF,
//! not reflected, over all bytes before it.
#![no_std]

mod command;
mod fields;
mod receiver;
mod telemetry;

pub use command::{COMMAND_BYTES, Command, Task};
pub use receiver::{Receiver, Refusal};
pub use telemetry::{NO_FIELD, TELEMETRY_BYTES, Telemetry};

/// The version of both messages.
pub const VERSION: u8 = 1;

/// Most bytes of a message before it is stuffed.
pub const MESSAGE_BYTES_MAX: usize = TELEMETRY_BYTES;

/// Most bytes of a frame on the line: COBS adds one byte to a message of up to 254, then comes the zero.
pub const FRAME_BYTES_MAX: usize = MESSAGE_BYTES_MAX + 2;

/// CRC-16/CCITT-FALSE. Without a table: 44 bytes take a few microseconds, 512 bytes of flash would not.
pub fn crc16(bytes: &[u8]) -> u16 {
    const CRC: crc::Crc<u16, crc::NoTable> =
        crc::Crc::<u16, crc::NoTable>::new(&crc::CRC_16_IBM_3740);
    CRC.checksum(bytes)
}

/// A frame ready for the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    bytes: [u8; FRAME_BYTES_MAX],
    length: usize,
}

impl Frame {
    /// The bytes with the zero at their end.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }

    /// Puts a message, whose last two bytes are for the CRC, into a frame.
    fn of(mut message: fields::Writer) -> Frame {
        let crc = crc16(message.bytes());
        message.put(&crc.to_le_bytes());
        let mut bytes = [0; FRAME_BYTES_MAX];
        // The frame has room for the longest message; its last byte stays the zero that ends it.
        let stuffed = cobs::try_encode(message.bytes(), &mut bytes).unwrap_or(0);
        Frame {
            bytes,
            length: stuffed + 1,
        }
    }
}
