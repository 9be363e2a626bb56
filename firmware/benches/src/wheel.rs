//! The sensor of the wheel.

use embedded_hal::i2c::I2c;
use sensor_drivers::{Ads1015, As5600, Error};

/// A part that measures the wheel's speed or angle.
pub trait WheelPart: Sized {
    /// Starts the part.
    ///
    /// # Errors
    /// If no such part answers.
    fn begin<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>>;

    /// The latest reading: counts of a converter or an encoder, or a driver's signed speed as its bits.
    ///
    /// # Errors
    /// If the part has failed.
    fn read<B: I2c>(&mut self, bus: &mut B) -> Result<u16, Error<B::Error>>;
}

/// A converter on the drive's speed output: `kind = "converter"`.
impl WheelPart for Ads1015 {
    fn begin<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>> {
        Ads1015::new(bus)
    }

    fn read<B: I2c>(&mut self, bus: &mut B) -> Result<u16, Error<B::Error>> {
        Ads1015::read(self, bus)
    }
}

/// An encoder on the wheel's shaft: `kind = "encoder"`. Every AS5600 has the same address, so that two of them cannot
/// share a bus.
impl WheelPart for As5600 {
    fn begin<B: I2c>(bus: &mut B) -> Result<Self, Error<B::Error>> {
        As5600::new(bus)
    }

    fn read<B: I2c>(&mut self, bus: &mut B) -> Result<u16, Error<B::Error>> {
        As5600::read(self, bus)
    }
}

/// Your own sensor, such as a driver of the motor that sends its speed (`kind = "driver"`). Write its reading here.
/// Until then the reading fails, and the motor is not driven.
#[derive(Debug)]
pub struct YourWheel;

impl WheelPart for YourWheel {
    fn begin<B: I2c>(_bus: &mut B) -> Result<Self, Error<B::Error>> {
        Ok(YourWheel)
    }

    fn read<B: I2c>(&mut self, _bus: &mut B) -> Result<u16, Error<B::Error>> {
        // YOUR READING: `Ok(speed.cast_unsigned())` with the i16 that the driver sent.
        Err(Error::Stuck)
    }
}
