//! One step from raw counts to the drive's duty.

use super::attitude::Attitude;
use super::bias_observer::{advanced, estimated_bias, waiting};
use super::constants::{BIAS_OBSERVER, DUTY_LINE, WHEEL_SPEED_LINE, ZERO_CURRENT};
use super::control::{Angle, Current, WheelSpeed, control};
use super::line::on_line;

/// What the sensors said at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Gyroscope, raw counts.
    pub gyro: [i16; 3],
    /// Accelerometer, raw counts.
    pub accel: [i16; 3],
    /// Magnetometer, raw counts, where there is a new reading.
    pub mag: Option<[i16; 3]>,
    /// The drive's speed output, raw counts of the converter.
    pub wheel_adc: u16,
}

/// Duty of the 16-bit PWM that the current drive reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duty(pub u16);

/// The whole controller: call [`Controller::step`] once every sample time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Controller {
    attitude: Attitude,
    is_aligned: bool,
    is_armed: bool,
    bias_state: i32,
}

impl Controller {
    /// Starts unarmed; the first usable accelerometer reading sets the attitude.
    pub const fn new() -> Self {
        Controller {
            attitude: Attitude::new(),
            is_aligned: false,
            is_armed: false,
            bias_state: 0,
        }
    }

    /// From the next step on, the motor is driven.
    pub fn arm(&mut self) {
        self.is_armed = true;
    }

    /// From the next step on, the current is zero; the attitude is still followed.
    pub fn disarm(&mut self) {
        self.is_armed = false;
    }

    /// The attitude filter.
    pub fn attitude(&self) -> &Attitude {
        &self.attitude
    }

    /// Takes one sample and returns the duty: that of zero current while not armed.
    pub fn step(&mut self, sample: &Sample) -> Duty {
        if !self.is_aligned {
            self.is_aligned = self.attitude.align(sample.accel);
        }
        match sample.mag {
            Some(mag) => self.attitude.update_marg(sample.gyro, sample.accel, mag),
            None => self.attitude.update_imu(sample.gyro, sample.accel),
        }
        let angle = self.attitude.angle();
        let rate = self.attitude.rate();
        let speed = wheel_speed(sample.wheel_adc);
        let states = [angle.to_bits(), rate.to_bits(), speed.to_bits()];
        if self.is_armed {
            let bias = estimated_bias(self.bias_state, states, &BIAS_OBSERVER);
            let current = control(Angle::from_bits(states[0] - bias), rate, speed);
            self.bias_state = advanced(self.bias_state, states, current.to_bits(), &BIAS_OBSERVER);
            duty(current)
        } else {
            self.bias_state = waiting(states, &BIAS_OBSERVER);
            Duty(ZERO_CURRENT)
        }
    }
}

impl Default for Controller {
    fn default() -> Self {
        Controller::new()
    }
}

/// The wheel's speed relative to the body from the converter's counts, within the stated range.
pub fn wheel_speed(adc: u16) -> WheelSpeed {
    WheelSpeed::from_bits(on_line(adc as i32, &WHEEL_SPEED_LINE))
}

/// The duty for a current, within the drive's limits.
pub fn duty(current: Current) -> Duty {
    Duty(on_line(current.to_bits(), &DUTY_LINE) as u16)
}
