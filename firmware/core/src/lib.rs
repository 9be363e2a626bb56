//! The control loop around the emitted module, independent of any chip. A board supplies time, sensors, a timer and the
//! bytes of the serial line, and calls [`LoopCore::tick`] once in every sample time.
//!
//! ```text
//! bytes ──> LoopCore::received ──> orders ─┐
//! sensors ──> LoopCore::tick ──> Controller ──> duty ──> timer
//!                       └──> frame ──> serial line
//! ```
//!
//! # What keeps the motor still
//! - The emitted controller drives the motor only after it was armed: near upright, at rest, with sound sensors. It
//!   trips by itself.
//! - The loop calls [`Controller::fault`] after a tick that comes too late, and if a sensor or the timer fails.
//! - An order is valid only for its lease: if the line falls silent, the controller is disarmed.
//! - After a start, also one in the middle of balancing when the supply drops, an order that was under way does not arm:
//!   only one whose number differs from the first that is heard, unless that first one is [`Task::Watch`].
//! - A trip stays until an order with a new number comes. The controller is then restarted, finds its attitude again,
//!   and is armed at most once for that order.
#![no_std]

mod orders;
mod reading;
mod shape;

use embedded_hal::pwm::SetDutyCycle;
use generated::{Controller, Current, Duty, SAMPLE_TIME_US, Status, ZERO_CURRENT};
use serial_frame::{Frame, Receiver, Task, Telemetry};

pub use orders::Orders;
pub use reading::{Reading, Sensors};

/// Number of bits of the timer for which the emitted module's duties are made (`bits` of `[hardware.drive]`). A timer
/// with another range gets the same share of its range.
pub const DUTY_BITS: u32 = 16;

/// The reason why a tick failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The tick came more than half a sample time late, so that the law's sample time does not hold.
    Late,
    /// A sensor gave no reading.
    Sensor,
    /// The timer did not take the duty.
    Timer,
}

/// The result of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// The frame for the serial line, if one is due. If the line has no room, the whole frame is dropped; the receiver
    /// notices the gap in the sequence.
    pub frame: Option<Frame>,
    /// The fault of this tick, which the controller has received; `None` if there was none.
    pub fault: Option<Fault>,
}

/// The loop.
#[derive(Clone, Debug)]
pub struct LoopCore {
    controller: Controller,
    orders: Orders,
    receiver: Receiver,
    sequence: u16,
    last_tick_us: Option<u32>,
    /// The last readings of the sensors. They are sent again while a sensor fails.
    last: Reading,
    wheel_speed: shape::WheelSpeed,
}

impl LoopCore {
    /// The state at rest: the motor is not driven before a command comes.
    pub const fn new() -> LoopCore {
        LoopCore {
            controller: Controller::new(),
            orders: Orders::new(),
            receiver: Receiver::new(),
            sequence: 0,
            last_tick_us: None,
            last: Reading::NONE,
            wheel_speed: shape::WheelSpeed::new(),
        }
    }

    /// The state of the controller.
    pub fn status(&self) -> Status {
        self.controller.status()
    }

    /// Takes a byte of the serial line. Bytes that are not part of a command are ignored.
    pub fn received(&mut self, byte: u8, now_us: u32) {
        if let Some(Ok(command)) = self.receiver.command(byte) {
            self.orders.take(command, now_us);
        }
    }

    /// One step: call it every [`SAMPLE_TIME_US`]. `now_us` is a clock that may wrap.
    pub fn tick<S: Sensors, P: SetDutyCycle>(
        &mut self,
        now_us: u32,
        sensors: &mut S,
        timer: &mut P,
    ) -> Tick {
        let late = self.is_late(now_us).then_some(Fault::Late);
        let reading = sensors.read();
        let is_read = reading.is_ok();
        let fault = late.or((!is_read).then_some(Fault::Sensor));
        if let Ok(reading) = reading {
            self.wheel_speed.take(&reading);
            self.last = reading;
        }
        self.follow(now_us);
        if fault.is_some() {
            self.controller.fault();
        }
        // Without a reading the controller cannot step. After a fault no current flows anyway.
        let duty = match is_read {
            true => self.step(),
            false => Duty(ZERO_CURRENT),
        };
        let mut fault = fault;
        if timer
            .set_duty_cycle(scaled(duty, timer.max_duty_cycle()))
            .is_err()
        {
            self.controller.fault();
            fault = fault.or(Some(Fault::Timer));
        }
        let frame = self.frame(now_us, duty);
        Tick { frame, fault }
    }

    /// Whether this tick comes more than half a sample time late; the first one never does.
    fn is_late(&mut self, now_us: u32) -> bool {
        let last = self.last_tick_us.replace(now_us);
        last.is_some_and(|last| now_us.wrapping_sub(last) > SAMPLE_TIME_US + SAMPLE_TIME_US / 2)
    }

    /// Follows the orders: restarts a tripped controller for a new order, arms it for a task that needs the motor, or
    /// disarms it.
    fn follow(&mut self, now_us: u32) {
        self.orders.expire(now_us);
        if self.orders.takes_new() && is_tripped(self.controller.status()) {
            self.controller = Controller::new();
        }
        if self.orders.task() == Task::Watch {
            self.controller.disarm();
        } else if self.orders.may_arm() && self.controller.arm() {
            self.orders.armed();
        }
    }

    fn step(&mut self) -> Duty {
        let sample = shape::sample(&self.last);
        match self.orders.task() {
            Task::Drive { .. } => {
                let current = Current::from_bits(self.orders.current_word());
                self.controller.step_with_current(&sample, current)
            }
            _ => self.controller.step(&sample),
        }
    }

    /// The frame of this step, if one is due.
    fn frame(&mut self, now_us: u32, duty: Duty) -> Option<Frame> {
        let sequence = self.sequence;
        self.sequence = sequence.wrapping_add(1);
        if !self.orders.is_frame_due() {
            return None;
        }
        let [angle, rate] = shape::body_words(&self.controller);
        let [gyro, accel] = shape::inertial_words(&self.last);
        let telemetry = Telemetry {
            status: self.controller.status() as u8,
            sequence,
            time_us: now_us,
            gyro,
            accel,
            mag: self.last.mag,
            wheel: self.last.wheel,
            duty: duty.0,
            angle,
            rate,
            wheel_speed: self.wheel_speed.word(),
        };
        Some(telemetry.frame())
    }
}

impl Default for LoopCore {
    fn default() -> Self {
        LoopCore::new()
    }
}

fn is_tripped(status: Status) -> bool {
    !matches!(status, Status::NotAligned | Status::Ready | Status::Running)
}

/// The duty for a timer whose largest duty is `most`, with the same share of the range.
fn scaled(duty: Duty, most: u16) -> u16 {
    let share = (u32::from(duty.0) * (u32::from(most) + 1)) >> DUTY_BITS;
    share.min(u32::from(most)) as u16
}
