//! TI ADS1015, analogue-to-digital converter. Register names and values: SBAS473E.

use embedded_hal::i2c::I2c;

use crate::Error;

/// With ADDR at ground.
const ADDRESS: u8 = 0x48;
const CONVERSION: u8 = 0x00;
const CONFIG: u8 = 0x01;
/// Input 0 against ground, ±4.096 V (2 mV per count), continuous, 3300 a second, no comparator.
const SETTING: u16 = 0x42c3;
/// The bit OS of CONFIG says whether a conversion is running. It is not part of the setting.
const SETTING_MASK: u16 = 0x7fff;
/// Number of readings between two comparisons of the setting. A part that was reset by a dip of its supply has lost the
/// setting and does not convert any more.
const CHECK_EVERY: u8 = 64;

/// The converter on its first input.
#[derive(Debug)]
pub struct Ads1015 {
    since_check: u8,
}

impl Ads1015 {
    /// Starts the part and reads its setting back, because the part has no identity register.
    ///
    /// # Errors
    /// [`Error::Bus`]; [`Error::WrongDevice`] if another part is at the address.
    pub fn new<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>> {
        let [high, low] = SETTING.to_be_bytes();
        bus.write(ADDRESS, &[CONFIG, high, low])?;
        let found = setting(bus)?;
        if found == SETTING {
            Ok(Ads1015 { since_check: 0 })
        } else {
            Err(Error::WrongDevice {
                found,
                expected: SETTING,
            })
        }
    }

    /// The latest reading in counts of 2 mV. A voltage below ground reads as 0.
    ///
    /// # Errors
    /// [`Error::Bus`]; [`Error::Stuck`] if the part has lost its setting, which is noticed within 64 readings.
    pub fn read<B: I2c>(&mut self, bus: &mut B) -> Result<u16, Error<B::Error>> {
        self.since_check += 1;
        if self.since_check >= CHECK_EVERY {
            self.since_check = 0;
            if setting(bus)? != SETTING {
                return Err(Error::Stuck);
            }
        }
        let mut bytes = [0; 2];
        bus.write_read(ADDRESS, &[CONVERSION], &mut bytes)?;
        // Twelve bits at the upper end of the word, signed.
        let count = i16::from_be_bytes(bytes) >> 4;
        Ok(count.max(0) as u16)
    }
}

fn setting<B: I2c>(bus: &mut B) -> Result<u16, Error<B::Error>> {
    let mut bytes = [0; 2];
    bus.write_read(ADDRESS, &[CONFIG], &mut bytes)?;
    Ok(u16::from_be_bytes(bytes) & SETTING_MASK)
}
