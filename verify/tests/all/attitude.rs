//! The properties of filter and step on extreme and random readings.

use generated::filter::FilterState;
use generated::{Controller, Sample};
use proptest::prelude::*;
use verify::properties::attitude::{
    RATE_MAX, has_unit_length, in_ranges, starts_in_the_invariant, step_keeps_length,
    step_keeps_ranges, tracked_step_keeps_ranges,
};
use verify::properties::step::duty_within_limits;

const DRIFT: i32 = generated::constants::FILTER.drift.limit;

const EXTREMES: [i16; 5] = [i16::MIN, -1, 0, 1, i16::MAX];

#[test]
fn start() {
    starts_in_the_invariant();
}

/// Every combination of extreme readings, one after the other, so that each meets the state that
/// the others leave behind.
#[test]
fn every_combination_of_extreme_readings() {
    let mut controller = Controller::new();
    for gyro in triples() {
        for accel in triples() {
            for mag in [
                None,
                Some([0; 3]),
                Some([i16::MIN, 0, 1]),
                Some([300, 0, -400]),
            ] {
                for wheel_adc in [0, 4095, u16::MAX] {
                    let sample = Sample {
                        gyro,
                        accel,
                        mag,
                        wheel_adc,
                    };
                    duty_within_limits(&mut controller, &sample, wheel_adc != 4095);
                }
            }
        }
    }
}

fn triples() -> impl Iterator<Item = [i16; 3]> {
    (0..125).map(|index| {
        [
            EXTREMES[index % 5],
            EXTREMES[index / 5 % 5],
            EXTREMES[index / 25],
        ]
    })
}

fn counts() -> impl Strategy<Value = [i16; 3]> {
    let axis = prop_oneof![
        3 => any::<i16>(),
        1 => prop::sample::select(EXTREMES.to_vec()),
        1 => -600..600i16,
    ];
    [axis.clone(), axis.clone(), axis]
}

fn sample() -> impl Strategy<Value = Sample> {
    (counts(), counts(), prop::option::of(counts()), any::<u16>()).prop_map(
        |(gyro, accel, mag, wheel_adc)| Sample {
            gyro,
            accel,
            mag,
            wheel_adc,
        },
    )
}

/// States of the right length, up to the ends of the tolerance.
fn unit_state() -> impl Strategy<Value = FilterState> {
    let rate = -RATE_MAX..=RATE_MAX;
    (
        prop::array::uniform4(-1.0..1.0f64),
        -1.0..1.0f64,
        rate.clone(),
        rate,
    )
        .prop_filter_map("a direction", |(direction, length, rate, slow_rate)| {
            let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            let scale = (1.0 + length / 4100.0) / norm * f64::from(1 << 30);
            let quaternion = direction.map(|c| (c * scale) as i32);
            let state = FilterState {
                quaternion,
                rate,
                slow_rate,
            };
            (norm > 1e-3 && has_unit_length(&state)).then_some(state)
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn ranges_are_kept_from_any_components(
        quaternion in prop::array::uniform4(-0x4004_0000..=0x4004_0000i32),
        rate in -RATE_MAX..=RATE_MAX, slow_rate in -RATE_MAX..=RATE_MAX,
        gyro in counts(), accel in counts(), mag in counts(),
    ) {
        let state = FilterState { quaternion, rate, slow_rate };
        prop_assert!(in_ranges(&state));
        step_keeps_ranges(&state, gyro, accel, mag);
    }

    #[test]
    fn ranges_are_kept_with_any_drift(
        quaternion in prop::array::uniform4(-0x4004_0000..=0x4004_0000i32),
        rate in -RATE_MAX..=RATE_MAX, slow_rate in -RATE_MAX..=RATE_MAX,
        drift in prop::array::uniform3(-DRIFT..=DRIFT), gyro in counts(), accel in counts(),
    ) {
        let state = FilterState { quaternion, rate, slow_rate };
        tracked_step_keeps_ranges(&state, drift, gyro, accel);
    }

    #[test]
    fn length_is_kept(state in unit_state(), gyro in counts(), accel in counts(), mag in counts()) {
        step_keeps_length(&state, gyro, accel, mag);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn duty_is_within_limits_over_runs(
        samples in prop::collection::vec((sample(), any::<bool>()), 1..100),
    ) {
        let mut controller = Controller::new();
        for (sample, is_armed) in &samples {
            duty_within_limits(&mut controller, sample, *is_armed);
        }
    }
}
