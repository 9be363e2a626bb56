//! The frames between firmware and program on the serial line. `no_std`, no heap: both ends use it.
//!
//! A frame is a little-endian message with a CRC-16 at its end. COBS removes the zero bytes from it, and one zero byte
//! ends the frame. A receiver that missed bytes, or started late, finds the next frame after the next zero. A damaged
//! frame fails its CRC or its length; the receiver counts and discards it.
//!
//! # From firmware to program: [`Telemetry`]
//! | bytes | type | field |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | status, the emitted module's `Status` |
//! | 2–3 | u16 | sequence: the number of the step; steps without a frame count too |
//! | 4–7 | u32 | time in µs, wraps |
//! | 8–25 | 9 × i16 | gyroscope, accelerometer, magnetometer x y z; a magnetometer of three −32768: no reading |
//! | 26–27 | u16 | wheel sensor |
//! | 28–29 | u16 | duty |
//! | 30–41 | 3 × i32 | angle from upright, rate, wheel speed: words of the emitted module |
//! | 42–43 | u16 | CRC |
//!
//! If an encoder on the pivot measures the body's angle, its count (the 16 bits of a u16) stands in the field of the
//! gyroscope's x. The gyroscope's y and z and the accelerometer are then −32768.
//!
//! # From program to firmware: [`Command`]
//! | bytes | type | field |
//! |---|---|---|
//! | 0 | u8 | version, 1 |
//! | 1 | u8 | task: 0 watch, 1 balance, 2 drive with the current below |
//! | 2 | u8 | wish: the firmware begins the task once for each new number |
//! | 3 | u8 | number of steps from one frame to the next, at least 1 |
//! | 4–5 | u16 | lease in ms: the firmware switches the motor off when this time has passed since the last frame |
//! | 6–9 | i32 | current in µA |
//! | 10–11 | u16 | CRC |
//!
//! The CRC is CRC-16/CCITT-FALSE (catalogued as CRC-16/IBM-3740): polynomial 0x1021, initial value 0xFFFF, not
//! reflected, over all bytes before the CRC.
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

/// Largest number of bytes of a message before COBS.
pub const MESSAGE_BYTES_MAX: usize = TELEMETRY_BYTES;

/// Largest number of bytes of a frame on the line. COBS adds one byte to a message of up to 254 bytes, and a zero byte
/// ends the frame.
pub const FRAME_BYTES_MAX: usize = MESSAGE_BYTES_MAX + 2;

/// CRC-16/CCITT-FALSE, computed without a table: 44 bytes take only a few microseconds, and a table would take 512
/// bytes of flash.
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

    /// Makes a frame from a message, whose last two bytes are reserved for the CRC.
    fn of(mut message: fields::Writer) -> Frame {
        let crc = crc16(message.bytes());
        message.put(&crc.to_le_bytes());
        let mut bytes = [0; FRAME_BYTES_MAX];
        // The frame has room for the longest message. Its last byte is not written and stays the zero that ends a
        // frame.
        let stuffed = cobs::try_encode(message.bytes(), &mut bytes).unwrap_or(0);
        Frame {
            bytes,
            length: stuffed + 1,
        }
    }
}
