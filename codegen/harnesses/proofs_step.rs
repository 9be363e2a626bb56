//! Kani proof of the whole step, from every state of the invariant.
//!
//! The fields of a controller are private, so a state is reached as the crate reaches it. The parts that write the state
//! stand in by their ranges: after one step with any sample the attitude, the drift, the counts, the window and the
//! observer's word are any words of the invariant, and the window may have been full. A wish follows: arm, disarm,
//! fault, or none. So the second step starts in any state: not aligned, ready, running, or tripped. (A trip by a count
//! acts as one by a fault: only `Running` and `NotAligned` are asked for.)
//!
//! What stands in is shown elsewhere: `observed`, `gathered` in [`crate::proofs_supervisor`]; the law in
//! [`crate::proofs`]; lines in [`crate::proofs_lines`]; the observer here; the filter in [`crate::proofs_attitude`];
//! `aligned` and the rows of products by the checker.

use generated::bias_observer::{BiasObserver, advanced, estimated_bias, waiting};
use generated::constants::{ANGLE_MAX, BIAS_OBSERVER, LIMITS};
use generated::drift::{rate_error, tracked};
use generated::lever_arm::{length_squared, without_motion};
use generated::line::on_line;
use generated::madgwick::{COMPONENT_MAX, aligned, correction_imu, turned, unit_q28};
use generated::pivot_angle::pivot_angle;
use generated::supervisor::{Counters, Limits, SUM_MAX, Window, gathered, observed};
use generated::{CURRENT_LIMIT, Controller, Sample};

use crate::proofs_attitude::{
    any_angle, any_correction, any_direction, any_drift, any_gravity, any_length, any_rate_error,
    any_reading, any_turn,
};
use crate::proofs_lines::{any_command, any_on_line};
use crate::properties;
use crate::words::{any_within, assert_within};

/// [`observer_in_range`] shows it.
fn any_bias(_z: i32, _states: [i32; 3], observer: &BiasObserver) -> i32 {
    let bias = kani::any();
    kani::assume((-observer.limit..=observer.limit).contains(&bias));
    bias
}

/// [`observer_in_range`] shows it.
fn any_observer(_z: i32, _states: [i32; 3], _current: i32, _observer: &BiasObserver) -> i32 {
    let [z] = any_within(i32::MAX);
    z
}

/// [`observer_in_range`] shows it.
fn any_waiting(_states: [i32; 3], _observer: &BiasObserver) -> i32 {
    let [z] = any_within(i32::MAX);
    z
}

/// The checker shows it by intervals.
fn any_aligned(measured_up: [i32; 3]) -> [i32; 4] {
    assert_within(&measured_up, 0x2800_0000);
    any_within(COMPONENT_MAX)
}

/// Any counts up to their limits; the harness `supervisor_observes` shows it.
fn any_counts(
    _counters: &Counters,
    gyro: [i16; 3],
    _is_clipped: bool,
    _shows_gravity: bool,
    _wheel: i32,
    limits: &Limits,
) -> Counters {
    let up_to = |limit: i32| {
        let count: u16 = kani::any();
        kani::assume(count as i32 <= limit);
        count
    };
    Counters {
        wheel: up_to(limits.wheel_steps),
        clipped: up_to(limits.clipped_steps),
        frozen: up_to(limits.frozen_steps),
        rejected: up_to(limits.rejected_steps),
        saturated: up_to(limits.saturated_steps),
        gyro,
    }
}

/// Any window; the harness `supervisor_gathers` shows it.
fn any_window(_window: &Window, _up: [i32; 3], _is_quiet: bool, limits: &Limits) -> Window {
    let count: u16 = kani::any();
    kani::assume(count as i32 <= limits.window);
    Window {
        count,
        first: kani::any(),
        sum: any_within(SUM_MAX),
    }
}

/// Any words of the states, the current and the observer.
#[kani::proof]
fn observer_in_range() {
    let (z, states) = (kani::any(), kani::any());
    let bias = estimated_bias(z, states, &BIAS_OBSERVER);
    assert!((-BIAS_OBSERVER.limit..=BIAS_OBSERVER.limit).contains(&bias));
    let current = kani::any();
    let limit = CURRENT_LIMIT.to_bits();
    kani::assume((-limit..=limit).contains(&current));
    for next in [
        advanced(z, states, current, &BIAS_OBSERVER),
        waiting(states, &BIAS_OBSERVER),
    ] {
        assert!(next >= -i32::MAX);
    }
    // What the step subtracts from the angle does not overflow.
    assert!(ANGLE_MAX >= 0 && LIMITS.angle_trip >= 0);
}

fn any_sample() -> Sample {
    Sample {
        gyro: kani::any(),
        accel: kani::any(),
        mag: kani::any(),
        #[cfg(wheel_converter)]
        wheel_adc: kani::any(),
        #[cfg(wheel_driver)]
        wheel_speed: kani::any(),
        #[cfg(wheel_encoder)]
        wheel_count: kani::any(),
    }
}

#[kani::proof]
#[kani::stub(generated::calibration::calibrate, any_reading)]
#[kani::stub(without_motion, any_gravity)]
#[kani::stub(length_squared, any_length)]
#[kani::stub(unit_q28, any_direction)]
#[kani::stub(correction_imu, any_correction)]
#[kani::stub(turned, any_turn)]
#[kani::stub(rate_error, any_rate_error)]
#[kani::stub(tracked, any_drift)]
#[kani::stub(aligned, any_aligned)]
#[kani::stub(pivot_angle, any_angle)]
#[kani::stub(on_line, any_on_line)]
#[kani::stub(generated::control::control, any_command)]
#[kani::stub(estimated_bias, any_bias)]
#[kani::stub(advanced, any_observer)]
#[kani::stub(waiting, any_waiting)]
#[kani::stub(observed, any_counts)]
#[kani::stub(gathered, any_window)]
fn step_total() {
    let mut controller = Controller::new();
    controller.step(&any_sample());
    // The third count of an encoder is the first that may be no motion.
    #[cfg(wheel_encoder)]
    controller.step(&any_sample());
    let (is_faulty, is_armed) = (kani::any(), kani::any());
    if is_faulty {
        controller.fault();
    }
    kani::cover!(is_armed && !is_faulty, "armed");
    kani::cover!(is_faulty, "after a fault");
    properties::step::duty_within_limits(&mut controller, &any_sample(), is_armed);
    kani::cover!(
        controller.status() == generated::Status::Running,
        "running after the step"
    );
}
