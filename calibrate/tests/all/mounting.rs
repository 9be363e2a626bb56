//! The orientation of the sensor on the body, and the filter that uses it.

use crate::common::{ChiSquared, GRAVITY, Noise, counts, pose_directions};
use attitude::{AttitudeSpec, RawFilter, SensorLine, wrap_angle};
use calibrate::{SensorCalibration, accelerometer, gyroscope_rest, mounting};
use nalgebra::{Matrix3, Rotation3, UnitVector3, Vector3};
use rand::RngExt;
use std::f64::consts::PI;

#[test]
fn mounting_from_swing_and_rest() {
    let mut of_axis = ChiSquared::default();
    let mut of_angle = ChiSquared::default();
    let seeds = 200;
    for seed in 0..seeds {
        let mut noise = Noise::new(4000 + seed);
        let gyro = SensorLine::ideal(62.5e-3_f64.to_radians());
        // The accelerometer's calibration is off by its own stated standard errors.
        let scale = GRAVITY / 4096.0;
        let (bias_std, scale_std) = (0.3, 2e-4 * scale);
        let accel = SensorCalibration {
            line: SensorLine {
                bias_counts: noise.three(bias_std),
                matrix: Matrix3::from_diagonal_element(scale)
                    + Matrix3::from_diagonal(&noise.three(scale_std)),
            },
            bias_std: Vector3::from_element(bias_std),
            matrix_std: Matrix3::from_diagonal_element(scale_std),
        };
        let tilt = UnitVector3::new_normalize(Vector3::new(noise.one(), noise.one(), 0.0));
        // From the body's frame (z the pivot axis, x towards the centre of mass) to the sensor's.
        let angle = noise.rng.random_range(-3.0..3.0);
        let to_sensor = Rotation3::from_axis_angle(&tilt, 0.06)
            * Rotation3::from_axis_angle(&Vector3::z_axis(), -angle);
        let axis = to_sensor * Vector3::z();
        let swing: Vec<_> = (0..4000)
            .map(|k| {
                let rate = 3.0 * (f64::from(k) * 0.01).sin();
                counts(axis * (rate / gyro.matrix[(0, 0)]) + noise.three(6.0))
            })
            .collect();
        // Hanging, the body's x axis points down, so up is −x.
        let up = to_sensor * -Vector3::x();
        let hanging: Vec<_> = (0..2000)
            .map(|_| counts(up * 4096.0 + noise.three(9.0)))
            .collect();
        let found = mounting(&swing, &gyro, &hanging, &accel, &Vector3::z()).expect("a good swing");
        assert!((found.alignment * found.axis - Vector3::z()).norm() < 1e-12);
        let error = found.axis - axis;
        // Two directions across the axis, each with the stated share of the total.
        of_axis.add(error.norm(), found.axis_std_rad);
        // The smallest rotation of the axis onto z also turns the sensor's x axis a little. The definition of the
        // mounting angle includes this turn, so that the angle is compared with the exact one after the same rotation.
        let exact_x = found.alignment.inverse() * Vector3::x();
        let in_body = to_sensor.inverse() * exact_x;
        let exact = in_body.y.atan2(in_body.x);
        of_angle.add(wrap_angle(found.angle_rad - exact), found.angle_std_rad);
    }
    of_axis.assert_one("pivot axis", 2.0 * seeds as f64, 1.0);
    of_angle.assert_one("mounting angle", seeds as f64, 1.0);
}

/// A badly mounted sensor with all its errors, calibrated, shows the body angle.
#[test]
fn the_calibrated_filter_shows_the_body_angle() {
    let mut noise = Noise::new(77);
    let tilt = UnitVector3::new_normalize(Vector3::new(0.3, -1.0, 0.0));
    let to_sensor = Rotation3::from_axis_angle(&tilt, 0.09)
        * Rotation3::from_axis_angle(&Vector3::z_axis(), -2.1);
    let accel_counts = Matrix3::from_diagonal(&Vector3::new(4180.0, 4010.0, 4095.0)) / GRAVITY;
    let accel_bias = Vector3::new(150.0, -90.0, 60.0);
    let gyro_bias = Vector3::new(14.0, -8.0, 21.0);
    let scale = 62.5e-3_f64.to_radians();
    let accel = |up: Vector3<f64>, noise: &mut Noise| {
        counts(accel_counts * up * GRAVITY + accel_bias + noise.three(9.0))
    };
    let gyro =
        |rate: Vector3<f64>, noise: &mut Noise| counts(rate / scale + gyro_bias + noise.three(4.0));

    let poses: Vec<Vec<_>> = pose_directions(6, &mut noise)
        .into_iter()
        .map(|up| (0..2000).map(|_| accel(up, &mut noise)).collect())
        .collect();
    let accelerometer = accelerometer(&poses, GRAVITY).expect("six good poses");
    let rest: Vec<_> = (0..4000)
        .map(|_| gyro(Vector3::zeros(), &mut noise))
        .collect();
    let gyroscope = gyroscope_rest(&rest, scale, 1e-3).expect("enough samples");
    let axis = to_sensor * Vector3::z();
    let swing: Vec<_> = (0..4000)
        .map(|k| gyro(axis * (3.0 * (f64::from(k) * 0.01).sin()), &mut noise))
        .collect();
    let hanging: Vec<_> = (0..2000)
        .map(|_| accel(to_sensor * -Vector3::x(), &mut noise))
        .collect();
    let mounting = mounting(
        &swing,
        &gyroscope.sensor.line,
        &hanging,
        &accelerometer.sensor,
        &Vector3::z(),
    )
    .expect("a good swing");
    let turned = |sensor: &SensorCalibration| SensorLine {
        bias_counts: sensor.line.bias_counts,
        matrix: mounting.alignment.matrix() * sensor.line.matrix,
    };
    let spec = AttitudeSpec {
        gyro: turned(&gyroscope.sensor),
        accel: turned(&accelerometer.sensor),
        mounting_angle_rad: mounting.angle_rad,
        ..AttitudeSpec::thesis()
    };

    // Held at several angles: the body's x axis (towards the centre of mass) at α from down.
    for theta in [-2.5, -0.2, 0.0, 0.1, 1.4] {
        let mut filter = RawFilter::new(&spec);
        let alpha: f64 = theta + PI;
        let up = to_sensor * Vector3::new(-alpha.cos(), alpha.sin(), 0.0);
        filter.align(accel(up, &mut noise));
        for _ in 0..3000 {
            filter.update_imu(gyro(Vector3::zeros(), &mut noise), accel(up, &mut noise));
        }
        let error = wrap_angle(filter.angle_rad() - theta);
        assert!(error.abs() < 2e-3, "{theta}: {error}");
    }
}

#[test]
fn mounting_refuses_a_tumbling_sensor() {
    let mut noise = Noise::new(5);
    let line = SensorLine::ideal(1e-3);
    let tumbling: Vec<_> = (0..500).map(|_| counts(noise.three(3000.0))).collect();
    let hanging = vec![[4096, 0, 0]; 100];
    let accel = SensorCalibration {
        line,
        bias_std: Vector3::zeros(),
        matrix_std: Matrix3::zeros(),
    };
    assert!(mounting(&tumbling, &line, &hanging, &accel, &Vector3::z()).is_err());
    let across: Vec<_> = (0..500)
        .map(|k| [(3000.0 * (f64::from(k) * 0.1).sin()) as i16, 0, 0])
        .collect();
    let error =
        mounting(&across, &line, &hanging, &accel, &Vector3::z()).expect_err("axis along x");
    assert!(error.to_string().contains("45°"), "{error}");
}
