//! One step from raw counts to the drive's duty, under supervision.

#[cfg(not(body_encoder))]
use super::attitude::Attitude;
#[cfg(not(body_encoder))]
use super::bias_observer::{advanced, estimated_bias, waiting};
#[cfg(not(body_encoder))]
use super::calibration::is_saturated;
#[cfg(body_encoder)]
use super::body::{body_angle, body_rate};
#[cfg(wheel_encoder)]
use super::constants::WHEEL_ENCODER;
#[cfg(body_encoder)]
use super::constants::{BODY_ENCODER, HOLDING_LINE};
#[cfg(all(not(body_encoder), not(voltage_drive)))]
use super::constants::{BIAS_OBSERVER, DUTY_LINE, LIMITS, WHEEL_SPEED_LINE, ZERO_CURRENT};
#[cfg(all(not(body_encoder), voltage_drive))]
use super::constants::{BIAS_OBSERVER, DUTY_PLANE, LIMITS, WHEEL_SPEED_LINE, ZERO_CURRENT};
#[cfg(all(body_encoder, not(voltage_drive)))]
use super::constants::{DUTY_LINE, LIMITS, WHEEL_SPEED_LINE, ZERO_CURRENT};
#[cfg(all(body_encoder, voltage_drive))]
use super::constants::{DUTY_PLANE, LIMITS, WHEEL_SPEED_LINE, ZERO_CURRENT};
#[cfg(not(body_encoder))]
use super::control::{Angle, CURRENT_LIMIT, Current, WheelSpeed, control};
#[cfg(body_encoder)]
use super::control::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed, control};
#[cfg(any(body_encoder, wheel_encoder))]
use super::encoder::Encoder;
use super::line::on_line;
#[cfg(voltage_drive)]
use super::plane::on_plane;
use super::product::clamp;
#[cfg(not(body_encoder))]
use super::supervisor::{
    Counters, EMPTY_WINDOW, NOTHING_COUNTED, Status, Window, counted, gathered, judged, may_arm,
    observed,
};
#[cfg(body_encoder)]
use super::supervisor::{
    Counters, NOTHING_COUNTED, Shown, Status, counted, judged, may_arm, observed,
};

/// The readings of the sensors at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Gyroscope, raw counts.
    #[cfg(not(body_encoder))]
    pub gyro: [i16; 3],
    /// Accelerometer, raw counts.
    #[cfg(not(body_encoder))]
    pub accel: [i16; 3],
    /// Magnetometer, raw counts, if there is a new reading. The controller does not use it: a
    /// magnetometer shows the heading, not the angle about the pivot.
    #[cfg(not(body_encoder))]
    pub mag: Option<[i16; 3]>,
    /// The count of the encoder on the pivot.
    #[cfg(body_encoder)]
    pub body_count: u16,
    /// Raw counts of the converter that reads the drive's speed output.
    #[cfg(wheel_converter)]
    pub wheel_adc: u16,
    /// The wheel's speed, in the driver's own units, as the motor's driver sends it.
    #[cfg(wheel_driver)]
    pub wheel_speed: i16,
    /// The count of the wheel's encoder.
    #[cfg(wheel_encoder)]
    pub wheel_count: u16,
}

/// Duty of the timer whose signal the drive reads, in counts of the timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duty(pub u16);

/// What the step has derived from one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    /// Whether the motor is to be driven.
    is_driven: bool,
    /// Word of the body's angle. It takes an arc tangent, so that it is computed once a step.
    #[cfg(not(body_encoder))]
    angle: i32,
}

/// The whole controller: call [`Controller::step`] once every sample time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Controller {
    #[cfg(not(body_encoder))]
    attitude: Attitude,
    #[cfg(body_encoder)]
    body: Encoder,
    #[cfg(wheel_encoder)]
    wheel: Encoder,
    status: Status,
    #[cfg(not(body_encoder))]
    is_aligned: bool,
    #[cfg(not(body_encoder))]
    window: Window,
    counters: Counters,
    #[cfg(not(body_encoder))]
    bias_state: i32,
}

impl Controller {
    /// A controller without an attitude. A window of quiet samples sets the attitude.
    #[cfg(not(body_encoder))]
    pub const fn new() -> Self {
        Controller {
            attitude: Attitude::new(),
            #[cfg(wheel_encoder)]
            wheel: Encoder::new(),
            status: Status::NotAligned,
            is_aligned: false,
            window: EMPTY_WINDOW,
            counters: NOTHING_COUNTED,
            bias_state: 0,
        }
    }

    /// A controller before the first encoder count.
    #[cfg(body_encoder)]
    pub const fn new() -> Self {
        Controller {
            body: Encoder::new(),
            #[cfg(wheel_encoder)]
            wheel: Encoder::new(),
            status: Status::NotAligned,
            counters: NOTHING_COUNTED,
        }
    }

    /// What the controller does, or why the motor gets no current.
    pub fn status(&self) -> Status {
        self.status
    }

    /// Arms the controller: from the next step on the motor is driven. Needs a known attitude, a body
    /// near upright and nearly at rest, and no sensor at fault; otherwise nothing changes. Returns
    /// whether the motor is driven.
    #[cfg(not(body_encoder))]
    pub fn arm(&mut self) -> bool {
        if self.status == Status::Running {
            return true;
        }
        let angle = self.attitude.angle().to_bits();
        let rate = self.attitude.rate().to_bits();
        if self.is_aligned && may_arm(&self.counters, angle, rate, &LIMITS) {
            self.counters.saturated = 0;
            self.status = Status::Running;
            true
        } else {
            false
        }
    }

    /// Arms the controller: from the next step on the motor is driven. The body must have been near upright and nearly
    /// at rest for long enough, and the wheel's speed be known; otherwise nothing changes. Returns whether the motor is
    /// driven.
    #[cfg(body_encoder)]
    pub fn arm(&mut self) -> bool {
        if self.status == Status::Running {
            return true;
        }
        if may_arm(&self.counters, &LIMITS) {
            self.counters.saturated = 0;
            self.status = Status::Running;
            true
        } else {
            false
        }
    }

    /// Ends driving: from the next step on the current is zero. The body is still followed, and the status of a trip
    /// stays.
    #[cfg(body_encoder)]
    pub fn disarm(&mut self) {
        if self.status == Status::Running {
            self.status = Status::Ready;
        }
    }

    /// Ends driving: from the next step on the current is zero. The attitude is still followed, and
    /// the status of a trip stays.
    #[cfg(not(body_encoder))]
    pub fn disarm(&mut self) {
        if self.status == Status::Running {
            self.status = Status::Ready;
        }
    }

    /// Reports a missed tick or a bus error: from the next step on the current is zero, and the
    /// body has to come to rest again before the controller can be armed.
    #[cfg(body_encoder)]
    pub fn fault(&mut self) {
        self.trip(Status::TrippedFault);
    }

    /// Reports a missed tick or a bus error: from the next step on the current is zero, and the
    /// attitude has to be found again before the controller can be armed.
    #[cfg(not(body_encoder))]
    pub fn fault(&mut self) {
        self.trip(Status::TrippedFault);
    }

    /// The attitude filter.
    #[cfg(not(body_encoder))]
    pub fn attitude(&self) -> &Attitude {
        &self.attitude
    }

    /// The body's angle from upright, from its last count.
    #[cfg(body_encoder)]
    pub fn angle(&self) -> Angle {
        body_angle(self.body.count())
    }

    /// The body's rate, from the turn over the encoder's window: the rate of half a window ago.
    #[cfg(body_encoder)]
    pub fn rate(&self) -> Rate {
        body_rate(self.body.turned(&BODY_ENCODER))
    }

    /// Takes one sample and returns the duty. Unless the controller runs, it is the duty of zero
    /// current.
    pub fn step(&mut self, sample: &Sample) -> Duty {
        #[cfg(wheel_converter)]
        let speed = wheel_speed(sample.wheel_adc);
        #[cfg(wheel_driver)]
        let speed = wheel_speed(sample.wheel_speed);
        #[cfg(wheel_encoder)]
        self.wheel.update(sample.wheel_count, &WHEEL_ENCODER);
        #[cfg(wheel_encoder)]
        let speed = wheel_speed(self.wheel.turned(&WHEEL_ENCODER));
        #[cfg(body_encoder)]
        let seen = self.seen(sample);
        #[cfg(body_encoder)]
        if seen.is_driven {
            let current = control(self.angle(), self.rate(), speed);
            #[cfg(not(voltage_drive))]
            self.sent(current)
            #[cfg(voltage_drive)]
            self.sent(current, speed)
        } else {
            Duty(ZERO_CURRENT)
        }
        #[cfg(not(body_encoder))]
        let seen = self.seen(sample, speed);
        #[cfg(not(body_encoder))]
        if seen.is_driven {
            let angle = seen.angle;
            let rate = self.attitude.rate();
            let states = [angle, rate.to_bits(), speed.to_bits()];
            let bias = estimated_bias(self.bias_state, states, &BIAS_OBSERVER);
            let current = control(Angle::from_bits(angle - bias), rate, speed);
            self.bias_state = advanced(self.bias_state, states, current.to_bits(), &BIAS_OBSERVER);
            #[cfg(not(voltage_drive))]
            self.sent(current)
            #[cfg(voltage_drive)]
            self.sent(current, speed)
        } else {
            Duty(ZERO_CURRENT)
        }
    }

    /// As [`Controller::step`], with `current` in place of the control law's, clamped to its limit.
    pub fn step_with_current(&mut self, sample: &Sample, current: Current) -> Duty {
        #[cfg(all(wheel_converter, any(voltage_drive, not(body_encoder))))]
        let speed = wheel_speed(sample.wheel_adc);
        #[cfg(all(wheel_driver, any(voltage_drive, not(body_encoder))))]
        let speed = wheel_speed(sample.wheel_speed);
        #[cfg(wheel_encoder)]
        self.wheel.update(sample.wheel_count, &WHEEL_ENCODER);
        #[cfg(all(wheel_encoder, any(voltage_drive, not(body_encoder))))]
        let speed = wheel_speed(self.wheel.turned(&WHEEL_ENCODER));
        #[cfg(not(body_encoder))]
        let seen = self.seen(sample, speed);
        #[cfg(body_encoder)]
        let seen = self.seen(sample);
        if seen.is_driven {
            let limit = CURRENT_LIMIT.to_bits();
            #[cfg(not(voltage_drive))]
            self.sent(Current::from_bits(clamp(current.to_bits(), -limit, limit)))
            #[cfg(voltage_drive)]
            let current = Current::from_bits(clamp(current.to_bits(), -limit, limit));
            #[cfg(voltage_drive)]
            self.sent(current, speed)
        } else {
            Duty(ZERO_CURRENT)
        }
    }

    /// Takes a sample: updates the encoders and the counters of the conditions.
    #[cfg(body_encoder)]
    fn seen(&mut self, sample: &Sample) -> Seen {
        let before = self.body.count();
        self.body.update(sample.body_count, &BODY_ENCODER);
        let angle = self.angle().to_bits();
        let shown = Shown {
            is_running: self.status == Status::Running,
            angle,
            rate: self.rate().to_bits(),
            is_same: self.body.count() == before,
            held: on_line(angle, &HOLDING_LINE),
            #[cfg(wheel_converter)]
            wheel: sample.wheel_adc as i32,
            #[cfg(wheel_driver)]
            wheel: sample.wheel_speed as i32,
            #[cfg(wheel_encoder)]
            wheel: self.wheel.turned(&WHEEL_ENCODER),
        };
        self.counters = observed(&self.counters, &shown, &LIMITS);
        // A count that jumped further than any motion: the encoder, its magnet or the bus has failed.
        #[cfg(wheel_encoder)]
        let has_jumped = self.body.has_jumped() || self.wheel.has_jumped();
        #[cfg(not(wheel_encoder))]
        let has_jumped = self.body.has_jumped();
        let judgement = if has_jumped {
            Status::TrippedFault
        } else {
            judged(&self.counters, angle, &LIMITS)
        };
        if self.status == Status::Running && judgement == Status::Running {
            return Seen { is_driven: true };
        }
        if self.status == Status::Running {
            self.trip(judgement);
        } else if self.status == Status::NotAligned && self.counters.still >= LIMITS.still_steps {
            self.status = Status::Ready;
        }
        if has_jumped {
            self.fault();
        }
        self.counters.current = 0;
        Seen { is_driven: false }
    }

    /// Takes a sample: updates the attitude, the counters and the window.
    #[cfg(not(body_encoder))]
    fn seen(&mut self, sample: &Sample, speed: WheelSpeed) -> Seen {
        // A reading at the end of the range says nothing of the rate: the last one stands in for the few
        // steps until that trips. Integrated as it is, it would turn the attitude by degrees a step.
        let gyro = if is_saturated(sample.gyro, LIMITS.gyro_clip) {
            self.counters.gyro
        } else {
            sample.gyro
        };
        // The pivot's angle comes from the vertical alone, to which a magnetic field, of a motor say,
        // has nothing to add: the compass is left out.
        self.attitude.update_imu(gyro, sample.accel);
        self.counters = observed(
            &self.counters,
            gyro,
            self.attitude.is_clipped(sample.gyro, sample.accel),
            self.attitude.shows_gravity(sample.accel),
            #[cfg(wheel_converter)]
            sample.wheel_adc as i32,
            #[cfg(wheel_driver)]
            sample.wheel_speed as i32,
            #[cfg(wheel_encoder)]
            self.wheel.turned(&WHEEL_ENCODER),
            &LIMITS,
        );
        let angle = self.attitude.angle().to_bits();
        let judgement = judged(&self.counters, angle, &LIMITS);
        // A count that jumped further than any motion: the encoder, its magnet or the bus has failed.
        #[cfg(wheel_encoder)]
        let has_jumped = self.wheel.has_jumped();
        #[cfg(wheel_encoder)]
        let judgement = if has_jumped {
            Status::TrippedFault
        } else {
            judgement
        };
        if self.status == Status::Running && judgement == Status::Running {
            return Seen {
                is_driven: true,
                angle,
            };
        }
        if self.status == Status::Running {
            self.trip(judgement);
        } else if !self.is_aligned {
            self.align(sample);
        }
        #[cfg(wheel_encoder)]
        if has_jumped {
            self.fault();
        }
        let states = [angle, self.attitude.rate().to_bits(), speed.to_bits()];
        self.bias_state = waiting(states, &BIAS_OBSERVER);
        Seen {
            is_driven: false,
            angle,
        }
    }

    /// Adds a sample to the window. A full window sets the attitude in the following step: both in one step would
    /// be the longest step of all. Not inlined, so that a step without it needs less stack.
    #[cfg(not(body_encoder))]
    #[inline(never)]
    fn align(&mut self, sample: &Sample) {
        if self.window.count as i32 >= LIMITS.window {
            self.attitude.align_to(self.window.sum);
            self.window = EMPTY_WINDOW;
            self.is_aligned = true;
            if self.status == Status::NotAligned {
                self.status = Status::Ready;
            }
        } else {
            let up = self.attitude.reading(sample.accel);
            let is_quiet = self.attitude.is_quiet(sample.gyro, sample.accel);
            self.window = gathered(&self.window, up, is_quiet, &LIMITS);
        }
    }

    /// Stops driving; the body has to come to rest again.
    #[cfg(body_encoder)]
    fn trip(&mut self, status: Status) {
        self.status = status;
        self.counters.still = 0;
    }

    /// Stops driving and discards the attitude.
    #[cfg(not(body_encoder))]
    fn trip(&mut self, status: Status) {
        self.status = status;
        self.is_aligned = false;
        self.window = EMPTY_WINDOW;
    }

    /// The duty for a current at a wheel speed. Steps with the current at its limit are counted.
    #[cfg(voltage_drive)]
    fn sent(&mut self, current: Current, speed: WheelSpeed) -> Duty {
        let word = current.to_bits();
        let limit = CURRENT_LIMIT.to_bits();
        let is_saturated = word <= -limit || word >= limit;
        #[cfg(body_encoder)]
        self.counters.current = word;
        self.counters.saturated = counted(
            self.counters.saturated,
            is_saturated,
            LIMITS.saturated_steps,
        );
        duty(current, speed)
    }

    /// The duty for a current. Steps with the current at its limit are counted.
    #[cfg(not(voltage_drive))]
    fn sent(&mut self, current: Current) -> Duty {
        let word = current.to_bits();
        let limit = CURRENT_LIMIT.to_bits();
        let is_saturated = word <= -limit || word >= limit;
        #[cfg(body_encoder)]
        self.counters.current = word;
        self.counters.saturated = counted(
            self.counters.saturated,
            is_saturated,
            LIMITS.saturated_steps,
        );
        duty(current)
    }
}

impl Default for Controller {
    fn default() -> Self {
        Controller::new()
    }
}

/// The wheel's speed relative to the body, from the converter's counts, clamped to the stated range.
#[cfg(wheel_converter)]
pub fn wheel_speed(adc: u16) -> WheelSpeed {
    WheelSpeed::from_bits(on_line(adc as i32, &WHEEL_SPEED_LINE))
}

/// The wheel's speed relative to the body, from the driver's reading, clamped to the stated range.
#[cfg(wheel_driver)]
pub fn wheel_speed(word: i16) -> WheelSpeed {
    WheelSpeed::from_bits(on_line(word as i32, &WHEEL_SPEED_LINE))
}

/// The wheel's speed relative to the body, from the counts that its encoder turned over the window,
/// clamped to the stated range. It is the speed of half a window ago.
#[cfg(wheel_encoder)]
pub fn wheel_speed(turned: i32) -> WheelSpeed {
    WheelSpeed::from_bits(on_line(turned, &WHEEL_SPEED_LINE))
}

/// The duty for a current, clamped to the drive's limits.
#[cfg(not(voltage_drive))]
pub fn duty(current: Current) -> Duty {
    Duty(on_line(current.to_bits(), &DUTY_LINE) as u16)
}

/// The duty of the voltage that drives a current through the winding of a motor whose wheel turns at
/// this speed: V = R u + k_e w, clamped to the supply. Where the supply is too low, less current flows.
#[cfg(voltage_drive)]
pub fn duty(current: Current, wheel_speed: WheelSpeed) -> Duty {
    let (word, speed) = (current.to_bits(), wheel_speed.to_bits());
    Duty(on_plane(word, speed, &DUTY_PLANE) as u16)
}
