//! When the motor may be driven, and when it may no longer, where an encoder shows the body.
//!
//! The angle is known from the first count on. The motor may be driven once the body has been near upright and nearly
//! at rest for a stated time. While it is driven, each of the conditions below is counted; one that lasts for its
//! stated number of steps trips, and the current is zero until the controller is armed again.
//!
//! A count that stands still is no fault: a body at rest shows it. It is one under a current that moves the
//! body: gravity takes a part of the current at each angle, and what is left of it accelerates the body, until the count
//! changes.

use super::product::clamp;

/// What the controller does. A trip lasts until it is armed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The body has not been near upright and at rest for long enough yet.
    NotAligned = 0,
    /// It has; the motor gets no current.
    Ready = 1,
    /// The motor is driven.
    Running = 2,
    /// The body leaned further than the motor could have brought back.
    TrippedAngle = 3,
    /// The body's count stood still under a current that moves the body.
    TrippedFrozen = 4,
    /// Does not occur with an encoder.
    TrippedClipped = 5,
    /// The wheel's speed stayed at the ends of what the sensor shows.
    TrippedWheelSpeed = 6,
    /// Does not occur with an encoder.
    TrippedAccelerometer = 7,
    /// The current stayed at its limit for longer than the wheel can take.
    TrippedCurrent = 8,
    /// A count was no motion, or the firmware reported a missed tick or a bus error.
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
    /// Steps within both before it is armed, at least those of the encoder's window.
    pub still_steps: i32,
    /// Counts of the wheel's sensor at or below which the speed may be any.
    pub wheel_low: i32,
    /// Counts at or above which it may be any.
    pub wheel_high: i32,
    /// Steps with an unknown wheel speed that trip.
    pub wheel_steps: i32,
    /// Largest current beyond what gravity takes under which the body may stand still, word of the current.
    pub left_over: i32,
    /// Steps without a change of the body's count, with more than that left over, that trip.
    pub frozen_steps: i32,
    /// Steps at the current's limit that trip.
    pub saturated_steps: i32,
}

/// For how many steps each condition has lasted, at most its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// The wheel's speed was unknown.
    pub wheel: i32,
    /// The body's count stood still while the current pushed the body back.
    pub frozen_back: i32,
    /// The body's count stood still while the current, or gravity against it, pushed the body forward.
    pub frozen_forward: i32,
    /// The body was near upright and nearly at rest.
    pub still: i32,
    /// The current was at its limit.
    pub saturated: i32,
    /// The current of the last step, its word; zero unless the motor was driven.
    pub current: i32,
}

/// Nothing has lasted yet.
pub const NOTHING_COUNTED: Counters = Counters {
    wheel: 0,
    frozen_back: 0,
    frozen_forward: 0,
    still: 0,
    saturated: 0,
    current: 0,
};

/// What a sample shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shown {
    /// Whether the motor is driven.
    pub is_running: bool,
    /// Word of the body's angle.
    pub angle: i32,
    /// Word of its rate.
    pub rate: i32,
    /// Whether its count is that of the step before.
    pub is_same: bool,
    /// The current that holds the body at this angle against gravity, its word.
    pub held: i32,
    /// Counts that stand for the wheel's speed.
    pub wheel: i32,
}

/// The count of a condition after a step: one more, at most `limit`, where it holds; else none.
#[inline]
pub fn counted(count: i32, holds: bool, limit: i32) -> i32 {
    if holds {
        clamp(clamp(count, 0, 0x3fff_ffff) + 1, 0, limit)
    } else {
        0
    }
}

/// The counts after a sample; that of the current's limit stays.
#[inline]
pub fn observed(counters: &Counters, shown: &Shown, limits: &Limits) -> Counters {
    let is_unknown = shown.wheel <= limits.wheel_low || shown.wheel >= limits.wheel_high;
    let is_fixed = shown.is_running && shown.is_same;
    let left = counters.current as i64 - shown.held as i64;
    let is_still = -limits.angle_arm <= shown.angle
        && shown.angle <= limits.angle_arm
        && -limits.rate_arm <= shown.rate
        && shown.rate <= limits.rate_arm;
    Counters {
        wheel: counted(counters.wheel, is_unknown, limits.wheel_steps),
        frozen_back: counted(
            counters.frozen_back,
            is_fixed && left > limits.left_over as i64,
            limits.frozen_steps,
        ),
        frozen_forward: counted(
            counters.frozen_forward,
            is_fixed && left < -(limits.left_over as i64),
            limits.frozen_steps,
        ),
        still: counted(counters.still, is_still, limits.still_steps),
        saturated: counters.saturated,
        current: counters.current,
    }
}

/// The status of a controller that runs, by its counts and the word of the angle.
#[inline]
pub fn judged(counters: &Counters, angle: i32, limits: &Limits) -> Status {
    if angle < -limits.angle_trip || angle > limits.angle_trip {
        Status::TrippedAngle
    } else if counters.frozen_back >= limits.frozen_steps
        || counters.frozen_forward >= limits.frozen_steps
    {
        Status::TrippedFrozen
    } else if counters.wheel >= limits.wheel_steps {
        Status::TrippedWheelSpeed
    } else if counters.saturated >= limits.saturated_steps {
        Status::TrippedCurrent
    } else {
        Status::Running
    }
}

/// Whether the body has been near upright and nearly at rest for long enough, and the wheel's speed is known.
#[inline]
pub fn may_arm(counters: &Counters, limits: &Limits) -> bool {
    counters.still >= limits.still_steps && counters.wheel == 0
}
