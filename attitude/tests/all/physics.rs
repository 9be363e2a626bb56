//! The reference filters on motions whose truth is known.

use attitude::{
    AttitudeSpec, Complementary, LowPassIntegrator, Madgwick, RawFilter, STANDARD_GRAVITY,
    SensorLine, pivot_angle, pivot_angle_of_gravity, up_in_sensor, wrap_angle,
};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::{FRAC_PI_2, PI};

const STEP_S: f64 = 1e-3;

/// Attitude of a pendulum whose pivot axis (sensor z) is horizontal, at the body angle α and
/// mounting angle m, built from rotations alone: sensor z = earth y; x = R_z(α + m) down.
fn pendulum_attitude(body_angle: f64, mounting: f64) -> UnitQuaternion<f64> {
    let pivot = Vector3::y();
    let down = -Vector3::z();
    let turn = UnitQuaternion::from_axis_angle(
        &nalgebra::Unit::new_normalize(pivot),
        body_angle + mounting,
    );
    let x = turn * down;
    let y = pivot.cross(&x);
    // Columns: the sensor's axes in the earth frame. Nalgebra's rotation of q takes S to E,
    // which is Madgwick's q read as ᴇv = q ⊗ ˢv ⊗ q*.
    let axes = nalgebra::Matrix3::from_columns(&[x, y, pivot]);
    UnitQuaternion::from_matrix(&axes)
}

fn angle_between(a: &Quaternion<f64>, b: &Quaternion<f64>) -> f64 {
    UnitQuaternion::new_normalize(*a).angle_to(&UnitQuaternion::new_normalize(*b))
}

#[test]
fn pivot_angle_is_the_body_angle() {
    for step in -31..31 {
        let theta = f64::from(step) * 0.1;
        for mounting in [0.0, 0.75 * PI, -2.0] {
            let q = pendulum_attitude(theta + PI, mounting);
            let found = pivot_angle(q.quaternion(), mounting);
            assert!(
                (wrap_angle(found - theta)).abs() < 1e-12,
                "{theta} {mounting} {found}"
            );
            let up = q.inverse() * Vector3::z();
            assert!(
                (wrap_angle(pivot_angle_of_gravity(&(9.81 * up), mounting) - theta)).abs() < 1e-12
            );
            assert!((up - up_in_sensor(q.quaternion())).norm() < 1e-12);
        }
    }
}

/// Without a usable accelerometer the filter integrates: a constant rate about a fixed axis
/// turns it by the rate times the time, up to the third-order error of the Euler step,
/// (ω T/2)³/3 half-angle a step.
#[test]
fn constant_rotation_is_integrated() {
    let rate = Vector3::new(3.0, -2.0, 6.0);
    let mut filter = Madgwick::new(0.033, STEP_S);
    let steps = 2000;
    for _ in 0..steps {
        filter.step_gyro(&rate);
    }
    let truth = UnitQuaternion::from_scaled_axis(rate * (STEP_S * f64::from(steps)));
    let half = rate.norm() * STEP_S / 2.0;
    let bound = 2.0 * f64::from(steps) * half.powi(3) / 3.0 * 1.01;
    let error = angle_between(&filter.quaternion(), truth.quaternion());
    assert!(error < bound && error > 0.9 * bound, "{error} {bound}");
    assert!((filter.quaternion().norm() - 1.0).abs() < 1e-12);
}

/// At rest, the correction reduces the tilt error by 2β rad/s (q changes by β per second). A rate of zero must not
/// stop the correction.
#[test]
fn still_sensor_converges_at_the_stated_speed() {
    let truth = pendulum_attitude(PI + 0.2, 0.0);
    let start = pendulum_attitude(PI + 0.5, 0.0);
    let up = truth.inverse() * Vector3::z();
    let mut filter = Madgwick::new(0.1, STEP_S);
    filter.align(&(start.inverse() * Vector3::z()));
    let theta = |filter: &Madgwick| pivot_angle(&filter.quaternion(), 0.0);
    assert!((theta(&filter) - 0.5).abs() < 1e-9);
    for _ in 0..1000 {
        filter.step_imu(&Vector3::zeros(), &up);
    }
    // 0.5 − 2 · 0.1 rad/s · 1 s; the tolerance covers the difference between chord and arc.
    assert!((theta(&filter) - 0.3).abs() < 2e-3, "{}", theta(&filter));
    for _ in 0..1000 {
        filter.step_imu(&Vector3::zeros(), &up);
    }
    assert!((theta(&filter) - 0.2).abs() < 3e-4, "{}", theta(&filter));
}

/// The nine-axis filter finds heading and tilt from a wrong start, for any dip of the field. If the reference were
/// doubled as in the C code, the filter would come to rest tilted.
#[test]
fn magnetometer_gives_the_heading() {
    for dip in [0.0_f64, 0.8, 1.2] {
        let field = Vector3::new(dip.cos(), 0.0, -dip.sin()) * 48.0;
        let truth = UnitQuaternion::from_euler_angles(0.3, -0.4, 1.1);
        let (up, mag) = (truth.inverse() * Vector3::z(), truth.inverse() * field);
        let mut filter = Madgwick::new(0.5, STEP_S);
        for _ in 0..20_000 {
            filter.step_marg(&Vector3::zeros(), &up, &mag);
        }
        let error = angle_between(&filter.quaternion(), truth.quaternion());
        assert!(error < 2.5e-3, "dip {dip}: {error}");
    }
}

/// The turn to north finds the heading from any start, at 2 β rad/s as long as the heading is far off.
#[test]
fn the_turn_to_north_gives_the_heading() {
    for dip in [0.0_f64, 0.8, 1.2] {
        let field = Vector3::new(dip.cos(), 0.0, -dip.sin()) * 48.0;
        for heading in [-3.1, -1.5, 0.2, 1.1, 3.0] {
            let truth = UnitQuaternion::from_euler_angles(0.3, -0.4, heading);
            let (up, mag) = (truth.inverse() * Vector3::z(), truth.inverse() * field);
            let mut filter = Madgwick::new(0.5, STEP_S);
            filter.align(&up);
            let to_go = angle_between(&filter.quaternion(), truth.quaternion());
            let at = |steps: usize, filter: &mut Madgwick| {
                for _ in 0..steps {
                    filter.step_imu(&Vector3::zeros(), &up);
                    filter.turn_to_north(&mag);
                }
                angle_between(&filter.quaternion(), truth.quaternion())
            };
            // A fifth of a second at one radian a second; less where it is nearer than that.
            let gone = to_go - at(200, &mut filter);
            assert!(
                (gone - to_go.min(0.2)).abs() < 3e-3,
                "{dip} {heading}: {gone} of {to_go}"
            );
            let left = at(6000, &mut filter);
            assert!(left < 1.5e-3, "{dip} {heading}: {left}");
        }
    }
}

/// A field with a heading error of 90°, as a motor may cause, on a body at rest. The gradient of Madgwick's report of
/// 2010 tilts the estimate by degrees; the turn to north does not change the vertical of the six-axis filter.
#[test]
fn only_the_gradient_of_2010_leans_in_a_wrong_field() {
    let truth = pendulum_attitude(PI, 0.0);
    let up = truth.inverse() * Vector3::z();
    let wrong = truth.inverse() * Vector3::new(0.0, 20.0, -43.0);
    let lean = |filter: &Madgwick| {
        let found = up_in_sensor(&filter.quaternion());
        found.cross(&up).norm().atan2(found.dot(&up))
    };
    let mut gradient = Madgwick::new(0.033, STEP_S);
    let mut turn = gradient;
    for filter in [&mut gradient, &mut turn] {
        filter.align(&up);
        // The heading of the start agrees with the earth's field.
        for _ in 0..200_000 {
            filter.step_imu(&Vector3::zeros(), &up);
            filter.turn_to_north(&(truth.inverse() * Vector3::new(20.0, 0.0, -43.0)));
        }
    }
    let mut most = [0.0_f64; 2];
    for _ in 0..20_000 {
        gradient.step_marg(&Vector3::zeros(), &up, &wrong);
        turn.step_imu(&Vector3::zeros(), &up);
        turn.turn_to_north(&wrong);
        most = [most[0].max(lean(&gradient)), most[1].max(lean(&turn))];
    }
    println!(
        "gradient of 2010 {:.2}°, turn {:.1e} rad",
        most[0].to_degrees(),
        most[1]
    );
    assert!(most[0].to_degrees() > 3.0, "{most:?}");
    // The ripple of the six-axis corrections at rest remains, which does not depend on the field.
    assert!(most[1] < 1e-4, "{most:?}");
}

/// A vertical field shows no heading: the step is then the six-axis step.
#[test]
fn vertical_field_falls_back_to_six_axes() {
    let (rate, up) = (Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.1, 0.0, 1.0));
    let (mut six, mut nine) = (Madgwick::new(0.1, STEP_S), Madgwick::new(0.1, STEP_S));
    six.step_imu(&rate, &up);
    nine.step_marg(&rate, &up, &Vector3::new(0.0, 0.0, -40.0));
    assert_eq!(six, nine);
}

#[test]
fn unusable_measurements_fall_back_to_the_gyro() {
    let spec = AttitudeSpec::thesis();
    let gyro = [120, -40, 900];
    let fallen = [0, 0, 511];
    for accel in [[0, 0, 0], fallen, [i16::MAX, 0, 4096], [0, i16::MIN, 0]] {
        let mut filter = RawFilter::new(&spec);
        let mut gyro_only = Madgwick::new(spec.beta_rad_s, spec.sample_time_s);
        for _ in 0..10 {
            filter.update_imu(gyro, accel);
            gyro_only.step_gyro(&spec.gyro.apply(gyro));
        }
        assert_eq!(filter.quaternion(), gyro_only.quaternion(), "{accel:?}");
    }
    // A reading one count above g/8 is used, and an unusable magnetometer changes nothing.
    for mag in [[0, 0, 0], [i16::MAX, 0, 0]] {
        let (mut six, mut nine) = (RawFilter::new(&spec), RawFilter::new(&spec));
        let mut gyro_only = RawFilter::new(&spec);
        six.update_imu(gyro, [20, 0, 512]);
        nine.update_marg(gyro, [20, 0, 512], mag);
        gyro_only.update_imu(gyro, [0, 0, 0]);
        assert_eq!(six.quaternion(), nine.quaternion());
        assert_ne!(six.quaternion(), gyro_only.quaternion());
    }
}

/// A simulated free swing of a physical pendulum, sensor at a lever arm, noise and quantisation:
/// with the correction the angle follows; without it the error is several times larger.
#[test]
fn lever_arm_correction_on_a_swing() {
    let seed = 7;
    println!("seed {seed}");
    let run = |lever_arm_m: [f64; 2]| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let noise = Normal::new(0.0, 1.0).expect("a standard deviation of one");
        let spec = AttitudeSpec {
            lever_arm_m,
            beta_rad_s: 0.1,
            ..AttitudeSpec::thesis()
        };
        let true_arm = [0.1, 0.03];
        let mut filter = RawFilter::new(&spec);
        let (mut angle, mut rate) = (2.5_f64, 0.0_f64);
        let (mut squares, mut count) = (0.0_f64, 0);
        for step in 0..20_000 {
            // The readings belong to exactly this motion: the gyroscope reads the mean rate of the step.
            let acceleration = -95.0 * angle.sin() - 0.05 * rate;
            let up = pendulum_attitude(angle, 0.0).inverse() * Vector3::z();
            let accel = STANDARD_GRAVITY * up
                + Vector3::new(
                    -true_arm[1] * acceleration - true_arm[0] * rate * rate,
                    true_arm[0] * acceleration - true_arm[1] * rate * rate,
                    0.0,
                );
            let raw_accel = [0, 1, 2].map(|i| {
                (accel[i] / STANDARD_GRAVITY * 4096.0 + 20.0 * noise.sample(&mut rng)).round()
                    as i16
            });
            let mean_rate = rate + 0.5 * STEP_S * acceleration;
            let raw_rate =
                (mean_rate.to_degrees() / 62.5e-3 + 2.0 * noise.sample(&mut rng)).round() as i16;
            if step == 0 {
                filter.align(raw_accel);
            }
            filter.update_imu([0, 0, raw_rate], raw_accel);
            angle += STEP_S * mean_rate;
            rate += STEP_S * acceleration;
            // The alignment in full motion is wrong by 0.6 rad, which takes 0.6/(2β) = 3 s to decay.
            if step > 5000 {
                squares += wrap_angle(filter.angle_rad() + PI - angle).powi(2);
                count += 1;
            }
        }
        (squares / f64::from(count)).sqrt()
    };
    let (corrected, plain) = (run([0.1, 0.03]), run([0.0, 0.0]));
    println!("lever arm: corrected {corrected:.4} rad, not corrected {plain:.4} rad");
    // The differentiator lags by 1.5 ms: at a jerk of 95 · 18 rad/s³ it misreads the direction by
    // 1.5e-3 · 1700 · 0.1/9.8 = 0.026 rad at most, and the filter averages it.
    assert!(corrected < 0.026, "{corrected}");
    assert!(plain > 5.0 * corrected, "{plain} {corrected}");
}

/// With a bias of the rate, the integral drifts, the complementary filter is off by bias times time constant, and
/// Madgwick's filter is off by no more than its ripple, as long as β is large enough for the bias.
#[test]
fn what_each_filter_makes_of_a_rate_bias() {
    let bias = 0.02;
    let seconds = 60.0;
    let mut integral = LowPassIntegrator::new(0.0, 0.05, STEP_S);
    let mut complementary = Complementary::new(0.0, 1.0, STEP_S);
    let mut madgwick = Madgwick::new(attitude::beta_from_gyro_error(bias), STEP_S);
    let truth = pendulum_attitude(PI, 0.0);
    let up = truth.inverse() * Vector3::z();
    madgwick.align(&up);
    let (mut drift, mut lean) = (0.0, 0.0);
    for _ in 0..(seconds / STEP_S) as usize {
        drift = integral.update(bias);
        lean = complementary.update(bias, Some(0.0));
        madgwick.step_imu(&Vector3::new(0.0, 0.0, bias), &up);
    }
    assert!((drift - bias * (seconds - 0.05)).abs() < 1e-4, "{drift}");
    assert!((lean - bias).abs() < 1e-4, "{lean}");
    assert!(pivot_angle(&madgwick.quaternion(), 0.0).abs() < 1e-4);
}

#[test]
fn complementary_crosses_the_seam() {
    let mut filter = Complementary::new(3.1, 0.01, STEP_S);
    let mut angle = 0.0;
    for _ in 0..200 {
        angle = filter.update(0.0, Some(-3.1));
    }
    assert!((angle + 3.1).abs() < 1e-6, "{angle}");
}

#[test]
fn alignment_agrees_with_gravity_everywhere() {
    let mut filter = Madgwick::new(0.1, STEP_S);
    for up in [
        Vector3::x(),
        -Vector3::y(),
        Vector3::new(0.3, -0.4, 0.2),
        Vector3::new(-0.1, 0.7, -0.9),
        -Vector3::z(),
    ] {
        filter.align(&(8192.0 * up));
        let found = up_in_sensor(&filter.quaternion());
        assert!((found - up.normalize()).norm() < 1e-12, "{up} {found}");
    }
    let before = filter.quaternion();
    filter.align(&Vector3::zeros());
    assert_eq!(before, filter.quaternion());
}

#[test]
fn sensor_line_inverts_bias_scale_and_cross_axis() {
    let distortion =
        nalgebra::Matrix3::new(4100.0, 12.0, -7.0, 3.0, 4080.0, 9.0, -5.0, 2.0, 4110.0);
    let line = SensorLine {
        bias_counts: Vector3::new(30.0, -45.0, 10.0),
        matrix: distortion.try_inverse().expect("nearly diagonal"),
    };
    let truth = Vector3::new(0.6, -0.7, 0.2);
    let raw = distortion * truth + line.bias_counts;
    let found = line.apply([
        raw.x.round() as i16,
        raw.y.round() as i16,
        raw.z.round() as i16,
    ]);
    assert!((found - truth).norm() < 3f64.sqrt() * 0.5 / 4080.0 * 1.01);
}

/// A pendulum turned by a right angle about its pivot stays in the plane of the other axes.
#[test]
fn still_pendulum_has_no_gravity_along_its_axis() {
    let up = up_in_sensor(pendulum_attitude(FRAC_PI_2, 0.3).quaternion());
    assert!(up.z.abs() < 1e-12);
}
