//! Kani proof of the whole step, from every state of the invariant, where an encoder shows the body.
//!
//! The fields of a controller are private, so a state is reached as the crate reaches it. Two samples set the encoders to
//! any count and turn that occur, and the third count is the first that may be no motion. After a step the counts are any
//! within their limits, since [`any_counts`] stands in. A wish follows: arm, disarm, fault, or none. So the last step starts
//! in any state: not aligned, ready, running, or tripped.
//!
//! What stands in is shown elsewhere: `observed` in [`crate::proofs_supervisor`]; the law in [`crate::proofs`]; lines in
//! [`crate::proofs_lines`].

use generated::constants::{BODY_ANGLE_LINE, BODY_RATE_LINE};
use generated::line::on_line;
use generated::supervisor::{Counters, Limits, Shown, observed};
use generated::{CURRENT_LIMIT, Controller, Sample};

use crate::proofs_lines::{any_command, any_on_line};
use crate::properties;
use crate::words::any_within;

/// Any counts up to their limits; the harness `supervisor_observes` shows it.
fn any_counts(_counters: &Counters, _shown: &Shown, limits: &Limits) -> Counters {
    let up_to = |limit: i32| {
        let count = kani::any();
        kani::assume((0..=limit).contains(&count));
        count
    };
    let [current] = any_within(CURRENT_LIMIT.to_bits());
    Counters {
        wheel: up_to(limits.wheel_steps),
        frozen_back: up_to(limits.frozen_steps),
        frozen_forward: up_to(limits.frozen_steps),
        still: up_to(limits.still_steps),
        saturated: up_to(limits.saturated_steps),
        current,
    }
}

/// The angle by any count, and the rate by any turn.
#[kani::proof]
#[kani::stub(on_line, any_on_line)]
fn body_in_range() {
    let angle = generated::body::body_angle(kani::any()).to_bits();
    assert!((BODY_ANGLE_LINE.low..=BODY_ANGLE_LINE.high).contains(&angle));
    let rate = generated::body::body_rate(kani::any()).to_bits();
    assert!((BODY_RATE_LINE.low..=BODY_RATE_LINE.high).contains(&rate));
}

fn any_sample() -> Sample {
    Sample {
        body_count: kani::any(),
        #[cfg(wheel_converter)]
        wheel_adc: kani::any(),
        #[cfg(wheel_driver)]
        wheel_speed: kani::any(),
        #[cfg(wheel_encoder)]
        wheel_count: kani::any(),
    }
}

#[kani::proof]
#[kani::stub(on_line, any_on_line)]
#[kani::stub(generated::control::control, any_command)]
#[kani::stub(observed, any_counts)]
fn step_total() {
    let mut controller = Controller::new();
    controller.step(&any_sample());
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
