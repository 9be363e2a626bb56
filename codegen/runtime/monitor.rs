//! Watches whether the pendulum moves as the model of the proof allows.

use super::constants::ZERO_CURRENT;
use super::control::{Angle, Rate, WheelSpeed};
use super::controller::Duty;
use super::monitor_words::MOTION_LIMITS;
use super::motion::{Motion, MotionSums, NO_DIFFERENCE, agrees, compared};

/// Compares the motion in each step with the model's prediction. Call [`Monitor::allows`] after every step of the
/// controller; if it returns `false`, report a fault to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Monitor {
    was_running: bool,
    last: Motion,
    sums: MotionSums,
}

impl Monitor {
    /// A monitor that has seen no motion.
    pub const fn new() -> Self {
        Monitor {
            was_running: false,
            last: Motion {
                angle: 0,
                rate: 0,
                wheel_speed: 0,
                duty: 0,
            },
            sums: NO_DIFFERENCE,
        }
    }

    /// Whether the motion since the controller was armed is one that the model allows: takes what the step has
    /// measured, and the duty that it returned. While the controller does not run, everything is
    /// allowed and nothing is remembered.
    pub fn allows(
        &mut self,
        is_running: bool,
        angle: Angle,
        rate: Rate,
        wheel_speed: WheelSpeed,
        duty: Duty,
    ) -> bool {
        let motion = Motion {
            angle: angle.to_bits(),
            rate: rate.to_bits(),
            wheel_speed: wheel_speed.to_bits(),
            duty: duty.0 as i32 - ZERO_CURRENT as i32,
        };
        let sums = if self.was_running && is_running {
            compared(&self.sums, &self.last, &motion, &MOTION_LIMITS)
        } else {
            NO_DIFFERENCE
        };
        self.sums = sums;
        self.last = motion;
        self.was_running = is_running;
        agrees(&sums, &MOTION_LIMITS)
    }
}

impl Default for Monitor {
    fn default() -> Self {
        Monitor::new()
    }
}
