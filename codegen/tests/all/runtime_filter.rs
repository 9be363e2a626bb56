//! The emitted filter against the reference in double precision, both on the same raw counts.
//!
//! Limits (the figures of the contract): 0.05° RMS and 0.2° at worst between the two attitudes,
//! length within 1e-3. Overflow would panic: the tests are built with overflow checks.

use attitude::{AttitudeSpec, RawFilter, SensorLine as RealLine, wrap_angle};
use codegen::attitude::{derive, mounting_word};
use codegen::helpers::arc_tangent::PI_Q28;
use codegen::helpers::calibration::SensorLine;
use codegen::helpers::drift::DriftGain;
use codegen::helpers::filter::{FilterConstants, FilterState, START, align, headed, step_imu};
use codegen::helpers::lever_arm::LeverArm;
use codegen::helpers::madgwick::COMPONENT_MAX;
use codegen::helpers::pivot_angle::pivot_angle;
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::PI;

/// One sample of raw counts.
#[derive(Clone, Copy, Debug)]
struct Raw {
    gyro: [i16; 3],
    accel: [i16; 3],
    mag: [i16; 3],
}

fn quaternion(state: &FilterState) -> Quaternion<f64> {
    let [w, x, y, z] = state
        .quaternion
        .map(|word| f64::from(word) / f64::from(1 << 30));
    Quaternion::new(w, x, y, z)
}

/// Angle of the turn between two attitudes, degrees.
fn turn_deg(a: &Quaternion<f64>, b: &Quaternion<f64>) -> f64 {
    let between = a.conjugate() * b;
    (2.0 * between.imag().norm().atan2(between.w.abs())).to_degrees()
}

/// Differences over a run, in degrees.
#[derive(Default, Debug)]
struct Difference {
    squares: f64,
    worst: f64,
    worst_pivot: f64,
    worst_length: f64,
    count: f64,
}

impl Difference {
    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }

    fn assert_within_limits(&self, name: &str) {
        println!(
            "{name}: {:.6}° RMS, {:.6}° worst, pivot angle {:.6}° worst, length {:.1e}",
            self.rms(),
            self.worst,
            self.worst_pivot,
            self.worst_length
        );
        assert!(self.rms() <= 0.05, "{name}: {self:?}");
        assert!(self.worst <= 0.2, "{name}: {self:?}");
        assert!(self.worst_pivot <= 0.2, "{name}: {self:?}");
        assert!(self.worst_length <= 1e-3, "{name}: {self:?}");
    }
}

/// Runs both filters over the same counts.
fn compare(spec: &AttitudeSpec, samples: impl Iterator<Item = Raw>, nine_axes: bool) -> Difference {
    let constants = derive(spec).expect("a specification that fits");
    let mounting = mounting_word(spec.mounting_angle_rad).expect("a finite angle");
    let mut reference = RawFilter::new(spec);
    let mut state = START;
    let mut difference = Difference::default();
    // Without the gyroscope's drift: its estimate adds up the signs of corrections, which differ where a correction is
    // smaller than the rounding. `runtime_drift.rs` compares it.
    for raw in samples {
        reference.update_imu(raw.gyro, raw.accel);
        state = step_imu(&state, raw.gyro, raw.accel, &constants);
        if nine_axes {
            reference.turn_to_north(raw.mag);
            state = headed(&state, raw.mag, &constants);
        }
        let (found, exact) = (quaternion(&state), reference.quaternion());
        let turn = turn_deg(&found, &exact);
        difference.squares += turn * turn;
        difference.worst = difference.worst.max(turn);
        difference.worst_length = difference.worst_length.max((found.norm() - 1.0).abs());
        difference.count += 1.0;
        // The pivot angle is defined where gravity has a part across the axis.
        let up = attitude::up_in_sensor(&exact);
        let across = up.x.hypot(up.y);
        let word = pivot_angle(state.quaternion, mounting);
        let angle = f64::from(word) / f64::from(1 << 28);
        let error = wrap_angle(angle - reference.angle_rad()).to_degrees() * across;
        difference.worst_pivot = difference.worst_pivot.max(error.abs());
    }
    difference
}

/// The nearest count, at the limit of the range where the value lies beyond it.
fn to_counts(value: f64) -> i16 {
    value
        .round()
        .clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16
}

/// A sensor carried through ten minutes of everything: rest, slow turning, tumbling up to and
/// beyond the gyroscope's limit, free fall, vibration, impacts that saturate the accelerometer,
/// and magnetic disturbance. Counts are quantised, biased and noisy.
struct LargeMotion {
    rng: ChaCha8Rng,
    normal: Normal<f64>,
    attitude: UnitQuaternion<f64>,
    rate: Vector3<f64>,
    period_s: f64,
    step: usize,
    steps: usize,
    gyro_scale: f64,
    counts_per_g: f64,
    counts_per_ut: f64,
}

impl LargeMotion {
    fn new(seed: u64, spec: &AttitudeSpec, seconds: f64) -> Self {
        println!("seed {seed}");
        LargeMotion {
            rng: ChaCha8Rng::seed_from_u64(seed),
            normal: Normal::new(0.0, 1.0).expect("a standard deviation of one"),
            attitude: UnitQuaternion::identity(),
            rate: Vector3::zeros(),
            period_s: spec.sample_time_s,
            step: 0,
            steps: (seconds / spec.sample_time_s) as usize,
            gyro_scale: spec.gyro.matrix.column(0).norm(),
            counts_per_g: spec.gravity_m_s2 / spec.accel.matrix.column(0).norm(),
            counts_per_ut: 1.0 / spec.mag.matrix.column(0).norm(),
        }
    }

    fn noise(&mut self, deviation: f64) -> Vector3<f64> {
        let Self { rng, normal, .. } = self;
        deviation * Vector3::from_fn(|_, _| normal.sample(rng))
    }
}

impl Iterator for LargeMotion {
    type Item = Raw;

    fn next(&mut self) -> Option<Raw> {
        if self.step == self.steps {
            return None;
        }
        let time = self.step as f64 * self.period_s;
        self.step += 1;
        // Six regimes of five seconds, over and over.
        let regime = (time / 5.0) as usize % 6;
        let limit = self.gyro_scale * 32_768.0;
        let wanted = match regime {
            0 => Vector3::zeros(),
            1 => Vector3::new(0.3, 0.2, 1.0) * (2.0 * time).sin(),
            2 => {
                Vector3::new((1.1 * time).sin(), (1.7 * time).cos(), (0.9 * time).sin())
                    * 0.5
                    * limit
            }
            3 => Vector3::new((2.1 * time).cos(), (0.7 * time).sin(), 1.0) * 1.02 * limit,
            4 => Vector3::new(0.0, 0.0, 6.0 * (8.0 * time).sin()),
            _ => Vector3::new(3.0, -2.0, 5.0),
        };
        let shake = self.noise(0.002);
        self.rate += (wanted - self.rate) * (self.period_s / 0.05) + shake;
        self.attitude *= UnitQuaternion::from_scaled_axis(self.rate * self.period_s);
        let up = self.attitude.inverse() * Vector3::z();
        let linear = match regime {
            // Vibration of 3 g at 87 Hz.
            1 | 4 => Vector3::new(1.0, 0.6, -0.8) * 3.0 * (2.0 * PI * 87.0 * time).sin(),
            // Free fall for a second in each five.
            2 if time % 5.0 < 1.0 => -up,
            // An impact beyond the range every half second.
            5 if time % 0.5 < 0.004 => Vector3::new(12.0, -15.0, 9.0),
            _ => Vector3::zeros(),
        };
        let accel =
            (up + linear) * self.counts_per_g + self.noise(25.0) + Vector3::new(40.0, -25.0, 10.0);
        let gyro = self.rate / self.gyro_scale + self.noise(4.0) + Vector3::new(6.0, -9.0, 3.0);
        let disturbance = if regime == 2 {
            30.0 * (3.0 * time).sin()
        } else {
            0.0
        };
        let field = Vector3::new(20.0, 0.0, -44.0 + disturbance);
        let mag = (self.attitude.inverse() * field) * self.counts_per_ut + self.noise(8.0);
        let counts = |v: Vector3<f64>| [to_counts(v.x), to_counts(v.y), to_counts(v.z)];
        // Now and then a dropped or stuck reading.
        let accel = if self.rng.random_bool(1e-4) {
            [0; 3]
        } else {
            counts(accel)
        };
        Some(Raw {
            gyro: counts(gyro),
            accel,
            mag: counts(mag),
        })
    }
}

#[test]
fn ten_minutes_of_large_motion() {
    let spec = AttitudeSpec::thesis();
    for (nine_axes, seed, name) in [(false, 11, "six axes"), (true, 12, "nine axes")] {
        compare(&spec, LargeMotion::new(seed, &spec, 600.0), nine_axes).assert_within_limits(name);
    }
}

/// Bias, cross-axis terms, mounting, a lever arm, another gyroscope range and a slower clock.
#[test]
fn other_benches() {
    let cross = Matrix3::new(1.0, 0.02, -0.01, 0.015, 0.98, 0.03, -0.02, 0.01, 1.03);
    let line = |scale: f64, bias: Vector3<f64>| RealLine {
        bias_counts: bias,
        matrix: cross * scale,
    };
    let thesis = AttitudeSpec::thesis();
    let calibrated = AttitudeSpec {
        gyro: line(62.5e-3_f64.to_radians(), Vector3::new(6.3, -9.1, 2.7)),
        accel: line(9.81 / 4096.0, Vector3::new(41.7, -24.2, 9.9)),
        mag: line(0.1, Vector3::new(-210.5, 77.3, 12.8)),
        mounting_angle_rad: 0.75 * PI,
        lever_arm_m: [0.06, -0.02],
        ..thesis
    };
    let slow = AttitudeSpec {
        sample_time_s: 3.5e-3,
        beta_rad_s: 0.1,
        ..thesis
    };
    let fine = AttitudeSpec {
        gyro: RealLine::ideal(7.8125e-3_f64.to_radians()),
        beta_rad_s: 0.01,
        ..thesis
    };
    for (spec, name) in [
        (calibrated, "calibrated"),
        (slow, "3.5 ms"),
        (fine, "±250 °/s"),
    ] {
        for nine_axes in [false, true] {
            let motion = LargeMotion::new(21, &spec, 60.0);
            compare(&spec, motion, nine_axes)
                .assert_within_limits(&format!("{name}, nine axes {nine_axes}"));
        }
    }
}

/// Sensors of other makers on other clocks, mounted in any direction: sample rate (Hz), ranges
/// (°/s, g, µT), β (rad/s).
#[test]
fn any_sample_rate_range_and_mounting() {
    let cases: [(f64, f64, f64, f64, f64); 7] = [
        (100.0, 500.0, 8.0, 4912.0, 0.1),
        (200.0, 1000.0, 16.0, 1229.0, 0.033),
        (286.0, 2000.0, 16.0, 4912.0, 0.04),
        (286.0, 1000.0, 4.0, 800.0, 0.5),
        (500.0, 500.0, 2.0, 1600.0, 0.1),
        (1000.0, 4000.0, 32.0, 4912.0, 0.02),
        (2000.0, 250.0, 4.0, 1600.0, 0.033),
    ];
    for (seed, (rate_hz, dps, g, ut, beta_rad_s)) in (31u64..).zip(cases) {
        println!("mounting of seed {seed}");
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        // The sensor's z axis within 40° of the pivot axis; the turn about it is the mounting angle.
        let direction = rng.random_range(-PI..PI);
        let tilt_rad = rng.random_range(0.0..0.7);
        let across = Vector3::new(f64::cos(direction), f64::sin(direction), 0.0) * tilt_rad;
        let mounted = UnitQuaternion::from_scaled_axis(across).to_rotation_matrix();
        let line = |range: f64| RealLine {
            bias_counts: Vector3::new(17.3, -31.9, 5.2),
            matrix: mounted.matrix() * (range / 32_768.0),
        };
        let spec = AttitudeSpec {
            sample_time_s: 1.0 / rate_hz,
            beta_rad_s,
            gyro: line(dps.to_radians()),
            accel: line(g * attitude::STANDARD_GRAVITY),
            mag: line(ut),
            mounting_angle_rad: rng.random_range(-PI..PI),
            ..AttitudeSpec::thesis()
        };
        for nine_axes in [false, true] {
            let motion = LargeMotion::new(seed, &spec, 120.0);
            compare(&spec, motion, nine_axes).assert_within_limits(&format!(
                "{rate_hz} Hz, ±{dps} °/s, ±{g} g, ±{ut} µT, nine axes {nine_axes}"
            ));
        }
    }
}

/// From any start the filter finds a vertical that stands still: in the sensor's frame within the
/// turn at β rad/s (half a turn takes π/β), whatever the attitude it began with.
#[test]
fn every_start_converges() {
    let spec = AttitudeSpec {
        sample_time_s: 3.5e-3,
        beta_rad_s: 0.5,
        ..AttitudeSpec::thesis()
    };
    let constants = derive(&spec).expect("a specification that fits");
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    println!("seed 9");
    let steps = (2.0 * PI / spec.beta_rad_s / spec.sample_time_s) as usize;
    for case in 0..60 {
        let up = Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0)).normalize();
        let accel = [0, 1, 2].map(|axis| to_counts(up[axis] * 4096.0));
        let mut field: Vector3<f64> = Vector3::from_fn(|_, _| rng.random_range(-400.0..400.0));
        field -= up * (field.dot(&up) + 200.0);
        let mag = [0, 1, 2].map(|axis| to_counts(field[axis]));
        let mut state = START;
        for _ in 0..steps {
            state = step_imu(&state, [0; 3], accel, &constants);
            if case % 2 == 1 {
                state = headed(&state, mag, &constants);
            }
        }
        let found = attitude::up_in_sensor(&quaternion(&state));
        let measured = Vector3::from(accel.map(f64::from)).normalize();
        let error = found.cross(&measured).norm().atan2(found.dot(&measured));
        // What the last steps of fixed length β T leave, for four components.
        let allowed = 4.0 * spec.beta_rad_s * spec.sample_time_s;
        assert!(error < allowed, "case {case}: {up} {error}");
    }
}

/// Fields of any size and direction, from step to step, for minutes: the pivot's angle stays that of six axes, to the
/// rounding of the turn, which the accelerometer keeps from adding up.
#[test]
fn no_field_tilts_the_pivot_angle() {
    let seed = 19;
    println!("seed {seed}");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let constants = derive(&AttitudeSpec::thesis()).expect("a specification that fits");
    let mounting = mounting_word(0.0).expect("a finite angle");
    let (mut with, mut without) = (START, START);
    let accel = [0, 1, 2].map(|axis| [4096, 300, 40][axis]);
    for state in [&mut with, &mut without] {
        *state = align(state, accel, &constants).0;
    }
    let (mut worst, mut turned) = (0, 0.0_f64);
    let mut field = [0; 3];
    for step in 0..300_000 {
        // A field that stays for a while, as a magnet's, or jumps with every step.
        if step % 5000 == 0 || (step / 20_000) % 2 == 1 {
            field = [0; 3].map(|_| rng.random_range(-12_000..12_000));
        }
        let gyro = [0; 3].map(|_| rng.random_range(-4..=4));
        with = headed(&step_imu(&with, gyro, accel, &constants), field, &constants);
        without = step_imu(&without, gyro, accel, &constants);
        let angle = |state: &FilterState| pivot_angle(state.quaternion, mounting);
        worst = worst.max((angle(&with) - angle(&without)).abs());
        turned = turned.max(turn_deg(&quaternion(&with), &quaternion(&without)));
    }
    let worst_rad = f64::from(worst) / f64::from(1 << 28);
    println!("pivot angle apart by {worst_rad:.1e} rad, heading by {turned:.1}°");
    // The field has turned the heading far. Both angles ripple by the relay of the correction, 2 β T, each at its own time.
    assert!(turned > 45.0, "{turned}°");
    let spec = AttitudeSpec::thesis();
    let relay_rad = 2.0 * spec.beta_rad_s * spec.sample_time_s;
    assert!(worst_rad <= 2.0 * relay_rad, "{worst_rad} rad");
}

/// The swing of a physical pendulum (w² = 95/s², from 2.5 rad) with the sensor at (0.1, 0.03) m:
/// the emitted filter with the lever arm follows as the reference does, and without it leans.
#[test]
fn lever_arm_on_a_swing() {
    let seed = 7;
    println!("seed {seed}");
    let arm = [0.1, 0.03];
    let run = |lever_arm_m: [f64; 2]| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, 1.0).expect("a standard deviation of one");
        let spec = AttitudeSpec {
            lever_arm_m,
            beta_rad_s: 0.1,
            ..AttitudeSpec::thesis()
        };
        let constants = derive(&spec).expect("a specification that fits");
        let mut reference = RawFilter::new(&spec);
        let mut state = START;
        let (mut angle, mut rate) = (2.5_f64, 0.0_f64);
        let (mut squares, mut of_reference, mut apart, mut count) = (0.0, 0.0, 0.0_f64, 0.0);
        for step in 0..20_000 {
            let acceleration = -95.0 * angle.sin() - 0.05 * rate;
            let (sin, cos) = (angle - PI).sin_cos();
            let force = Vector3::new(
                spec.gravity_m_s2 * cos - acceleration * arm[1] - rate * rate * arm[0],
                -spec.gravity_m_s2 * sin + acceleration * arm[0] - rate * rate * arm[1],
                0.0,
            );
            let accel = [0, 1, 2].map(|axis| {
                let noise = 20.0 * normal.sample(&mut rng);
                to_counts(force[axis] / spec.accel.matrix[(0, 0)] + noise)
            });
            let mean_rate = rate + 0.5 * spec.sample_time_s * acceleration;
            let noise = 2.0 * normal.sample(&mut rng);
            let gyro = [
                0,
                0,
                to_counts(mean_rate / spec.gyro.matrix[(2, 2)] + noise),
            ];
            if step == 0 {
                reference.align(accel);
                state = align(&state, accel, &constants).0;
            }
            reference.update_imu(gyro, accel);
            state = step_imu(&state, gyro, accel, &constants);
            angle += spec.sample_time_s * mean_rate;
            rate += spec.sample_time_s * acceleration;
            // The start in full motion is misread, which takes 3 s to decay.
            if step > 5000 {
                let found = f64::from(pivot_angle(state.quaternion, 0)) / f64::from(1 << 28);
                squares += wrap_angle(found + PI - angle).powi(2);
                of_reference += wrap_angle(reference.angle_rad() + PI - angle).powi(2);
                apart = apart.max(wrap_angle(found - reference.angle_rad()).abs());
                count += 1.0;
            }
        }
        let rms = |sum: f64| (sum / count).sqrt();
        (rms(squares), rms(of_reference), apart)
    };
    let (corrected, reference, apart) = run(arm);
    let (plain, _, apart_plain) = run([0.0; 2]);
    println!(
        "lever arm corrected {corrected:.4} rad (reference {reference:.4}), not corrected \
         {plain:.4} rad; fixed against reference {apart:.1e}, {apart_plain:.1e} rad at worst"
    );
    let limit_rad = 0.2_f64.to_radians();
    assert!(apart <= limit_rad && apart_plain <= limit_rad);
    // The lag of the derivative, as in the reference's own test.
    assert!(corrected < 0.026, "{corrected}");
    assert!(plain > 5.0 * corrected, "{plain} {corrected}");
}

/// A perfectly still and noiseless sensor is the hardest for the heading, which six axes do not
/// observe: any preferred sign in the rounding adds up.
#[test]
fn ten_still_minutes_do_not_drift() {
    let spec = AttitudeSpec::thesis();
    for accel in [
        [0, 0, 4096],
        [2365, 2365, 2365],
        [4096, 0, 0],
        [-2000, 3500, 700],
    ] {
        for gyro in [[0, 0, 0], [1, -1, 1], [16, 3, -8]] {
            let still = std::iter::repeat_n(
                Raw {
                    gyro,
                    accel,
                    mag: [200, 0, -440],
                },
                600_000,
            );
            compare(&spec, still, false).assert_within_limits(&format!("still {accel:?} {gyro:?}"));
        }
    }
}

/// A rate at the limit of the range, held: the scale's rounding adds up.
#[test]
fn ten_minutes_at_the_rate_limit() {
    let spec = AttitudeSpec::thesis();
    let raw = Raw {
        gyro: [i16::MIN, i16::MAX, 20_000],
        accel: [0; 3],
        mag: [0; 3],
    };
    compare(&spec, std::iter::repeat_n(raw, 600_000), false).assert_within_limits("rate limit");
}

/// A recording at 1 kHz from outside the project, where it is at hand.
#[test]
#[cfg_attr(not(have_recordings), ignore = "needs the recordings")]
fn recording_at_one_kilohertz() {
    let path = concat!(env!("FLYWHEEL_RECORDINGS"), "/real/imu_icm42688_1khz.txt");
    let text = std::fs::read_to_string(path).expect(path);
    let spec = AttitudeSpec::thesis();
    let samples = text.lines().skip(1).map(|line| {
        let value: Vec<f64> = line
            .split_whitespace()
            .map(|field| field.parse().expect("a number"))
            .collect();
        let counts = |v: &[f64], scale: f64| [0, 1, 2].map(|i| to_counts(v[i] / scale));
        Raw {
            accel: counts(&value[0..3], spec.accel.matrix[(0, 0)]),
            gyro: counts(&value[3..6], spec.gyro.matrix[(0, 0)]),
            mag: [0; 3],
        }
    });
    compare(&spec, samples, false).assert_within_limits("recording");
}

#[test]
fn alignment_agrees_with_the_reference() {
    let spec = AttitudeSpec::thesis();
    let constants = derive(&spec).expect("a specification that fits");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut cases: Vec<[i16; 3]> = (0..20_000)
        .map(|_| std::array::from_fn(|_| rng.random_range(-9000..9000)))
        .collect();
    cases.extend([
        [0, 0, -4096],
        [1, 0, -4096],
        [0, 0, 4096],
        [0, 0, 0],
        [i16::MIN, 0, 0],
        [0, 0, 511],
    ]);
    for accel in cases {
        let mut reference = RawFilter::new(&spec);
        reference.align(accel);
        let found = quaternion(&align(&START, accel, &constants).0);
        let error = turn_deg(&found, &reference.quaternion());
        // Next to straight down the shortest turn is ill-defined by 2⁻²⁷ over 2⁻¹⁰.
        assert!(error < 1e-3, "{accel:?}: {error}");
        assert!((found.norm() - 1.0).abs() < 1e-6, "{accel:?}");
    }
}

fn counts() -> impl Strategy<Value = [i16; 3]> {
    let axis = prop_oneof![
        4 => any::<i16>(),
        1 => prop_oneof![Just(i16::MIN), Just(i16::MAX), Just(0), Just(1), Just(-1)],
        1 => -600..600i16,
    ];
    [axis.clone(), axis.clone(), axis]
}

/// Any constants that the formats allow.
fn constants() -> impl Strategy<Value = FilterConstants> {
    let line = || {
        (
            prop::array::uniform3(-0x1000_0000..=0x1000_0000),
            prop::array::uniform3(prop::array::uniform3(-0x2000_0000..=0x2000_0000)),
            0..=16u32,
        )
            .prop_map(|(bias, [x, y, z], shift)| SensorLine {
                bias,
                x,
                y,
                z,
                shift,
                half_unit: ((1 << shift) >> 1) + 1,
            })
    };
    let arm = || {
        prop::array::uniform2(prop_oneof![
            Just(0),
            any::<i32>().prop_map(|a| a.max(-i32::MAX))
        ])
    };
    (
        line(),
        line(),
        line(),
        1..0x1_0000,
        1..0x1_0000,
        arm(),
        arm(),
        1..0x0800_0000,
    )
        .prop_map(
            |(
                gyro,
                accel,
                mag,
                gravity_squared_min,
                field_squared_min,
                centripetal,
                tangential,
                beta,
            )| {
                FilterConstants {
                    gyro,
                    accel,
                    mag,
                    gravity_squared_min,
                    field_squared_min,
                    lever_arm: LeverArm {
                        centripetal,
                        tangential,
                    },
                    beta,
                    accel_clip: [32_764; 3],
                    mag_clip: [12_000, 30_000, 32_767],
                    drift: DriftGain {
                        gain: 18_325_194,
                        shift: 12,
                        limit: 0x3000_0000,
                    },
                }
            },
        )
}

/// Unit quaternions with the length error that the invariant allows.
fn state() -> impl Strategy<Value = FilterState> {
    let rate = -0x2000_0000..=0x2000_0000;
    (
        prop::array::uniform4(-1.0..1.0f64),
        -1.0..1.0f64,
        rate.clone(),
        rate,
    )
        .prop_filter_map("a direction", |(direction, length, rate, slow_rate)| {
            let norm = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
            let length = 1.0 + length * INVARIANT_LENGTH;
            (norm > 1e-3).then(|| FilterState {
                quaternion: direction.map(|c| (c / norm * length * f64::from(1 << 30)) as i32),
                rate,
                slow_rate,
            })
        })
        // Rounding to words can shorten the shortest below what is allowed.
        .prop_filter("within the invariant", |state| {
            assert_invariant(state).is_ok()
        })
}

const INVARIANT_LENGTH: f64 = 1.0 / 4096.0;

fn assert_invariant(state: &FilterState) -> Result<(), TestCaseError> {
    prop_assert!(state.quaternion.iter().all(|c| c.abs() <= COMPONENT_MAX));
    prop_assert!(
        (quaternion(state).norm() - 1.0).abs() <= INVARIANT_LENGTH,
        "{}",
        quaternion(state).norm()
    );
    prop_assert!(state.rate.abs() <= 0x2000_0000 && state.slow_rate.abs() <= 0x2000_0000);
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40_000))]

    /// Inductive: any state within the invariant, any reading, any constants; also no overflow.
    #[test]
    fn every_step_keeps_the_invariant(
        state in state(), gyro in counts(), accel in counts(), mag in counts(), constants in constants(),
    ) {
        assert_invariant(&step_imu(&state, gyro, accel, &constants))?;
        assert_invariant(&headed(&state, mag, &constants))?;
        assert_invariant(&align(&state, accel, &constants).0)?;
    }

    /// No overflow even for a state of any length, as long as its components are in range.
    #[test]
    fn no_overflow_for_components_in_range(
        quaternion in prop::array::uniform4(prop_oneof![
            -COMPONENT_MAX..=COMPONENT_MAX, Just(COMPONENT_MAX), Just(-COMPONENT_MAX), Just(0)
        ]),
        gyro in counts(), accel in counts(), mag in counts(), constants in constants(), mounting in -PI_Q28..=PI_Q28,
    ) {
        let state = FilterState { quaternion, rate: -0x2000_0000, slow_rate: 0x2000_0000 };
        for next in [
            step_imu(&state, gyro, accel, &constants),
            headed(&state, mag, &constants),
        ] {
            prop_assert!(next.quaternion.iter().all(|c| c.abs() <= COMPONENT_MAX));
            pivot_angle(next.quaternion, mounting);
        }
    }

    /// One step from any state against the reference from the same state: the error budget of a
    /// step, without what earlier steps added.
    #[test]
    fn pivot_angle_agrees_with_the_reference(state in state(), mounting in -3.2..3.2f64) {
        let exact = quaternion(&state).normalize();
        let up = attitude::up_in_sensor(&exact);
        let across = up.x.hypot(up.y);
        let word = pivot_angle(state.quaternion, mounting_word(mounting).expect("finite"));
        let angle = f64::from(word) / f64::from(1 << 28);
        let error = wrap_angle(angle - attitude::pivot_angle(&exact, mounting)).abs() * across;
        prop_assert!(error <= 5e-7, "{}", error);
    }
}
