//! NXP FXOS8700CQ, accelerometer and magnetometer. Register names and values: data sheet rev. 8.

use embedded_hal::i2c::I2c;

use crate::Error;
use crate::freshness::Freshness;
use crate::registers::{axes, identify, write_all};

/// With SA1 and SA0 high, as on the Adafruit board.
const ADDRESS: u8 = 0x1f;
const STATUS: u8 = 0x00;
const WHO_AM_I: u8 = 0x0d;
const IDENTITY: u8 = 0xc7;
const XYZ_DATA_CFG: u8 = 0x0e;
const CTRL_REG1: u8 = 0x2a;
const CTRL_REG2: u8 = 0x2b;
const M_CTRL_REG1: u8 = 0x5b;
const M_CTRL_REG2: u8 = 0x5c;
/// ZYXDR of STATUS: a new reading of all axes.
const NEW_READING: u8 = 0x08;

/// The accelerometer at ±8 g and the magnetometer at ±1200 µT, each 400 readings a second.
#[derive(Debug)]
pub struct Fxos8700 {
    freshness: Freshness,
}

/// One reading of both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AccelAndField {
    /// Specific force x y z as the 16-bit word stands in the registers, 4096 to the g.
    pub accel: [i16; 3],
    /// Field x y z, counts of 0.1 µT; `None` if this reading was returned before.
    pub mag: Option<[i16; 3]>,
}

impl Fxos8700 {
    /// Compares the identity and starts the part.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::WrongDevice`].
    pub fn new<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>> {
        identify(bus, ADDRESS, WHO_AM_I, IDENTITY)?;
        let registers = [
            // Standby, because the other registers can be set only there.
            (CTRL_REG1, 0x00),
            // FS = 2: ±8 g.
            (XYZ_DATA_CFG, 0x02),
            // MODS = 2: high resolution.
            (CTRL_REG2, 0x02),
            // M_OS = 7, M_HMS = 3: both sensors.
            (M_CTRL_REG1, 0x1f),
            // HYB_AUTOINC_MODE: the field's registers follow the accelerometer's in one transfer.
            (M_CTRL_REG2, 0x20),
            // DR = 0: 400 Hz each in hybrid mode; LNOISE off, which would end at ±4 g; ACTIVE.
            (CTRL_REG1, 0x01),
        ];
        write_all(bus, ADDRESS, &registers)?;
        Ok(Fxos8700 {
            freshness: Freshness::default(),
        })
    }

    /// The latest reading.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::Stuck`].
    pub fn read<B: I2c>(&mut self, bus: &mut B) -> Result<AccelAndField, Error<B::Error>> {
        let mut bytes = [0; 13];
        bus.write_read(ADDRESS, &[STATUS], &mut bytes)?;
        let [status, x0, x1, x2, x3, x4, x5, field @ ..] = bytes;
        let is_fresh = status & NEW_READING != 0;
        self.freshness.judge(is_fresh)?;
        Ok(AccelAndField {
            accel: axes([x0, x1, x2, x3, x4, x5]),
            mag: is_fresh.then(|| axes(field)),
        })
    }
}
