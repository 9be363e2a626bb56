//! Kani proofs of the supervisor, for every word.

use generated::constants::LIMITS;
use generated::supervisor::{Counters, Window};

use crate::properties::supervisor;

fn any_counters() -> Counters {
    Counters {
        wheel: kani::any(),
        clipped: kani::any(),
        frozen: kani::any(),
        rejected: kani::any(),
        saturated: kani::any(),
        gyro: kani::any(),
    }
}

#[kani::proof]
fn supervisor_counts() {
    let (count, holds, limit): (u16, bool, i32) = (kani::any(), kani::any(), kani::any());
    kani::assume(limit >= 1);
    kani::cover!(holds && count as i32 == limit, "a count at its limit");
    supervisor::counts_are_bounded(count, holds, limit);
}

#[kani::proof]
fn supervisor_judges() {
    let counters = any_counters();
    let angle = kani::any();
    kani::cover!(angle == LIMITS.angle_trip, "the largest angle");
    supervisor::each_limit_trips(&counters, angle);
    supervisor::arming_needs_sound_sensors(&counters, angle, kani::any());
}

#[kani::proof]
fn supervisor_observes() {
    let counters = any_counters();
    supervisor::observation_is_total(
        &counters,
        kani::any(),
        kani::any(),
        kani::any(),
        kani::any(),
    );
}

#[kani::proof]
fn supervisor_gathers() {
    let within = |words: [i32; 3]| {
        for word in words {
            kani::assume((-0x2000_0000..=0x2000_0000).contains(&word));
        }
        words
    };
    let window = Window {
        count: kani::any(),
        first: kani::any(),
        sum: within(kani::any()),
    };
    kani::cover!(window.count as i32 == LIMITS.window, "a full window");
    supervisor::windows_are_of_quiet_samples(&window, within(kani::any()), kani::any());
}
