//! The properties of the supervisor on extreme and random words, and on runs of samples.

use generated::constants::LIMITS;
use generated::supervisor::{Counters, Status, Window};
use generated::{Controller, SAMPLE_TIME_US, Sample, ZERO_CURRENT};
use proptest::prelude::*;
use verify::properties::supervisor::{
    a_fault_lasts, arming_needs_sound_sensors, counts_are_bounded, each_limit_trips,
    observation_is_total, windows_are_of_quiet_samples,
};

/// Upright at rest, with a gyroscope whose words move.
fn upright(step: i32) -> Sample {
    Sample {
        gyro: [(step % 7) as i16, (step % 3) as i16, (step % 5) as i16],
        accel: [4096, (step % 9) as i16 - 4, (step % 4) as i16],
        mag: None,
        wheel_adc: 773,
    }
}

fn running() -> Controller {
    let mut controller = Controller::new();
    for step in 0..=LIMITS.window {
        assert_eq!(controller.step(&upright(step)).0, ZERO_CURRENT);
    }
    assert_eq!(controller.status(), Status::Ready);
    assert!(controller.arm());
    controller
}

#[test]
fn before_its_first_sample_nothing_is_armed() {
    let mut controller = Controller::new();
    assert_eq!(controller.status(), Status::NotAligned);
    assert!(!controller.arm());
    assert_eq!(controller.step(&upright(0)).0, ZERO_CURRENT);
    assert!(!controller.arm());
}

/// Each fault alone ends the current after its steps and not before, with its name; only arming,
/// after a new window, ends the trip.
#[test]
fn each_fault_trips_in_its_time() {
    type Fault = fn(&mut Sample);
    let faults: [(Status, i32, Fault); 6] = [
        (Status::TrippedFrozen, LIMITS.frozen_steps + 1, |s| {
            s.gyro = [9; 3]
        }),
        (Status::TrippedClipped, LIMITS.clipped_steps, |s| {
            s.gyro[2] = 32_767
        }),
        (Status::TrippedClipped, LIMITS.clipped_steps, |s| {
            s.accel[1] = -32_768
        }),
        (Status::TrippedWheelSpeed, LIMITS.wheel_steps, |s| {
            s.wheel_adc = 0
        }),
        (Status::TrippedWheelSpeed, LIMITS.wheel_steps, |s| {
            s.wheel_adc = 4095
        }),
        (Status::TrippedAccelerometer, LIMITS.rejected_steps, |s| {
            s.accel = [0; 3]
        }),
    ];
    for (status, steps, fault) in faults {
        let mut controller = running();
        for step in 1..steps {
            let mut sample = upright(step);
            fault(&mut sample);
            controller.step(&sample);
            assert_eq!(
                controller.status(),
                Status::Running,
                "{status:?}, step {step}"
            );
        }
        let mut sample = upright(steps);
        fault(&mut sample);
        assert_eq!(controller.step(&sample).0, ZERO_CURRENT, "{status:?}");
        assert_eq!(controller.status(), status);
        // The sensor recovers: no current before it was aligned and armed again.
        for step in 0..=LIMITS.window {
            assert!(!controller.arm() || step >= LIMITS.window, "{status:?}");
            if controller.status() == Status::Running {
                break;
            }
            assert_eq!(controller.step(&upright(step)).0, ZERO_CURRENT);
        }
        assert!(controller.arm(), "{status:?}");
    }
}

#[test]
fn the_times_are_those_of_the_issue() {
    let steps = |seconds: f64| (seconds * 1e6 / f64::from(SAMPLE_TIME_US)).round() as i32;
    assert_eq!(LIMITS.wheel_steps, steps(0.020));
    assert_eq!(LIMITS.clipped_steps, steps(0.010));
    assert_eq!(LIMITS.rejected_steps, steps(2.0));
}

/// A body that lies on its side, hangs, or is carried about is not driven.
#[test]
fn a_body_far_from_upright_is_not_armed() {
    for accel in [[0, 4096, 0], [-4096, 0, 0], [2900, 2900, 0]] {
        let mut controller = Controller::new();
        for step in 0..2 * LIMITS.window {
            let sample = Sample {
                accel,
                ..upright(step)
            };
            controller.step(&sample);
        }
        assert_eq!(controller.status(), Status::Ready);
        assert!(!controller.arm(), "{accel:?}");
    }
}

/// A first sample that is off by 0.2 g or by 20° is forgotten.
#[test]
fn a_bad_first_sample_does_not_matter() {
    let run = |first: [i16; 3]| {
        let mut controller = Controller::new();
        controller.step(&Sample {
            accel: first,
            ..upright(0)
        });
        for step in 0..=LIMITS.window {
            controller.step(&upright(step));
        }
        assert_eq!(controller.status(), Status::Ready);
        controller.attitude().angle().to_num::<f64>()
    };
    let good = run([4096, 0, 0]);
    for first in [
        [4915, 0, 0],
        [3849, 1401, 0],
        [3849, -1401, 0],
        [32_767, 0, 0],
    ] {
        assert!((run(first) - good).abs() < 1e-4, "{first:?}");
    }
}

fn counters() -> impl Strategy<Value = Counters> {
    let count = || prop_oneof![0..3000u16, any::<u16>()];
    (
        count(),
        count(),
        count(),
        count(),
        count(),
        any::<[i16; 3]>(),
    )
        .prop_map(
            |(wheel, clipped, frozen, rejected, saturated, gyro)| Counters {
                wheel,
                clipped,
                frozen,
                rejected,
                saturated,
                gyro,
            },
        )
}

fn readings() -> impl Strategy<Value = [i32; 3]> {
    prop::array::uniform3(-0x2000_0000..=0x2000_0000i32)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn counts(count in any::<u16>(), holds in any::<bool>(), limit in 1..i32::MAX) {
        counts_are_bounded(count, holds, limit);
    }

    #[test]
    fn judgements(
        counters in counters(),
        angle in any::<i32>(),
        rate in any::<i32>(),
        gyro in any::<[i16; 3]>(),
        flags in any::<(bool, bool)>(),
        wheel in any::<u16>(),
    ) {
        each_limit_trips(&counters, angle);
        each_limit_trips(&counters, angle % LIMITS.angle_trip);
        arming_needs_sound_sensors(&counters, angle % LIMITS.angle_trip, rate % LIMITS.rate_arm);
        observation_is_total(&counters, gyro, flags.0, flags.1, wheel.into());
    }

    #[test]
    fn windows(
        count in any::<u16>(), first in any::<[i16; 3]>(), sum in readings(), up in readings(),
        is_quiet in any::<bool>(),
    ) {
        windows_are_of_quiet_samples(&Window { count, first, sum }, up, is_quiet);
        windows_are_of_quiet_samples(&Window { count, first: up.map(|word| (word >> 15) as i16), sum }, up, is_quiet);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]

    #[test]
    fn faults_last(gyro in any::<[i16; 3]>(), wheel_adc in any::<u16>(), steps in 1..600i32) {
        let samples: Vec<Sample> = (0..steps)
            .map(|step| if step % 3 == 0 {
                Sample { gyro, wheel_adc, ..upright(step) }
            } else {
                upright(step)
            })
            .collect();
        a_fault_lasts(&mut running(), &samples);
    }
}
