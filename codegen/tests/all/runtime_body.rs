//! The supervisor of a body that an encoder shows: when a count that stands still is a fault.

use codegen::helpers::body_supervisor::{
    Counters, Limits, NOTHING_COUNTED, Shown, Status, judged, may_arm, observed,
};
use codegen::supervisor::frozen_count_s;
use proptest::prelude::*;

use crate::benches::with_body_encoder;
use crate::thesis;

const LIMITS: Limits = Limits {
    angle_trip: 1000,
    angle_arm: 500,
    rate_arm: 100,
    still_steps: 20,
    wheel_low: 0,
    wheel_high: 100,
    wheel_steps: 5,
    left_over: 50,
    frozen_steps: 8,
    saturated_steps: 30,
};

fn shown() -> Shown {
    Shown {
        is_running: true,
        angle: 10,
        rate: 0,
        is_same: true,
        held: 30,
        wheel: 50,
    }
}

/// The status after this many steps of one sample under one current.
fn after(steps: usize, current: i32, shown: &Shown) -> Status {
    let mut counters = Counters {
        current,
        ..NOTHING_COUNTED
    };
    for _ in 0..steps {
        counters = observed(&counters, shown, &LIMITS);
    }
    judged(&counters, shown.angle, &LIMITS)
}

/// A count that stands still trips under what is left of the current, either way, and in no other case.
#[test]
fn a_count_that_stands_still_trips_only_where_the_body_must_move() {
    // 30 of the current hold the body: 81 push it back, -21 let it fall.
    for (current, is_fault) in [
        (80, false),
        (81, true),
        (30, false),
        (-20, false),
        (-21, true),
    ] {
        let wanted = match is_fault {
            true => Status::TrippedFrozen,
            false => Status::Running,
        };
        assert_eq!(after(8, current, &shown()), wanted, "{current}");
        assert_eq!(after(7, current, &shown()), Status::Running, "{current}");
    }
    let moving = Shown {
        is_same: false,
        ..shown()
    };
    assert_eq!(after(100, 90, &moving), Status::Running);
    let waiting = Shown {
        is_running: false,
        ..shown()
    };
    assert_eq!(after(100, 90, &waiting), Status::Running);
}

#[test]
fn a_body_is_armed_after_its_time_at_rest() {
    let mut counters = NOTHING_COUNTED;
    for step in 1..=20 {
        counters = observed(&counters, &shown(), &LIMITS);
        assert_eq!(may_arm(&counters, &LIMITS), step == 20);
    }
    for change in [
        Shown {
            angle: 501,
            ..shown()
        },
        Shown {
            angle: -501,
            ..shown()
        },
        Shown {
            rate: 101,
            ..shown()
        },
        Shown {
            rate: -101,
            ..shown()
        },
        Shown {
            wheel: 100,
            ..shown()
        },
    ] {
        assert!(
            !may_arm(&observed(&counters, &change, &LIMITS), &LIMITS),
            "{change:?}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Any words: no overflow, and no count beyond its limit.
    #[test]
    fn any_words(
        counts in any::<[i32; 6]>(),
        words in any::<[i32; 4]>(),
        flags in any::<[bool; 2]>(),
    ) {
        let [wheel, frozen_back, frozen_forward, still, saturated, current] = counts;
        let counters = Counters { wheel, frozen_back, frozen_forward, still, saturated, current };
        let [angle, rate, held, wheel] = words;
        let shown = Shown { is_running: flags[0], angle, rate, is_same: flags[1], held, wheel };
        let found = observed(&counters, &shown, &LIMITS);
        prop_assert!((0..=LIMITS.frozen_steps).contains(&found.frozen_back));
        prop_assert!((0..=LIMITS.frozen_steps).contains(&found.frozen_forward));
        prop_assert!((0..=LIMITS.still_steps).contains(&found.still));
        prop_assert!((0..=LIMITS.wheel_steps).contains(&found.wheel));
        let _ = judged(&found, angle, &LIMITS);
    }

    /// The argument that there is no false alarm: a body with half of the acceleration that is left over does not stay
    /// within four counts for the stated time, wherever in them it begins and however fast it first runs against it.
    #[test]
    fn a_body_that_is_pushed_leaves_its_count(start in 0.0..1.0_f64, speed in 0.0..1.0_f64) {
        let spec = with_body_encoder(thesis::spec());
        let encoder = spec.hardware.body_encoder().expect("an encoder").encoder;
        let time_s = frozen_count_s(&spec, &encoder);
        let width = 4.0 * encoder.rad_per_count().abs();
        let acceleration = 0.25 * spec.b[1].abs() * spec.current_limit_a;
        // Faster ones leave at the other end.
        let against = speed * (2.0 * acceleration * start * width).sqrt();
        let place = start * width - against * time_s + 0.5 * acceleration * time_s * time_s;
        prop_assert!(place >= width * (1.0 - 1e-9), "{place} of {width}");
    }
}
