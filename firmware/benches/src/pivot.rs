//! A bench with an encoder on the pivot: AS5600, and a part for the wheel.
//!
//! An AS5600 that stands still cannot be told from a body at rest by its counts: the emitted module notices it by the
//! current that should have moved the body. A magnet that is gone or wrong the part itself tells.

use embedded_hal::i2c::I2c;
use loop_core::{Reading, Sensors};
use sensor_drivers::As5600;

use crate::wheel::WheelPart;
use crate::{Failed, kept};

/// The parts that were begun; `W` is that of the wheel.
pub struct PivotBench<B, W> {
    bus: B,
    body: Option<As5600>,
    wheel: Option<W>,
}

impl<B: I2c, W: WheelPart> PivotBench<B, W> {
    /// Begins the parts that answer.
    pub fn new(bus: B) -> Self {
        let mut bench = PivotBench {
            bus,
            body: None,
            wheel: None,
        };
        bench.begin();
        bench
    }

    /// Whether all parts were begun and none has failed since.
    pub fn is_complete(&self) -> bool {
        self.body.is_some() && self.wheel.is_some()
    }

    /// Begins the parts that are missing; takes less than 1 ms.
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

    /// Both parts in each step: some 120 µs each at 400 kHz, and as much again in one of 64 for the magnet.
    fn read(&mut self) -> Result<Reading, Failed> {
        let bus = &mut self.bus;
        Ok(Reading {
            body_count: kept(&mut self.body, |part| part.read(bus))?,
            wheel: kept(&mut self.wheel, |part| part.read(bus))?,
            ..Reading::NONE
        })
    }
}
