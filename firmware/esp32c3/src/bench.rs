//! The sensors of this bench: FXAS21002, FXOS8700 and ADS1015 on one bus, as in the thesis. For other
//! parts this file is the one to change; `[hardware]` in bench.toml must say the same.

use embedded_hal::i2c::I2c;
use esp_hal::delay::Delay;
use loop_core::{Reading, Sensors};
use sensor_drivers::{Ads1015, Fxas21002, Fxos8700};

/// The parts that were begun.
pub struct Bench<B> {
    bus: B,
    delay: Delay,
    gyro: Option<Fxas21002>,
    accel: Option<Fxos8700>,
    wheel: Option<Ads1015>,
    last: Reading,
    is_even: bool,
}

/// A part is missing, or failed just now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

impl<B: I2c> Bench<B> {
    /// Begins the parts that answer.
    pub fn new(bus: B, delay: Delay) -> Self {
        let mut bench = Bench {
            bus,
            delay,
            gyro: None,
            accel: None,
            wheel: None,
            last: Reading::NONE,
            is_even: false,
        };
        bench.begin();
        bench
    }

    /// Whether all parts were begun and none has failed since.
    pub fn is_complete(&self) -> bool {
        self.gyro.is_some() && self.accel.is_some() && self.wheel.is_some()
    }

    /// Begins the parts that are missing; takes up to 62 ms.
    pub fn begin(&mut self) {
        if self.gyro.is_none() {
            self.gyro = Fxas21002::new(&mut self.bus, &mut self.delay).ok();
        }
        if self.accel.is_none() {
            self.accel = Fxos8700::new(&mut self.bus).ok();
        }
        if self.wheel.is_none() {
            self.wheel = Ads1015::new(&mut self.bus).ok();
        }
    }
}

impl<B: I2c> Sensors for Bench<B> {
    type Error = Failed;

    /// Gyroscope and wheel in each step, accelerometer and field in every other: they have 400 new readings a
    /// second, and 13 bytes at 400 kHz take a third of a step.
    fn read(&mut self) -> Result<Reading, Failed> {
        let bus = &mut self.bus;
        self.last.gyro = kept(&mut self.gyro, |part| part.read(bus))?;
        self.last.wheel = kept(&mut self.wheel, |part| part.read(bus))?;
        self.last.mag = None;
        self.is_even = !self.is_even;
        if self.is_even {
            let both = kept(&mut self.accel, |part| part.read(bus))?;
            self.last.accel = both.accel;
            self.last.mag = both.mag;
        }
        Ok(self.last)
    }
}

/// Reads a part. A part that fails counts as missing until it is started again.
fn kept<P, T, E>(
    part: &mut Option<P>,
    read: impl FnOnce(&mut P) -> Result<T, E>,
) -> Result<T, Failed> {
    match part.as_mut().map(read) {
        Some(Ok(value)) => Ok(value),
        _ => {
            *part = None;
            Err(Failed)
        }
    }
}
