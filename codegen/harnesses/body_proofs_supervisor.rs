//! Kani proofs of the supervisor, for every word, where an encoder shows the body.

use generated::CURRENT_LIMIT;
use generated::constants::LIMITS;
use generated::supervisor::{Counters, Shown};

use crate::properties::supervisor;
use crate::words::any_within;

fn any_counters() -> Counters {
    Counters {
        wheel: kani::any(),
        frozen_back: kani::any(),
        frozen_forward: kani::any(),
        still: kani::any(),
        saturated: kani::any(),
        current: kani::any(),
    }
}

fn any_shown() -> Shown {
    Shown {
        is_running: kani::any(),
        angle: kani::any(),
        rate: kani::any(),
        is_same: kani::any(),
        held: kani::any(),
        wheel: kani::any(),
    }
}

#[kani::proof]
fn supervisor_counts() {
    let (count, holds, limit) = (kani::any(), kani::any(), kani::any());
    kani::assume(limit >= 1);
    kani::cover!(holds && count == limit, "a count at its limit");
    supervisor::counts_are_bounded(count, holds, limit);
}

#[kani::proof]
fn supervisor_judges() {
    let counters = any_counters();
    let angle = kani::any();
    kani::cover!(angle == LIMITS.angle_trip, "the largest angle");
    supervisor::each_limit_trips(&counters, angle);
    supervisor::arming_needs_rest(&counters);
}

#[kani::proof]
fn supervisor_observes() {
    let counters = any_counters();
    let shown = any_shown();
    kani::cover!(
        shown.is_running && shown.is_same,
        "a count that stands still"
    );
    supervisor::observation_is_total(&counters, &shown);
}

/// A body that stands still is a fault only under a current of more than what is left over beside gravity.
#[kani::proof]
fn supervisor_freezes() {
    let mut counters = any_counters();
    let [current] = any_within(CURRENT_LIMIT.to_bits());
    counters.current = current;
    supervisor::only_a_driven_body_freezes(&counters, &any_shown());
}
