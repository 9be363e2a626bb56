//! The words around the control law: converter, duty, rate and the observer of the angle's bias.

use crate::thesis;

use attitude::AttitudeSpec;
use codegen::control;
use codegen::hardware::{BiasObserverSpec, BodySensor, HardwareSpec};
use codegen::hardware_words::{BodyWords, DutyWords, InertialWords, derive};
use codegen::helpers::bias_observer::BiasObserver;
use codegen::helpers::bias_observer::{advanced, estimated_bias, waiting};
use codegen::helpers::line::on_line;
use codegen::spec::ModuleSpec;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

const ANGLE: f64 = (1u64 << 29) as f64;
const RATE: f64 = (1u64 << 25) as f64;
const WHEEL_SPEED: f64 = (1u64 << 21) as f64;
const CURRENT: f64 = (1u64 << 29) as f64;

/// Every count of the converter against rpm = 8.53108 count − 6594.5.
#[test]
fn wheel_speed_of_every_count() {
    let spec = thesis::spec();
    let words = derive(&spec, &control::derive(&spec).unwrap()).unwrap();
    let range = spec.ranges.wheel_speed_rad_s;
    for adc in 0..=u16::MAX {
        let exact = (8.53108 * f64::from(adc) - 6594.5) * TAU / 60.0;
        let found = f64::from(on_line(i32::from(adc), &words.wheel_speed)) / WHEEL_SPEED;
        // Half a unit, and the slope's rounding over the counts.
        assert!(
            (found - exact.clamp(-range, range)).abs() < 1e-6,
            "{adc}: {found} {exact}"
        );
    }
}

/// The whole range of currents and beyond: within half a count of the drive's line, within 10 %
/// and 90 %, and never stepping back.
#[test]
fn duty_of_every_current() {
    let spec = thesis::spec();
    let words = derive(&spec, &control::derive(&spec).unwrap()).unwrap();
    let DutyWords::Line(line) = &words.duty else {
        panic!("{:?}", words.duty);
    };
    assert_eq!(on_line(0, line), 32_768);
    let mut last = 0;
    for word in (i64::from(i32::MIN)..=i64::from(i32::MAX)).step_by(1009) {
        let duty = on_line(word as i32, line);
        let exact = 32_768.0 + word as f64 / CURRENT * (26_214.0 / 2.2);
        assert!(
            (f64::from(duty) - exact.clamp(6554.0, 58_982.0)).abs() <= 0.5001,
            "{word}"
        );
        assert!(duty >= last);
        last = duty;
    }
    assert_eq!(
        [on_line(i32::MIN, line), on_line(i32::MAX, line)],
        [6554, 58_982]
    );
}

proptest! {
    #[test]
    fn rate_words(half_angle in -0x2000_0000..=0x2000_0000) {
        let spec = thesis::spec();
        let words = inertial_words(&spec);
        let exact = f64::from(half_angle) / 2f64.powi(32) * 2.0 / 1e-3;
        let limit = f64::from(i32::MAX) / RATE;
        let rate = f64::from(on_line(half_angle, &words.rate)) / RATE;
        prop_assert!((rate - exact.clamp(-limit, limit)).abs() <= 1.5e-8 + 2e-9 * exact.abs());
    }
}

/// The observer of the design for the thesis bench: decay in 1 s, built here from its definition
/// ℓ ∝ R⁻¹c, c = (I − Ad)e₁, for the noise (2 mrad, 1 mrad/s, 0.5 rad/s).
fn observer(spec: &ModuleSpec) -> BiasObserverSpec {
    let trace = [1.0 - spec.ad[0][0], -spec.ad[1][0], -spec.ad[2][0]];
    let weighted: Vec<f64> = trace
        .iter()
        .zip([2e-3_f64, 1e-3, 0.5])
        .map(|(c, n)| c / (n * n))
        .collect();
    let seen: f64 = weighted.iter().zip(trace).map(|(w, c)| w * c).sum();
    let decay = (-spec.sample_time_s).exp();
    let direct = [0, 1, 2].map(|i| weighted[i] * (1.0 - decay) / seen);
    let column = |j: usize| (0..3).map(|i| direct[i] * spec.ad[i][j]).sum::<f64>();
    BiasObserverSpec {
        decay,
        direct,
        from_states: [0, 1, 2].map(|j| decay * direct[j] - column(j)),
        from_current: -(0..3).map(|i| direct[i] * spec.bd[i]).sum::<f64>(),
        limit_rad: 0.1,
    }
}

fn inertial_words(spec: &ModuleSpec) -> InertialWords {
    match derive(spec, &control::derive(spec).unwrap()).unwrap().body {
        BodyWords::Inertial(words) => *words,
        BodyWords::Encoder(_) => panic!("the bench of the thesis is inertial"),
    }
}

/// The words of the observer.
fn observer_words(spec: &ModuleSpec) -> BiasObserver {
    inertial_words(spec).bias_observer
}

fn inertial(hardware: &mut HardwareSpec) -> &mut AttitudeSpec {
    match &mut hardware.body {
        BodySensor::Inertial(attitude) => attitude,
        BodySensor::Encoder(_) => panic!("the bench of the thesis is inertial"),
    }
}

/// Runs the sampled linear plant with an angle that is measured 1° too large; returns the wheel
/// speed and the estimate (rad) at the end.
fn run(with_observer: bool, seconds: f64) -> (f64, f64) {
    let mut spec = thesis::spec();
    if with_observer {
        let bias_observer = Some(observer(&spec));
        spec.hardware = HardwareSpec {
            bias_observer,
            ..HardwareSpec::thesis_bench()
        };
    }
    let words = observer_words(&spec);
    let bias = 1.0_f64.to_radians();
    let mut x = [0.0; 3];
    let mut z = 0;
    let mut estimate = 0;
    for step in 0..(seconds / spec.sample_time_s) as usize {
        let states = [
            ((x[0] + bias) * ANGLE).round() as i32,
            (x[1] * RATE).round() as i32,
            (x[2] * WHEEL_SPEED).round() as i32,
        ];
        if step == 0 {
            z = waiting(states, &words);
            assert_eq!(estimated_bias(z, states, &words), 0);
        }
        estimate = estimated_bias(z, states, &words);
        let measured = [
            f64::from(states[0] - estimate) / ANGLE,
            f64::from(states[1]) / RATE,
            f64::from(states[2]) / WHEEL_SPEED,
        ];
        let command: f64 = -(0..3).map(|i| spec.gains[i] * measured[i]).sum::<f64>();
        let current = command.clamp(-2.0, 2.0);
        z = advanced(z, states, (current * CURRENT).round() as i32, &words);
        x = [0, 1, 2]
            .map(|i| (0..3).map(|j| spec.ad[i][j] * x[j]).sum::<f64>() + spec.bd[i] * current);
    }
    (x[2], f64::from(estimate) / ANGLE)
}

/// One degree costs 19.2 rad/s of wheel speed without the observer and nothing with it.
#[test]
fn the_observer_stops_the_wheel() {
    let (speed, estimate) = run(false, 20.0);
    assert!((speed + 19.2).abs() < 0.05, "{speed}");
    assert_eq!(estimate, 0.0);
    let (speed, estimate) = run(true, 20.0);
    println!(
        "with the observer: {speed:.2e} rad/s, estimate off by {:.2e} rad",
        estimate - 1.0_f64.to_radians()
    );
    // Half a unit of z through the decay of 1e-3 a step: 4.7e-7 rad, or 5e-4 rad/s.
    assert!((estimate - 1.0_f64.to_radians()).abs() < 5e-7, "{estimate}");
    assert!(speed.abs() < 1e-3, "{speed}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    /// Any words: no overflow, and the estimate within its limit.
    #[test]
    fn the_observer_is_total(z in -i32::MAX..=i32::MAX, states in any::<[i32; 3]>(), current in any::<i32>()) {
        let mut spec = thesis::spec();
        spec.hardware.bias_observer = Some(observer(&spec));
        let words = observer_words(&spec);
        let limit = words.limit;
        prop_assert!(estimated_bias(z, states, &words).abs() <= limit);
        advanced(z, states, current, &words);
        let waiting = waiting(states, &words);
        prop_assert!(estimated_bias(waiting, states, &words).abs() <= limit);
    }
}

/// The word of an angle for coarse and fine formats: exact where it fits, at the end elsewhere.
#[test]
fn angle_words() {
    for (range, bits) in [(PI, 29), (100.0, 24), (0.3, 32)] {
        let mut spec = thesis::spec();
        spec.ranges.angle_rad = range;
        let law = control::derive(&spec).unwrap();
        assert_eq!(law.terms[0].input.format.fraction_bits, bits);
        let words = inertial_words(&spec);
        for radians in (-843_314_858..=843_314_858).step_by(100_003) {
            let clamped = radians.clamp(-words.angle_max, words.angle_max);
            let word = (clamped * words.angle_factor) >> words.angle_shift;
            let unit = 2f64.powi(-(bits as i32));
            let end = f64::from(i32::MAX) * unit;
            let exact = (f64::from(radians) / 2f64.powi(28)).clamp(-end, end);
            assert!((f64::from(word) * unit - exact).abs() <= unit.max(2f64.powi(-28)));
        }
    }
}

#[test]
fn numbers_that_do_not_fit_are_refused() {
    let spec = thesis::spec();
    let law = control::derive(&spec).unwrap();
    let mut cases: Vec<(&str, ModuleSpec)> = Vec::new();
    let mut case = |expected, change: &dyn Fn(&mut HardwareSpec)| {
        let mut changed = spec.clone();
        change(&mut changed.hardware);
        cases.push((expected, changed));
    };
    case("beta", &|h| inertial(h).beta_rad_s = 10.0);
    case("beta", &|h| inertial(h).beta_rad_s = f64::NAN);
    case("gravity", &|h| inertial(h).gravity_m_s2 = 0.0);
    case("gyroscope's scale", &|h| inertial(h).gyro.matrix *= 10.0);
    case("accelerometer's scale", &|h| {
        inertial(h).accel.matrix *= 0.0
    });
    case("magnetometer's bias", &|h| {
        inertial(h).mag.bias_counts[1] = 9000.0
    });
    case("lever arm", &|h| inertial(h).lever_arm_m[0] = 100.0);
    case("lever arm", &|h| inertial(h).lever_arm_m[1] = f64::INFINITY);
    case("mounting", &|h| inertial(h).mounting_angle_rad = f64::NAN);
    case("wheel speed", &|h| h.wheel_speed_per_count = 0.0);
    case("wheel speed", &|h| h.wheel_speed_at_zero = f64::NAN);
    for (expected, changed) in cases {
        let error = derive(&changed, &law).unwrap_err().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
    }
}
