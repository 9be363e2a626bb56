//! ams AS5600, magnetic rotary encoder. Register names: data sheet v1-06.

use embedded_hal::i2c::I2c;

use crate::Error;

const ADDRESS: u8 = 0x36;
const STATUS: u8 = 0x0b;
const RAW_ANGLE: u8 = 0x0c;
/// Bits of STATUS: MD a magnet is there, ML it is too weak, MH too strong; the others are zero.
const MAGNET: u8 = 0x20;
const WRONG_MAGNET: u8 = 0x18;
const NEVER: u8 = 0xc7;
/// Number of readings between two checks of the magnet.
const CHECK_EVERY: u8 = 64;

/// The encoder.
#[derive(Debug)]
pub struct As5600 {
    since_check: u8,
}

impl As5600 {
    /// Checks that there is a magnet of the right strength. The part has no identity register; a status that an AS5600
    /// cannot have shows that another part answers.
    ///
    /// # Errors
    /// [`Error::Bus`], [`Error::WrongDevice`], [`Error::Magnet`].
    pub fn new<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>> {
        check(bus)?;
        Ok(As5600 { since_check: 0 })
    }

    /// The angle, 4096 counts per turn.
    ///
    /// # Errors
    /// [`Error::Bus`]; [`Error::Magnet`], which is noticed within 64 readings.
    pub fn read<B: I2c>(&mut self, bus: &mut B) -> Result<u16, Error<B::Error>> {
        self.since_check += 1;
        if self.since_check >= CHECK_EVERY {
            self.since_check = 0;
            check(bus)?;
        }
        let mut bytes = [0; 2];
        bus.write_read(ADDRESS, &[RAW_ANGLE], &mut bytes)?;
        Ok(u16::from_be_bytes(bytes) & 0x0fff)
    }
}

fn check<B: I2c>(bus: &mut B) -> Result<(), Error<B::Error>> {
    let mut status = [0];
    bus.write_read(ADDRESS, &[STATUS], &mut status)?;
    let [status] = status;
    if status & NEVER != 0 {
        return Err(Error::WrongDevice {
            found: u16::from(status),
            expected: u16::from(MAGNET),
        });
    }
    if status & MAGNET == 0 || status & WRONG_MAGNET != 0 {
        return Err(Error::Magnet(status));
    }
    Ok(())
}
