//! The position of the accelerometer relative to the pivot.

use crate::common::{ChiSquared, GRAVITY, Noise, counts};
use attitude::SensorLine;
use calibrate::{CalibrationError, LeverArmEstimate, SensorCalibration, lever_arm, mounting};
use nalgebra::{Matrix3, Rotation3, UnitVector3, Vector3};
use rand::RngExt;
use std::f64::consts::PI;

/// A free swing from `start_rad` (w² = 95/s², slightly damped) in the counts of a sensor at `arm`
/// on a tilted mounting, its gyroscope's scale `scale_error` too small, and what is found.
/// The accelerometer's calibration is off by its own stated standard errors.
fn found_lever_arm(
    noise: &mut Noise,
    arm: [f64; 2],
    scale_error: f64,
    start_rad: f64,
    period_s: f64,
) -> Result<LeverArmEstimate, CalibrationError> {
    let tilt = UnitVector3::new_normalize(Vector3::new(noise.one(), noise.one(), 0.0));
    let to_sensor = Rotation3::from_axis_angle(&tilt, 0.04);
    let mount_rad = noise.rng.random_range(-3.0..3.0);
    let gyro = SensorLine::ideal(62.5e-3_f64.to_radians());
    let true_accel = SensorLine {
        bias_counts: Vector3::new(31.0, -12.0, 8.0),
        matrix: Matrix3::from_diagonal_element(GRAVITY / 4096.0),
    };
    let (bias_std, scale_std) = (0.3, 5e-4 * GRAVITY / 4096.0);
    let known = SensorCalibration {
        line: SensorLine {
            bias_counts: true_accel.bias_counts + noise.three(bias_std),
            matrix: true_accel.matrix + Matrix3::from_diagonal(&noise.three(scale_std)),
        },
        bias_std: Vector3::from_element(bias_std),
        matrix_std: Matrix3::from_diagonal_element(scale_std),
    };
    let force = |angle: f64, rate: f64, acceleration: f64| {
        let (sin, cos) = (angle - PI + mount_rad).sin_cos();
        Vector3::new(
            GRAVITY * cos - acceleration * arm[1] - rate * rate * arm[0],
            -GRAVITY * sin + acceleration * arm[0] - rate * rate * arm[1],
            0.0,
        )
    };
    let read = |force: Vector3<f64>, noise: &mut Noise| {
        let of_sensor = to_sensor * force / true_accel.matrix[(0, 0)];
        counts(of_sensor + true_accel.bias_counts + noise.three(12.0))
    };
    let acceleration = |angle: f64, rate: f64| -95.0 * angle.sin() - 0.05 * rate;
    let (mut angle, mut rate) = (start_rad, 0.0);
    let fine_s = 1e-4;
    let (mut swing, mut swing_accel) = (Vec::new(), Vec::new());
    for _ in 0..(10.0 / period_s) as usize {
        let axis = to_sensor * Vector3::z() * (rate / (1.0 + scale_error));
        swing.push(counts(axis / gyro.matrix[(0, 0)] + noise.three(9.0)));
        swing_accel.push(read(force(angle, rate, acceleration(angle, rate)), noise));
        // The midpoint rule, whose error over the fine step is far below the noise.
        for _ in 0..(period_s / fine_s).round() as usize {
            let half_angle = angle + 0.5 * fine_s * rate;
            let half_rate = rate + 0.5 * fine_s * acceleration(angle, rate);
            angle += fine_s * half_rate;
            rate += fine_s * acceleration(half_angle, half_rate);
        }
    }
    let hanging: Vec<_> = (0..2000)
        .map(|_| read(force(0.0, 0.0, 0.0), noise))
        .collect();
    let mounting = mounting(&swing, &gyro, &hanging, &known, &Vector3::z())?;
    lever_arm(
        &swing,
        &swing_accel,
        &gyro,
        &hanging,
        &known,
        &mounting,
        period_s,
    )
}

#[test]
fn lever_arm_from_a_swing() {
    let mut of_arm = ChiSquared::default();
    let mut of_scale = ChiSquared::default();
    let seeds = 200;
    let mut largest_std: f64 = 0.0;
    for seed in 0..seeds {
        let mut noise = Noise::new(6000 + seed);
        let arm = [
            noise.rng.random_range(-0.1..0.1),
            noise.rng.random_range(-0.1..0.1),
        ];
        let scale_error = 0.01 * noise.one();
        let start_rad = noise.rng.random_range(0.8..1.5);
        let period_s = if seed % 2 == 0 { 1e-3 } else { 4e-3 };
        let found = found_lever_arm(&mut noise, arm, scale_error, start_rad, period_s)
            .expect("a good swing");
        let results = found.position_m.into_iter().zip(found.position_std_m);
        for ((position, std), truth) in results.zip(arm) {
            of_arm.add(position - truth, std);
            largest_std = largest_std.max(std);
        }
        of_scale.add(
            found.gyro_scale_error - scale_error,
            found.gyro_scale_error_std,
        );
    }
    println!(
        "lever arm: standard errors of at most {:.3} mm",
        1e3 * largest_std
    );
    assert!(largest_std < 1e-3, "{largest_std}");
    of_arm.assert_one("lever arm", 2.0 * seeds as f64 / 2.0, 1.0);
    of_scale.assert_one("gyroscope's scale from the swing", seeds as f64, 1.0);
}

#[test]
fn lever_arm_refuses_what_does_not_determine_it() {
    let mut noise = Noise::new(8);
    // A body that hardly moves does not determine the position of the sensor, as the standard error shows.
    let still = found_lever_arm(&mut noise, [0.05, 0.0], 0.0, 0.02, 1e-3);
    match still {
        Ok(found) => assert!(found.position_std_m[0] > 2e-3, "{found:?}"),
        Err(error) => assert!(matches!(error, CalibrationError::NotDetermined { .. })),
    }
    // A swing over the top is faster than the range of the gyroscope.
    let gyro = SensorLine::ideal(1e-3);
    let sensor = SensorCalibration {
        line: SensorLine::ideal(GRAVITY / 4096.0),
        bias_std: Vector3::zeros(),
        matrix_std: Matrix3::zeros(),
    };
    let hanging = vec![[-4096, 0, 0]; 100];
    let swing: Vec<[i16; 3]> = (0..2000).map(|k| [0, 0, (k % 1000) as i16]).collect();
    let place = mounting(&swing, &gyro, &hanging, &sensor, &Vector3::z()).expect("one axis");
    let accel = vec![[-4096, 0, 0]; 2000];
    let refused = |swing: &[[i16; 3]], accel: &[[i16; 3]], period_s: f64| {
        lever_arm(swing, accel, &gyro, &hanging, &sensor, &place, period_s)
            .expect_err("nothing to be found")
    };
    let mut beyond = swing.clone();
    beyond[700][2] = i16::MAX;
    let message = refused(&beyond, &accel, 1e-3).to_string();
    assert!(message.contains("gyroscope's range"), "{message}");
    let few = |error| matches!(error, CalibrationError::TooFew { .. });
    assert!(few(refused(&swing[..100], &accel[..100], 1e-3)));
    assert!(few(refused(&swing, &accel[..1999], 1e-3)));
    assert!(few(refused(&swing, &[[i16::MIN; 3]; 2000], 1e-3)));
    let bad = refused(&swing, &accel, f64::NAN);
    assert!(matches!(bad, CalibrationError::BadNumber { .. }));
}
