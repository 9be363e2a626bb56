//! NXP FXAS21002C, gyroscope. Register names and values: data sheet rev. 2.1.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;

use crate::Error;
use crate::freshness::Freshness;
use crate::registers::{axes, identify, write_all};

/// With SA0 high, as on the Adafruit board; 0x20 with SA0 low.
const ADDRESS: u8 = 0x21;
const STATUS: u8 = 0x00;
const WHO_AM_I: u8 = 0x0c;
const IDENTITY: u8 = 0xd7;
const CTRL_REG0: u8 = 0x0d;
const CTRL_REG1: u8 = 0x13;
/// ZYXDR of STATUS: a new reading of all axes.
const NEW_READING: u8 = 0x08;
/// From standby to active: 60 ms and one sample.
const START_MS: u32 = 62;

/// The gyroscope at ±2000 °/s, 800 readings a second.
#[derive(Debug)]
pub struct Fxas21002 {
    freshness: Freshness,
}

impl Fxas21002 {
    /// Compares the identity and starts the part.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::WrongDevice`].
    pub fn new<B: I2c>(bus: &mut B, delay: &mut impl DelayNs) -> Result<Self, Error<B::Error>> {
        identify(bus, ADDRESS, WHO_AM_I, IDENTITY)?;
        let registers = [
            // Standby, because the range can be set only there.
            (CTRL_REG1, 0x00),
            // FS = 0: ±2000 °/s, 62.5 m°/s per count; low-pass filter at its widest.
            (CTRL_REG0, 0x00),
            // DR = 0: 800 Hz; ACTIVE.
            (CTRL_REG1, 0x02),
        ];
        write_all(bus, ADDRESS, &registers)?;
        delay.delay_ms(START_MS);
        Ok(Fxas21002 {
            freshness: Freshness::default(),
        })
    }

    /// The latest reading x y z, counts of 62.5 m°/s.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::Stuck`].
    pub fn read<B: I2c>(&mut self, bus: &mut B) -> Result<[i16; 3], Error<B::Error>> {
        let mut bytes = [0; 7];
        bus.write_read(ADDRESS, &[STATUS], &mut bytes)?;
        let [status, reading @ ..] = bytes;
        self.freshness.judge(status & NEW_READING != 0)?;
        Ok(axes(reading))
    }
}
