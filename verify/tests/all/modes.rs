//! The emitted loop beside the loop in real numbers, mode by mode.

use generated::control::{ANGLE_GAIN, RATE_GAIN, WHEEL_SPEED_GAIN};
use proptest::prelude::*;
use verify::properties::modes::{COORDINATE_MAX, HALF_WORD, MODES, difference_stays};

/// States whose command is of any size up to the limit: two words of any size within the ranges of the bench, and the
/// angle that makes the rest.
fn states() -> impl Strategy<Value = [i32; 3]> {
    let target = -(1_i64 << 56)..(1_i64 << 56);
    (any::<i32>(), any::<i32>(), target).prop_filter_map(
        "an angle",
        |(rate, wheel_speed, target)| {
            let (rate, wheel_speed) = (rate >> 4, wheel_speed >> 2);
            let rest = target
                - i64::from(RATE_GAIN) * i64::from(rate)
                - i64::from(WHEEL_SPEED_GAIN) * i64::from(wheel_speed);
            let angle = i32::try_from(rest / i64::from(ANGLE_GAIN)).ok()?;
            Some([angle, rate, wheel_speed])
        },
    )
}

#[test]
fn the_bound_is_no_larger_than_it_must_be() {
    // The commands' differences use up what the decay leaves, but for a hundredth.
    for mode in &MODES {
        let left = (COORDINATE_MAX << 30) - mode.decay * COORDINATE_MAX;
        let gains: i64 = [ANGLE_GAIN, RATE_GAIN, WHEEL_SPEED_GAIN]
            .into_iter()
            .map(|gain| i64::from(gain).abs())
            .sum();
        let worst = (16 << (generated::control::SHIFT - 1)) + i64::from(HALF_WORD) * gains;
        let used = mode.input * worst + mode.rest;
        assert!(
            left > 0 && used <= left && used * 100 > left * 99,
            "{mode:?}: {used} of {left}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn each_mode_stays_in_its_interval(
        coordinate in prop_oneof![
            Just(COORDINATE_MAX), Just(-COORDINATE_MAX), -COORDINATE_MAX..=COORDINATE_MAX
        ],
        states in states(),
        parts in prop::array::uniform3(prop_oneof![
            Just(-HALF_WORD), Just(HALF_WORD), -HALF_WORD..=HALF_WORD
        ]),
    ) {
        for mode in &MODES {
            difference_stays(mode, coordinate, states, parts);
        }
    }
}

/// The property is not empty: most of the states above do not saturate.
#[test]
fn a_state_that_does_not_saturate_counts() {
    assert!(difference_stays(
        &MODES[0],
        COORDINATE_MAX,
        [0; 3],
        [HALF_WORD; 3]
    ));
    assert!(!difference_stays(&MODES[0], 0, [i32::MAX; 3], [0; 3]));
}
