//! The supervisor where an encoder shows the body: which conditions trip it, and that only arming ends a trip.

use generated::constants::LIMITS;
use generated::supervisor::{Counters, Shown, Status, counted, judged, may_arm, observed};
use generated::{Controller, Sample, ZERO_CURRENT};

/// Claim `supervisor`: a count grows by one while its condition holds, never exceeds its limit, and
/// is reset once the condition does not hold.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn counts_are_bounded(count: i32, holds: bool, limit: i32) {
    let next = counted(count, holds, limit);
    assert!((0..=limit).contains(&next), "a count beyond its limit");
    assert!(holds || next == 0, "a count of what does not hold");
    // No limit that is emitted comes near 2³⁰ steps, twelve days at 1 kHz.
    if holds && (0..limit.min(0x3fff_ffff)).contains(&count) {
        assert!(next == count + 1, "a step is not counted");
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
        && counters.frozen_back < LIMITS.frozen_steps
        && counters.frozen_forward < LIMITS.frozen_steps
        && counters.wheel < LIMITS.wheel_steps
        && counters.saturated < LIMITS.saturated_steps;
    assert!(
        (status == Status::Running) == is_within,
        "a limit without a trip"
    );
    assert!(
        status != Status::NotAligned && status != Status::Ready,
        "a judgement that is none"
    );
}

/// Claim `supervisor`: the controller is armed after the body has been at rest for its time, with a known wheel speed.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn arming_needs_rest(counters: &Counters) {
    if may_arm(counters, &LIMITS) {
        assert!(counters.still >= LIMITS.still_steps && counters.wheel == 0);
    }
}

/// Claim `supervisor`: after any sample, each count is within its limit, and rest is counted only near upright.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn observation_is_total(counters: &Counters, shown: &Shown) {
    let next = observed(counters, shown, &LIMITS);
    assert!((0..=LIMITS.wheel_steps).contains(&next.wheel));
    assert!((0..=LIMITS.frozen_steps).contains(&next.frozen_back));
    assert!((0..=LIMITS.frozen_steps).contains(&next.frozen_forward));
    assert!((0..=LIMITS.still_steps).contains(&next.still));
    assert!(next.saturated == counters.saturated && next.current == counters.current);
    let is_near = (-LIMITS.angle_arm..=LIMITS.angle_arm).contains(&shown.angle)
        && (-LIMITS.rate_arm..=LIMITS.rate_arm).contains(&shown.rate);
    assert!(is_near || next.still == 0, "rest that is none");
}

/// Claim `supervisor`: a count that stands still is counted only while the motor is driven, by a current that differs
/// from the one that holds the body by more than the stated one, and towards one side at a time.
///
/// # Panics
/// If the claim does not hold for these words.
pub fn only_a_driven_body_freezes(counters: &Counters, shown: &Shown) {
    let next = observed(counters, shown, &LIMITS);
    let left = i64::from(counters.current) - i64::from(shown.held);
    if next.frozen_back > 0 || next.frozen_forward > 0 {
        assert!(shown.is_running && shown.is_same);
        assert!(left.abs() > i64::from(LIMITS.left_over));
    }
    assert!(next.frozen_back == 0 || next.frozen_forward == 0);
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
