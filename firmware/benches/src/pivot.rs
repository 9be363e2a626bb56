//! A bench with an encoder on the pivot: AS5600, and a part for the wheel.
//!
//! The counts of an AS5600 that is stuck are those of a body at rest. The emitted module notices a stuck encoder by a
//! current that should have moved the body. The part itself reports a magnet that is missing, too weak or too strong.

use embedded_hal::i2c::I2c;
use loop_core::{Reading, Sensors};
use sensor_drivers::As5600;

use crate::wheel::WheelPart;
use crate::{Failed, kept};

/// The parts that have been started; `W` is the part of the wheel.
pub struct PivotBench<B, W> {
    bus: B,
    body: Option<As5600>,
    wheel: Option<W>,
}

impl<B: I2c, W: WheelPart> PivotBench<B, W> {
    /// Starts the parts that answer.
    pub fn new(bus: B) -> Self {
        let mut bench = PivotBench {
            bus,
            body: None,
            wheel: None,
        };
        bench.begin();
        bench
    }

    /// Whether all parts have been started and none has failed since.
    pub fn is_complete(&self) -> bool {
        self.body.is_some() && self.wheel.is_some()
    }

    /// Starts the parts that are missing; takes less than 1 ms.
    pub fn begin(&mut self) {
        if self.body.is_none() {
            self.body = As5600::new(&mut self.bus).ok();
        }
        if self.wheel.is_none() {
            self.wheel = W::begin(&mut self.bus).ok();
        }
    }
}

impl<B: I2c, W: WheelPart> Sensors for PivotBench<B, W> {
    type Error = Failed;

    /// Reads both parts in each step: about 120 µs each at 400 kHz. In one of 64 steps, the check of the magnet takes
    /// as long again.
    fn read(&mut self) -> Result<Reading, Failed> {
        let bus = &mut self.bus;
        Ok(Reading {
            body_count: kept(&mut self.body, |part| part.read(bus))?,
            wheel: kept(&mut self.wheel, |part| part.read(bus))?,
            ..Reading::NONE
        })
    }
}
