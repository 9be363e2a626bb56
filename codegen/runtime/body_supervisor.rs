//! When the motor may be driven, and when it may no longer, where an encoder shows the body.
//!
//! The angle is known from the first count on. The motor may be driven once the body has been near upright and nearly
//! at rest for a stated time. While it is driven, a counter runs for each fault condition below. A condition that
//! holds for its stated number of consecutive steps trips the controller: the current is then zero until the
//! controller is armed again.
//!
//! An encoder count that does not change is no fault while the body is at rest. It is a fault while the current
//! exceeds what holds the body against gravity at its angle: the excess accelerates the body, so that the count has to
//! change.

use super::product::clamp;

/// What the controller does. A trip lasts until the controller is armed again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The body has not been near upright and at rest for long enough yet.
    NotAligned = 0,
    /// The body has been near upright and at rest for long enough; the motor gets no current.
    Ready = 1,
    /// The motor is driven.
    Running = 2,
    /// The body leaned beyond the largest angle at which the motor is driven.
    TrippedAngle = 3,
    /// The body's encoder count did not change under a current that must have moved the body.
    TrippedFrozen = 4,
    /// Does not occur with an encoder.
    TrippedClipped = 5,
    /// The reading of the wheel's speed stayed at an end of the sensor's range.
    TrippedWheelSpeed = 6,
    /// Does not occur with an encoder.
    TrippedAccelerometer = 7,
    /// The current stayed at its limit for longer than the wheel can take.
    TrippedCurrent = 8,
    /// A count jumped further than any motion, or the firmware reported a missed tick or a bus error.
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
    /// Consecutive steps within both before it can be armed; at least the steps of the encoder's window.
    pub still_steps: i32,
    /// Lower end of the wheel sensor's range, counts: at or below it the speed is unknown.
    pub wheel_low: i32,
    /// Upper end of the wheel sensor's range, counts: at or above it the speed is unknown.
    pub wheel_high: i32,
    /// Consecutive steps with an unknown wheel speed that trip the controller.
    pub wheel_steps: i32,
    /// Largest excess of the current over what holds the body against gravity at which the body can stay at rest, in
    /// words of the current.
    pub left_over: i32,
    /// Consecutive steps with an unchanged count under a larger excess that trip the controller.
    pub frozen_steps: i32,
    /// Consecutive steps with the current at its limit that trip the controller.
    pub saturated_steps: i32,
}

/// The number of consecutive steps for which each condition has held, at most its limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// The wheel's speed was unknown.
    pub wheel: i32,
    /// The body's count did not change while the current pushed the body backward.
    pub frozen_back: i32,
    /// The body's count did not change while the current, or gravity against it, pushed the body forward.
    pub frozen_forward: i32,
    /// The body was near upright and nearly at rest.
    pub still: i32,
    /// The current was at its limit.
    pub saturated: i32,
    /// The word of the current in the last step; zero unless the motor was driven.
    pub current: i32,
}

/// No condition has held yet.
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
    /// Word of the body's rate.
    pub rate: i32,
    /// Whether the body's count is the same as in the step before.
    pub is_same: bool,
    /// Word of the current that holds the body at this angle against gravity.
    pub held: i32,
    /// Reading of the wheel's sensor, counts.
    pub wheel: i32,
}

/// The counter of a condition after a step: one more, at most `limit`, if the condition holds; else zero.
#[inline]
pub fn counted(count: i32, holds: bool, limit: i32) -> i32 {
    if holds {
        clamp(clamp(count, 0, 0x3fff_ffff) + 1, 0, limit)
    } else {
        0
    }
}

/// The counters after a sample. The counter of the current's limit does not change here.
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

/// The status of a running controller after a sample, from its counters and the word of the angle.
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
