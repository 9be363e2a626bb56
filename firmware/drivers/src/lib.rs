//! Drivers of the bench's sensors on embedded-hal 1.0. They return the raw counts that the emitted module takes, with
//! the setting for which the presets of `[hardware]` hold. `no_std`, no heap.
//!
//! | part | driver | gives | setting |
//! |---|---|---|---|
//! | FXOS8700 | [`Fxos8700`] | accelerometer, magnetometer | ±8 g, ±1200 µT, 400 Hz hybrid |
//! | FXAS21002 | [`Fxas21002`] | gyroscope | ±2000 °/s, 800 Hz |
//! | MPU-6050 | [`Mpu6050`] | gyroscope, accelerometer | ±2000 °/s, ±8 g, 1 kHz |
//! | ADS1015 | [`Ads1015`] | voltage of the wheel's speed | input 0, ±4.096 V, 3300 a second |
//! | AS5600 | [`As5600`] | angle of a magnet | RAW ANGLE, 12 bits |
//!
//! `new` starts a part: it compares the identity and writes the registers. `read` is one transfer on the bus. A part
//! that gives no new reading for [`STALE_MAX`] calls is [`Error::Stuck`], because its unchanged words would look like
//! those of a body at rest.
#![no_std]

mod ads1015;
mod as5600;
mod freshness;
mod fxas21002;
mod fxos8700;
mod mpu6050;
mod registers;

pub use ads1015::Ads1015;
pub use as5600::As5600;
pub use freshness::STALE_MAX;
pub use fxas21002::Fxas21002;
pub use fxos8700::{AccelAndField, Fxos8700};
pub use mpu6050::{GyroAndAccel, Mpu6050};

/// The reason why there is no reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Error<E> {
    /// The bus failed: no part answers at the address, or a line hangs.
    Bus(E),
    /// Another part answers.
    WrongDevice {
        /// The content of its identity register.
        found: u16,
        /// The identity of the part that this driver is for.
        expected: u16,
    },
    /// The part answers but has had no new reading for too long.
    Stuck,
    /// The encoder sees no magnet, or one that is too weak or too strong; its status register.
    Magnet(u8),
}

impl<E> From<E> for Error<E> {
    fn from(error: E) -> Self {
        Error::Bus(error)
    }
}
