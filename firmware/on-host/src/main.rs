//! The firmware's loop as a program of the host: the same core, compiled with the emitted module, around a
//! bench that another program simulates. Only the board is missing.
//!
//! Each tick the other program writes to standard input, little-endian
//!
//! | type | field |
//! |---|---|
//! | u32 | time in µs |
//! | u8 | 1: the sensors answer, 0: the bus fails |
//! | 9 × i16 | gyroscope, accelerometer, magnetometer (−32768 in each: none) |
//! | u16 | wheel |
//! | u16 | the encoder on the pivot; not read by a module without one |
//! | u8, bytes | how many bytes came on the serial line, and which |
//!
//! and reads from standard output
//!
//! | type | field |
//! |---|---|
//! | u16 | duty |
//! | u8, bytes | how many bytes go to the serial line, and which |
//!
//! The program ends when its input does.

use std::convert::Infallible;
use std::io::{self, BufWriter, Read, Write};

use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use loop_core::{LoopCore, Reading, Sensors};
use serial_frame::NO_FIELD;

/// The readings that the other program states; `None` if the bus fails.
struct Told(Option<Reading>);

impl Sensors for Told {
    type Error = ();

    fn read(&mut self) -> Result<Reading, ()> {
        self.0.ok_or(())
    }
}

struct Timer(u16);

impl ErrorType for Timer {
    type Error = Infallible;
}

impl SetDutyCycle for Timer {
    fn max_duty_cycle(&self) -> u16 {
        u16::MAX
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0 = duty;
        Ok(())
    }
}

fn main() -> io::Result<()> {
    let mut input = io::stdin().lock();
    let mut output = BufWriter::new(io::stdout().lock());
    let mut core = LoopCore::new();
    let mut timer = Timer(0);
    loop {
        let mut head = [0; 28];
        match input.read_exact(&mut head) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
            other => other?,
        }
        let [t0, t1, t2, t3, answers, words @ .., count] = head;
        let now_us = u32::from_le_bytes([t0, t1, t2, t3]);
        let mut bytes = vec![0; usize::from(count)];
        input.read_exact(&mut bytes)?;
        for byte in bytes {
            core.received(byte, now_us);
        }
        let mut told = Told((answers != 0).then(|| reading(words)));
        let tick = core.tick(now_us, &mut told, &mut timer);
        output.write_all(&timer.0.to_le_bytes())?;
        let frame = tick.frame.as_ref().map_or(&[][..], |frame| frame.bytes());
        // A frame is shorter than 256 bytes.
        output.write_all(&[frame.len() as u8])?;
        output.write_all(frame)?;
        output.flush()?;
    }
}

fn reading(words: [u8; 22]) -> Reading {
    let word = |index: usize| [words[2 * index], words[2 * index + 1]];
    let axes = |first: usize| [0, 1, 2].map(|axis| i16::from_le_bytes(word(first + axis)));
    let mag = axes(6);
    Reading {
        gyro: axes(0),
        accel: axes(3),
        mag: (mag != [NO_FIELD; 3]).then_some(mag),
        body_count: u16::from_le_bytes(word(10)),
        wheel: u16::from_le_bytes(word(9)),
    }
}
