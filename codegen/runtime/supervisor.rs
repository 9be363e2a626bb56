//! When the motor may be driven, and when it may no longer.
//!
//! The attitude is set by the mean of a window of samples that agree with each other and with
//! gravity. While the motor is driven, each of the conditions below is counted; one that lasts for
//! its stated number of steps trips, and the current is zero until the controller is armed again.

use super::product::clamp;
use super::scaling::is_within;

/// What the controller does. A trip lasts until it is armed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No window of quiet samples has set the attitude yet.
    NotAligned = 0,
    /// The attitude is known; the motor gets no current.
    Ready = 1,
    /// The motor is driven.
    Running = 2,
    /// The body leaned further than the motor could have brought back.
    TrippedAngle = 3,
    /// The gyroscope's words stood still for longer than noise lets them.
    TrippedFrozen = 4,
    /// Gyroscope or accelerometer stayed at the end of its range.
    TrippedClipped = 5,
    /// The wheel's speed stayed at the ends of what the sensor shows.
    TrippedWheelSpeed = 6,
    /// The accelerometer showed no gravity for too long.
    TrippedAccelerometer = 7,
    /// The current stayed at its limit for longer than the wheel can take.
    TrippedCurrent = 8,
    /// The firmware reported a missed tick or a bus error.
    TrippedFault = 9,
}

/// Numbers of the supervisor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest angle while running, word of the angle.
    pub angle_trip: i32,
    /// Largest angle at which the controller is armed, word of the angle.
    pub angle_arm: i32,
    /// Largest rate at which the controller is armed, word of the rate.
    pub rate_arm: i32,
    /// Samples of the window that sets the attitude: 2^`window_shift`.
    pub window: i32,
    /// At most 15.
    pub window_shift: u32,
    /// Squared length of the shortest reading that may be gravity, in units of 2³².
    pub gravity_low: i32,
    /// Squared length of the longest.
    pub gravity_high: i32,
    /// Largest difference of two readings of a window, in a component, accelerometer units.
    pub agreement: i32,
    /// Largest turn of a step in the window, half-angles in Q32.
    pub quiet_turn: i32,
    /// Gyroscope counts at or beyond which, either way, the true rate is unknown.
    pub gyro_clip: [i32; 3],
    /// Counts of the wheel's sensor at or below which the speed may be any.
    pub wheel_low: i32,
    /// Counts at or above which it may be any.
    pub wheel_high: i32,
    /// Steps with an unknown wheel speed that trip.
    pub wheel_steps: i32,
    /// Steps at the end of a range that trip.
    pub clipped_steps: i32,
    /// Steps without a change of the gyroscope's words that trip.
    pub frozen_steps: i32,
    /// Steps without gravity that trip.
    pub rejected_steps: i32,
    /// Steps at the current's limit that trip.
    pub saturated_steps: i32,
}

/// For how many steps each condition has lasted, at most its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// The wheel's speed was unknown.
    pub wheel: u16,
    /// Gyroscope or accelerometer was at the end of its range.
    pub clipped: u16,
    /// The gyroscope's words stood still.
    pub frozen: u16,
    /// The accelerometer showed no gravity.
    pub rejected: u16,
    /// The current was at its limit.
    pub saturated: u16,
    /// The gyroscope's words of the last step that was not at the end of its range.
    pub gyro: [i16; 3],
}

/// Nothing has lasted yet.
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
    /// Samples in it.
    pub count: u16,
    /// The first of them, in units of [`FIRST_UNIT`], rounded down.
    pub first: [i16; 3],
    /// Sum of the samples, each over the size of a full window.
    pub sum: [i32; 3],
}

/// No sample yet.
pub const EMPTY_WINDOW: Window = Window {
    count: 0,
    first: [0, 0, 0],
    sum: [0, 0, 0],
};

/// Largest component of a window's sum: that of a calibrated reading.
pub const SUM_MAX: i32 = 0x2000_0000;

/// Accelerometer units in one unit of a window's first reading: 2¹⁵, so that a reading within ±2²⁹ has 15 bits. At ±8 g
/// it is a thousandth of gravity.
pub const FIRST_UNIT: i32 = 0x8000;

/// Largest count, and largest limit of one.
pub const COUNTED_MAX: i32 = 0xffff;

/// The count of a condition after a step: one more, at most `limit`, where it holds; else none.
#[inline]
pub fn counted(count: u16, holds: bool, limit: i32) -> u16 {
    if holds {
        clamp(clamp(count as i32 + 1, 0, limit), 0, COUNTED_MAX) as u16
    } else {
        0
    }
}

/// The counts after a sample; that of the current's limit stays.
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

/// The status of a controller that runs, by its counts and the word of the angle.
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

/// Whether the motor may be driven from here: near upright, nearly at rest, and no sensor stuck.
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

/// The window after a sample: `up` joins it where it is quiet and agrees with the first one; a
/// quiet sample that does not agree begins another; one that is not quiet leaves none.
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
