//! Faults of sensors, bus and firmware, applied to an emitted controller.

use super::controller::{RawController, RawSample};
use crate::law::LawFailure;

/// A fault of the samples or of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The gyroscope's registers are no longer updated.
    GyroscopeFrozen,
    /// The accelerometer's registers are no longer updated.
    AccelerometerFrozen,
    /// The converter of the wheel's speed repeats its last count.
    WheelFrozen,
    /// Every sensor repeats its last reading: the bus gives old data.
    AllFrozen,
    /// An axis of the gyroscope stays at the end of its range.
    GyroscopeClipped,
    /// An axis of the accelerometer stays at the end of its range.
    AccelerometerClipped,
    /// The accelerometer reads zero on every axis: its supply or bus has failed.
    AccelerometerDead,
    /// The converter of the wheel's speed stays at the lower end of its range.
    WheelLow,
    /// The converter of the wheel's speed stays at the upper end of its range.
    WheelHigh,
    /// Every register reads zero: the bus does not answer.
    BusDead,
    /// The firmware misses a tick and reports it.
    MissedTick,
    /// The gyroscope's axis along the pivot reads with the wrong sign.
    GyroscopeReversed,
    /// The encoder on the pivot repeats its last count.
    BodyFrozen,
    /// The count of the encoder on the pivot is off by an eighth of its wrap.
    BodyJump,
    /// The encoder on the pivot counts backwards from its count upright.
    BodyReversed,
}

impl Fault {
    /// The faults of a bench with an encoder on the pivot.
    pub const WITH_BODY_ENCODER: [Fault; 9] = [
        Fault::BodyFrozen,
        Fault::BodyJump,
        Fault::BodyReversed,
        Fault::WheelFrozen,
        Fault::AllFrozen,
        Fault::WheelLow,
        Fault::WheelHigh,
        Fault::BusDead,
        Fault::MissedTick,
    ];

    /// The faults of a bench with gyroscope and accelerometer.
    pub const ALL: [Fault; 12] = [
        Fault::GyroscopeFrozen,
        Fault::AccelerometerFrozen,
        Fault::WheelFrozen,
        Fault::AllFrozen,
        Fault::GyroscopeClipped,
        Fault::AccelerometerClipped,
        Fault::AccelerometerDead,
        Fault::WheelLow,
        Fault::WheelHigh,
        Fault::BusDead,
        Fault::MissedTick,
        Fault::GyroscopeReversed,
    ];
}

/// Registers that read zero.
const NOTHING_READ: RawSample = RawSample {
    body: 0,
    gyro: [0; 3],
    accel: [0; 3],
    mag: None,
    wheel: 0,
};

/// A controller whose samples are faulty during some of its steps, with the record of its outputs.
#[derive(Clone, Debug)]
pub struct Faulty<C> {
    /// The controller.
    pub controller: C,
    /// The fault.
    pub fault: Fault,
    /// The step of the controller at which the fault begins, counted from its reset.
    pub from_step: usize,
    /// The first step after the fault; `None` if the fault does not end.
    pub until_step: Option<usize>,
    /// Counts at the ends of the converter's range.
    pub wheel_ends: [i32; 2],
    /// Count upright and wrap of the encoder on the pivot.
    pub body_counts: [u16; 2],
    steps: usize,
    last: Option<RawSample>,
    duties: Vec<u16>,
    ends: Vec<u8>,
}

impl<C: RawController> Faulty<C> {
    /// `controller` with `fault` from its step `from_step` on.
    pub fn new(controller: C, fault: Fault, from_step: usize, wheel_ends: [i32; 2]) -> Faulty<C> {
        Faulty {
            controller,
            fault,
            from_step,
            until_step: None,
            wheel_ends,
            body_counts: [2048, 4096],
            steps: 0,
            last: None,
            duties: Vec::new(),
            ends: Vec::new(),
        }
    }

    /// The duties of all steps since the fault began, in counts.
    pub fn duties(&self) -> &[u16] {
        &self.duties
    }

    /// The status after each of these steps.
    pub fn statuses(&self) -> &[u8] {
        &self.ends
    }

    fn damaged(&self, sample: &RawSample) -> RawSample {
        let mut damaged = *sample;
        // A sensor that fails before its first reading repeats zeros.
        let last = self.last.unwrap_or(NOTHING_READ);
        let [zero, wrap] = self.body_counts.map(i32::from);
        let body = |count: i32| count.rem_euclid(wrap.max(1)) as u16;
        match self.fault {
            Fault::GyroscopeFrozen => damaged.gyro = last.gyro,
            Fault::AccelerometerFrozen => damaged.accel = last.accel,
            Fault::WheelFrozen => damaged.wheel = last.wheel,
            Fault::AllFrozen => damaged = last,
            Fault::GyroscopeClipped => damaged.gyro[2] = i16::MAX,
            Fault::AccelerometerClipped => damaged.accel[1] = i16::MIN,
            Fault::AccelerometerDead => damaged.accel = [0; 3],
            Fault::WheelLow => damaged.wheel = self.wheel_ends[0],
            Fault::WheelHigh => damaged.wheel = self.wheel_ends[1],
            Fault::BusDead => damaged = NOTHING_READ,
            Fault::MissedTick => {}
            Fault::BodyFrozen => damaged.body = last.body,
            Fault::BodyJump => damaged.body = body(i32::from(sample.body) + wrap / 8),
            Fault::BodyReversed => damaged.body = body(2 * zero - i32::from(sample.body)),
            Fault::GyroscopeReversed => {
                damaged.gyro[2] = sample.gyro[2].checked_neg().unwrap_or(i16::MAX);
            }
        }
        damaged
    }
}

impl<C: RawController> RawController for Faulty<C> {
    fn reset(&mut self) {
        self.controller.reset();
        self.steps = 0;
        self.last = None;
        self.duties.clear();
        self.ends.clear();
    }

    fn arm(&mut self) -> Result<bool, LawFailure> {
        self.controller.arm()
    }

    fn fault(&mut self) -> Result<(), LawFailure> {
        self.controller.fault()
    }

    fn status(&self) -> Result<u8, LawFailure> {
        self.controller.status()
    }

    fn step(&mut self, sample: &RawSample) -> Result<u16, LawFailure> {
        let step = self.steps;
        self.steps += 1;
        if step < self.from_step {
            self.last = Some(*sample);
            return self.controller.step(sample);
        }
        let is_faulty = self.until_step.is_none_or(|until| step < until);
        if is_faulty && step == self.from_step && self.fault == Fault::MissedTick {
            self.controller.fault()?;
        }
        let duty = if is_faulty {
            self.controller.step(&self.damaged(sample))?
        } else {
            self.controller.step(sample)?
        };
        self.duties.push(duty);
        self.ends.push(self.controller.status()?);
        Ok(duty)
    }

    fn angle_rad(&self) -> Result<f64, LawFailure> {
        self.controller.angle_rad()
    }
}
