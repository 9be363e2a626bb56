//! The bench of the thesis: FXAS21002 and FXOS8700 on one bus, and a part for the wheel.

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::I2c;
use loop_core::{Reading, Sensors};
use sensor_drivers::{Fxas21002, Fxos8700};

use crate::wheel::WheelPart;
use crate::{Failed, kept};

/// The parts that have been started; `W` is the part of the wheel.
pub struct InertialBench<B, D, W> {
    bus: B,
    delay: D,
    gyro: Option<Fxas21002>,
    accel: Option<Fxos8700>,
    wheel: Option<W>,
    last: Reading,
    is_even: bool,
}

impl<B: I2c, D: DelayNs, W: WheelPart> InertialBench<B, D, W> {
    /// Starts the parts that answer.
    pub fn new(bus: B, delay: D) -> Self {
        let mut bench = InertialBench {
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

    /// Whether all parts have been started and none has failed since.
    pub fn is_complete(&self) -> bool {
        self.gyro.is_some() && self.accel.is_some() && self.wheel.is_some()
    }

    /// Starts the parts that are missing; takes up to 62 ms.
    pub fn begin(&mut self) {
        if self.gyro.is_none() {
            self.gyro = Fxas21002::new(&mut self.bus, &mut self.delay).ok();
        }
        if self.accel.is_none() {
            self.accel = Fxos8700::new(&mut self.bus).ok();
        }
        if self.wheel.is_none() {
            self.wheel = W::begin(&mut self.bus).ok();
        }
    }
}

impl<B: I2c, D: DelayNs, W: WheelPart> Sensors for InertialBench<B, D, W> {
    type Error = Failed;

    /// Reads gyroscope and wheel in each step, accelerometer and magnetometer in every other step. The latter two have
    /// 400 new readings per second, and their 13 bytes take a third of a step at 400 kHz.
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
