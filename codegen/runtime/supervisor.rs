//! When the motor may be driven, and when it may no longer.
//!
//! The attitude starts from the mean of a window of samples that agree with each other and are as
//! long as gravity. While the motor is driven, a counter runs for each fault condition below. A
//! condition that holds for its stated number of consecutive steps trips the controller: the
//! current is then zero until the controller is armed again.

use super::product::clamp;
use super::scaling::is_within;

/// What the controller does. A trip lasts until the controller is armed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No window of quiet samples has set the attitude yet.
    NotAligned = 0,
    /// The attitude is known; the motor gets no current.
    Ready = 1,
    /// The motor is driven.
    Running = 2,
    /// The body leaned beyond the largest angle at which the motor is driven.
    TrippedAngle = 3,
    /// The gyroscope's reading did not change for longer than its noise allows: it is stuck.
    TrippedFrozen = 4,
    /// The gyroscope or the accelerometer stayed at the end of its range.
    TrippedClipped = 5,
    /// The reading of the wheel's speed stayed at an end of the sensor's range.
    TrippedWheelSpeed = 6,
    /// The accelerometer showed no gravity for too long.
    TrippedAccelerometer = 7,
    /// The current stayed at its limit for longer than the wheel can take.
    TrippedCurrent = 8,
    /// The firmware reported a missed tick or a bus error.
    TrippedFault = 9,
}

/// The limits of the supervisor, in the words that the step computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest angle at which the motor stays driven, in words of the angle.
    pub angle_trip: i32,
    /// Largest angle at which the controller can be armed, in words of the angle.
    pub angle_arm: i32,
    /// Largest rate at which the controller can be armed, in words of the rate.
    pub rate_arm: i32,
    /// Number of samples in the window that sets the attitude: 2^`window_shift`.
    pub window: i32,
    /// Base-two logarithm of `window`, at most 15.
    pub window_shift: u32,
    /// Squared length of the shortest accelerometer reading that can be gravity, in units of 2³².
    pub gravity_low: i32,
    /// Squared length of the longest accelerometer reading that can be gravity, in units of 2³².
    pub gravity_high: i32,
    /// Largest difference between two readings of a window in one component, accelerometer units.
    pub agreement: i32,
    /// Largest turn in one step of the window: half-angle in Q32.
    pub quiet_turn: i32,
    /// Largest magnitude of the gyroscope's counts; from there on the true rate is unknown.
    pub gyro_clip: [i32; 3],
    /// Lower end of the wheel sensor's range, counts: at or below it the speed is unknown.
    pub wheel_low: i32,
    /// Upper end of the wheel sensor's range, counts: at or above it the speed is unknown.
    pub wheel_high: i32,
    /// Consecutive steps with an unknown wheel speed that trip the controller.
    pub wheel_steps: i32,
    /// Consecutive steps with a reading at the end of its range that trip the controller.
    pub clipped_steps: i32,
    /// Consecutive steps with an unchanged gyroscope reading that trip the controller.
    pub frozen_steps: i32,
    /// Consecutive steps in which the accelerometer shows no gravity that trip the controller.
    pub rejected_steps: i32,
    /// Consecutive steps with the current at its limit that trip the controller.
    pub saturated_steps: i32,
}

/// The number of consecutive steps for which each condition has held, at most its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// The wheel's speed was unknown.
    pub wheel: u16,
    /// The gyroscope or the accelerometer was at the end of its range.
    pub clipped: u16,
    /// The gyroscope's reading did not change.
    pub frozen: u16,
    /// The accelerometer showed no gravity.
    pub rejected: u16,
    /// The current was at its limit.
    pub saturated: u16,
    /// The last gyroscope reading that was not at the end of the range, counts.
    pub gyro: [i16; 3],
}

/// No condition has held yet.
pub const NOTHING_COUNTED: Counters = Counters {
    wheel: 0,
    clipped: 0,
    frozen: 0,
    rejected: 0,
    saturated: 0,
    gyro: [0, 0, 0],
};

/// The window of quiet samples so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Number of samples so far.
    pub count: u16,
    /// The first sample in units of [`FIRST_UNIT`], rounded down.
    pub first: [i16; 3],
    /// Sum of the samples, each divided by the size of a full window: the mean once it is full.
    pub sum: [i32; 3],
}

/// A window without a sample.
pub const EMPTY_WINDOW: Window = Window {
    count: 0,
    first: [0, 0, 0],
    sum: [0, 0, 0],
};

/// Largest component of a window's sum; a calibrated reading has the same bound.
pub const SUM_MAX: i32 = 0x2000_0000;

/// Accelerometer units in one unit of a window's first reading: 2¹⁵, so that a reading within ±2²⁹ has 15 bits. At ±8 g
/// it is a thousandth of gravity.
pub const FIRST_UNIT: i32 = 0x8000;

/// Largest value of a counter, and largest limit of one.
pub const COUNTED_MAX: i32 = 0xffff;

/// The counter of a condition after a step: one more, at most `limit`, if the condition holds; else
/// zero.
#[inline]
pub fn counted(count: u16, holds: bool, limit: i32) -> u16 {
    if holds {
        clamp(clamp(count as i32 + 1, 0, limit), 0, COUNTED_MAX) as u16
    } else {
        0
    }
}

/// The counters after a sample. The counter of the current's limit does not change here.
#[inline]
pub fn observed(
    counters: &Counters,
    gyro: [i16; 3],
    is_clipped: bool,
    shows_gravity: bool,
    wheel: i32,
    limits: &Limits,
) -> Counters {
    let is_frozen =
        gyro[0] == counters.gyro[0] && gyro[1] == counters.gyro[1] && gyro[2] == counters.gyro[2];
    let is_unknown = wheel <= limits.wheel_low || wheel >= limits.wheel_high;
    Counters {
        wheel: counted(counters.wheel, is_unknown, limits.wheel_steps),
        clipped: counted(counters.clipped, is_clipped, limits.clipped_steps),
        frozen: counted(counters.frozen, is_frozen, limits.frozen_steps),
        rejected: counted(counters.rejected, !shows_gravity, limits.rejected_steps),
        saturated: counters.saturated,
        gyro,
    }
}

/// The status of a running controller after a sample, from its counters and the word of the angle.
#[inline]
pub fn judged(counters: &Counters, angle: i32, limits: &Limits) -> Status {
    if angle < -limits.angle_trip || angle > limits.angle_trip {
        Status::TrippedAngle
    } else if counters.frozen as i32 >= limits.frozen_steps {
        Status::TrippedFrozen
    } else if counters.clipped as i32 >= limits.clipped_steps {
        Status::TrippedClipped
    } else if counters.wheel as i32 >= limits.wheel_steps {
        Status::TrippedWheelSpeed
    } else if counters.rejected as i32 >= limits.rejected_steps {
        Status::TrippedAccelerometer
    } else if counters.saturated as i32 >= limits.saturated_steps {
        Status::TrippedCurrent
    } else {
        Status::Running
    }
}

/// Whether the controller can be armed: near upright, nearly at rest, and no sensor at fault.
#[inline]
pub fn may_arm(counters: &Counters, angle: i32, rate: i32, limits: &Limits) -> bool {
    -limits.angle_arm <= angle
        && angle <= limits.angle_arm
        && -limits.rate_arm <= rate
        && rate <= limits.rate_arm
        && (counters.frozen as i32) < limits.frozen_steps
        && counters.clipped == 0
        && counters.wheel == 0
        && counters.rejected == 0
}

/// The window after the sample `up`. A quiet sample that agrees with the first one joins the
/// window; a quiet one that does not agree starts a new window; any other empties the window.
#[inline]
pub fn gathered(window: &Window, up: [i32; 3], is_quiet: bool, limits: &Limits) -> Window {
    if !is_quiet {
        return EMPTY_WINDOW;
    }
    let agrees = window.count > 0
        && is_within(
            up[0] - window.first[0] as i32 * FIRST_UNIT,
            limits.agreement,
        )
        && is_within(
            up[1] - window.first[1] as i32 * FIRST_UNIT,
            limits.agreement,
        )
        && is_within(
            up[2] - window.first[2] as i32 * FIRST_UNIT,
            limits.agreement,
        );
    let share = [
        up[0] >> limits.window_shift,
        up[1] >> limits.window_shift,
        up[2] >> limits.window_shift,
    ];
    if agrees {
        Window {
            count: counted(window.count, true, limits.window),
            first: window.first,
            sum: [
                clamp(window.sum[0] + share[0], -SUM_MAX, SUM_MAX),
                clamp(window.sum[1] + share[1], -SUM_MAX, SUM_MAX),
                clamp(window.sum[2] + share[2], -SUM_MAX, SUM_MAX),
            ],
        }
    } else {
        Window {
            count: 1,
            first: [
                (up[0] >> 15) as i16,
                (up[1] >> 15) as i16,
                (up[2] >> 15) as i16,
            ],
            sum: share,
        }
    }
}
