//! The supervisor: which conditions trip it, and that only arming ends a trip.

use generated::constants::LIMITS;
use generated::supervisor::{
    COUNTED_MAX, Counters, EMPTY_WINDOW, SUM_MAX, Status, Window, counted, gathered, judged,
    may_arm, observed,
};
use generated::{Controller, Sample, ZERO_CURRENT};

/// Claim `supervisor`: a count grows by one while its condition holds, never exceeds its limit, and
/// is reset once the condition does not hold.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn counts_are_bounded(count: u16, holds: bool, limit: i32) {
    let next = counted(count, holds, limit) as i32;
    assert!((0..=limit).contains(&next), "a count beyond its limit");
    assert!(holds || next == 0, "a count of what does not hold");
    // No limit that is emitted is larger than the largest count.
    if holds && (count as i32) < limit.min(COUNTED_MAX) {
        assert!(next == count as i32 + 1, "a step is not counted");
    }
}

/// Claim `supervisor`: if the counts and the angle are below their limits, the controller may run;
/// any other value trips it, with a status that names the cause.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn each_limit_trips(counters: &Counters, angle: i32) {
    let status = judged(counters, angle, &LIMITS);
    let is_within = (-LIMITS.angle_trip..=LIMITS.angle_trip).contains(&angle)
        && (counters.frozen as i32) < LIMITS.frozen_steps
        && (counters.clipped as i32) < LIMITS.clipped_steps
        && (counters.wheel as i32) < LIMITS.wheel_steps
        && (counters.rejected as i32) < LIMITS.rejected_steps
        && (counters.saturated as i32) < LIMITS.saturated_steps;
    assert!(
        (status == Status::Running) == is_within,
        "a limit without a trip"
    );
    assert!(
        status != Status::NotAligned && status != Status::Ready,
        "a judgement that is none"
    );
}

/// Claim `supervisor`: with one sensor stuck, or far from upright, the controller is not armed.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn arming_needs_sound_sensors(counters: &Counters, angle: i32, rate: i32) {
    if may_arm(counters, angle, rate, &LIMITS) {
        assert!(judged(counters, angle, &LIMITS) != Status::TrippedAngle);
        assert!((counters.frozen as i32) < LIMITS.frozen_steps && counters.wheel == 0);
        assert!(counters.clipped == 0 && counters.rejected == 0);
    }
}

/// Claim `supervisor`: a window holds at most its number of samples, and only quiet ones.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn windows_are_of_quiet_samples(window: &Window, up: [i32; 3], is_quiet: bool) {
    let next = gathered(window, up, is_quiet, &LIMITS);
    assert!(next.count as i32 <= LIMITS.window, "a window too long");
    for sum in next.sum {
        assert!(
            (-SUM_MAX..=SUM_MAX).contains(&sum),
            "a sum out of its range"
        );
    }
    assert!(
        is_quiet || next == EMPTY_WINDOW,
        "a sample that is not quiet"
    );
}

/// Claim `supervisor`: after any sample, the counts are those of [`counted`].
///
/// # Panics
/// If the claim does not hold for these words.
pub fn observation_is_total(
    counters: &Counters,
    gyro: [i16; 3],
    is_clipped: bool,
    shows_gravity: bool,
    wheel: i32,
) {
    let next = observed(counters, gyro, is_clipped, shows_gravity, wheel, &LIMITS);
    assert!(next.wheel as i32 <= LIMITS.wheel_steps);
    assert!(next.frozen as i32 <= LIMITS.frozen_steps);
    assert!(next.clipped as i32 <= LIMITS.clipped_steps);
    assert!(next.rejected as i32 <= LIMITS.rejected_steps);
    assert!(next.gyro == gyro && next.saturated == counters.saturated);
}

/// Claim `supervisor`: after a fault, and after a trip, no sample gives a current until the
/// controller is armed again.
///
/// # Panics
/// If the claim does not hold for these samples.
pub fn a_fault_lasts(controller: &mut Controller, samples: &[Sample]) {
    controller.fault();
    for sample in samples {
        assert!(
            controller.step(sample).0 == ZERO_CURRENT,
            "a current after a fault"
        );
        assert!(
            controller.status() == Status::TrippedFault,
            "a trip that ends by itself"
        );
    }
}
