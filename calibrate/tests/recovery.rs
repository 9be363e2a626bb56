//! Known distortions are recovered from simulated raw counts within the stated uncertainty.
//!
//! "Within" is tested as a statement about many seeds: the squared errors over their stated
//! variances have mean one (a χ² over all seeds and parameters), so that a standard error that
//! is too small fails, and one that is too large fails as well.

use attitude::{AttitudeSpec, RawFilter, SensorLine, wrap_angle};
use calibrate::{
    Calibrated, CalibrationError, LeverArm, PlumbLine, SensorCalibration, Shape, accelerometer,
    attitude_spec, centre_of_mass, fit_line, gyroscope_rest, lever_arm, magnetometer, mounting,
    sphere_coverage, still,
};
use nalgebra::{Matrix3, Rotation3, UnitVector3, Vector2, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal, UnitSphere};
use std::f64::consts::PI;

const GRAVITY: f64 = 9.81;

struct Noise {
    rng: ChaCha8Rng,
    normal: Normal<f64>,
}

impl Noise {
    fn new(seed: u64) -> Self {
        Noise {
            rng: ChaCha8Rng::seed_from_u64(seed),
            normal: Normal::new(0.0, 1.0).expect("a standard deviation of one"),
        }
    }

    fn one(&mut self) -> f64 {
        self.normal.sample(&mut self.rng)
    }

    fn three(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::new(self.one(), self.one(), self.one()) * deviation
    }

    fn direction(&mut self) -> Vector3<f64> {
        Vector3::from(UnitSphere.sample(&mut self.rng))
    }
}

fn counts(value: Vector3<f64>) -> [i16; 3] {
    let count = |x: f64| x.round().clamp(-32_768.0, 32_767.0) as i16;
    [count(value.x), count(value.y), count(value.z)]
}

/// Mean of squared standardised errors; one if the stated standard errors are right.
#[derive(Default)]
struct ChiSquared {
    sum: f64,
    count: f64,
    worst: f64,
}

impl ChiSquared {
    fn add(&mut self, error: f64, std: f64) {
        let z = error / std;
        self.sum += z * z;
        self.count += 1.0;
        self.worst = self.worst.max(z.abs());
    }

    /// The mean over n independent values scatters by √(2/n); parameters of one seed are
    /// correlated, so `independent` values are counted, and five standard deviations allowed.
    /// `excess` is the expected mean: 1, or ν/(ν − 2) where the variance was estimated.
    fn assert_one(&self, name: &str, independent: f64, excess: f64) {
        let mean = self.sum / self.count;
        println!(
            "{name}: mean squared z {mean:.3}, worst z {:.2}",
            self.worst
        );
        let allowed = 5.0 * excess * (2.0 / independent).sqrt();
        assert!(
            (mean - excess).abs() < allowed,
            "{name}: {mean} ± {allowed}"
        );
    }
}

/// The six faces up, tilted by some degrees as by hand, then further directions.
fn pose_directions(count: usize, noise: &mut Noise) -> Vec<Vector3<f64>> {
    let faces = [
        Vector3::x(),
        -Vector3::x(),
        Vector3::y(),
        -Vector3::y(),
        Vector3::z(),
        -Vector3::z(),
    ];
    (0..count)
        .map(|index| match faces.get(index) {
            Some(face) => (face + noise.three(0.05)).normalize(),
            None => {
                // Edges and corners of the cube.
                let signs = [0, 1, 2].map(|bit| if index >> bit & 1 == 1 { 1.0 } else { -1.0 });
                let mut edge = Vector3::from(signs);
                if index % 2 == 0 {
                    edge[index % 3] = 0.0;
                }
                (edge + noise.three(0.05)).normalize()
            }
        })
        .collect()
}

#[test]
fn accelerometer_from_six_poses() {
    let scale = Matrix3::from_diagonal(&Vector3::new(1.0 / 418.0, 1.0 / 411.0, 1.0 / 424.5));
    let bias = Vector3::new(63.4, -41.2, 118.9);
    let mut z = ChiSquared::default();
    let seeds = 200;
    for seed in 0..seeds {
        let mut noise = Noise::new(seed);
        let to_counts = scale.try_inverse().expect("diagonal");
        let poses: Vec<_> = pose_directions(6, &mut noise)
            .iter()
            .map(|up| {
                (0..2000)
                    .map(|_| counts(to_counts * up * GRAVITY + bias + noise.three(9.0)))
                    .collect()
            })
            .collect();
        let found = accelerometer(&poses, GRAVITY).expect("six good poses");
        assert_eq!(found.shape, Shape::Diagonal);
        assert!(
            found.residuals_m_s2.iter().all(|r| r.abs() < 1e-9),
            "six poses leave no residual"
        );
        for axis in 0..3 {
            z.add(
                found.sensor.line.bias_counts[axis] - bias[axis],
                found.sensor.bias_std[axis],
            );
            z.add(
                found.sensor.line.matrix[(axis, axis)] - scale[(axis, axis)],
                found.sensor.matrix_std[(axis, axis)],
            );
        }
    }
    z.assert_one(
        "accelerometer, six poses",
        6.0 * seeds as f64 / 2.0,
        19.0 / 17.0,
    );
}

#[test]
fn accelerometer_with_cross_axis_terms_from_eighteen_poses() {
    let matrix = Matrix3::new(
        1.0 / 418.0,
        2e-5,
        -3e-5,
        2e-5,
        1.0 / 411.0,
        1.5e-5,
        -3e-5,
        1.5e-5,
        1.0 / 424.5,
    );
    let bias = Vector3::new(-20.0, 35.5, 7.1);
    let mut z = ChiSquared::default();
    let seeds = 100;
    for seed in 0..seeds {
        let mut noise = Noise::new(1000 + seed);
        let to_counts = matrix.try_inverse().expect("nearly diagonal");
        let poses: Vec<_> = pose_directions(18, &mut noise)
            .iter()
            .map(|up| {
                (0..2000)
                    .map(|_| counts(to_counts * up * GRAVITY + bias + noise.three(9.0)))
                    .collect()
            })
            .collect();
        let found = accelerometer(&poses, GRAVITY).expect("eighteen good poses");
        assert_eq!(found.shape, Shape::Symmetric);
        for axis in 0..3 {
            z.add(
                found.sensor.line.bias_counts[axis] - bias[axis],
                found.sensor.bias_std[axis],
            );
            for other in axis..3 {
                z.add(
                    found.sensor.line.matrix[(axis, other)] - matrix[(axis, other)],
                    found.sensor.matrix_std[(axis, other)],
                );
            }
        }
    }
    // Unequal weights from estimated variances and the enlargement by χ² both blur the mean.
    z.assert_one("accelerometer, 18 poses", 9.0 * seeds as f64 / 4.0, 1.0);
}

#[test]
fn accelerometer_refuses_what_does_not_determine_it() {
    let mut noise = Noise::new(3);
    let pose = |up: Vector3<f64>, noise: &mut Noise| -> Vec<[i16; 3]> {
        (0..100)
            .map(|_| counts(up * 4096.0 + noise.three(5.0)))
            .collect()
    };
    let same: Vec<_> = (0..6).map(|_| pose(Vector3::z(), &mut noise)).collect();
    assert!(matches!(
        accelerometer(&same, GRAVITY),
        Err(CalibrationError::NotDetermined { .. })
    ));
    let half: Vec<_> = (0..8)
        .map(|k| {
            let turn = f64::from(k) * PI / 4.0;
            pose(Vector3::new(turn.cos(), turn.sin(), 0.0), &mut noise)
        })
        .collect();
    assert!(matches!(
        accelerometer(&half, GRAVITY),
        Err(CalibrationError::NotDetermined { .. })
    ));
    assert!(matches!(
        accelerometer(&same[..5], GRAVITY),
        Err(CalibrationError::TooFew { .. })
    ));
    assert!(matches!(
        accelerometer(&same, f64::NAN),
        Err(CalibrationError::BadNumber { .. })
    ));
    assert!(matches!(
        still(&[[0; 3]; 39]),
        Err(CalibrationError::TooFew { .. })
    ));
}

#[test]
fn magnetometer_hard_and_soft_iron() {
    let matrix = Matrix3::new(
        0.104, 0.004, -0.006, 0.004, 0.093, 0.003, -0.006, 0.003, 0.109,
    );
    let bias = Vector3::new(-312.0, 145.0, 88.0);
    let mut z = ChiSquared::default();
    let seeds = 100;
    for seed in 0..seeds {
        let mut noise = Noise::new(2000 + seed);
        let to_counts = matrix.try_inverse().expect("nearly diagonal");
        let samples: Vec<_> = (0..1000)
            .map(|_| counts(to_counts * noise.direction() * 48.0 + bias + noise.three(6.0)))
            .collect();
        let found = magnetometer(&samples, 48.0).expect("readings all round");
        assert!(found.is_covered(), "{}", found.coverage);
        assert!(found.spread_after < 0.02 && found.spread_before > 0.15);
        for axis in 0..3 {
            z.add(
                found.sensor.line.bias_counts[axis] - bias[axis],
                found.sensor.bias_std[axis],
            );
            for other in axis..3 {
                z.add(
                    found.sensor.line.matrix[(axis, other)] - matrix[(axis, other)],
                    found.sensor.matrix_std[(axis, other)],
                );
            }
        }
    }
    z.assert_one("magnetometer", 9.0 * seeds as f64 / 2.0, 1.0);
}

#[test]
fn magnetometer_warns_of_poor_coverage() {
    let mut noise = Noise::new(9);
    let samples: Vec<_> = (0..2000)
        .filter_map(|_| {
            let direction = noise.direction();
            let reading = counts(direction * 480.0 + noise.three(4.0));
            (direction.z > 0.2).then_some(reading)
        })
        .collect();
    let found = magnetometer(&samples, 48.0).expect("a cap still has a curvature");
    assert!(!found.is_covered(), "{}", found.coverage);
    // A cap of height 0.8 is 40 % of the sphere; readings reach 15° beyond.
    assert!((sphere_coverage(&found.points_ut) - 0.52).abs() < 0.1);
}

#[test]
fn gyroscope_at_rest() {
    let scale = 62.5e-3_f64.to_radians();
    let bias = Vector3::new(11.37, -6.82, 3.05);
    let mut z = ChiSquared::default();
    let seeds = 200;
    for seed in 0..seeds {
        let mut noise = Noise::new(3000 + seed);
        let samples: Vec<_> = (0..4000).map(|_| counts(bias + noise.three(4.0))).collect();
        let found = gyroscope_rest(&samples, scale, 1e-3).expect("enough samples");
        for axis in 0..3 {
            z.add(
                found.sensor.line.bias_counts[axis] - bias[axis],
                found.sensor.bias_std[axis],
            );
        }
        // White noise of 4 counts at 1 kHz, and a 12th of rounding.
        let density = (16.0 + 1.0 / 12.0_f64).sqrt() * scale * 2e-3_f64.sqrt();
        assert!((found.noise_rad_s_rthz / density - 1.0).abs() < 0.06);
        assert!(
            found.beta_rad_s > 0.0 && found.beta_rad_s < 0.01,
            "{}",
            found.beta_rad_s
        );
    }
    z.assert_one("gyroscope bias", 3.0 * seeds as f64, 19.0 / 17.0);
}

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
        let found = mounting(&swing, &gyro, &hanging, &accel).expect("a good swing");
        assert!((found.alignment * found.axis - Vector3::z()).norm() < 1e-12);
        let error = found.axis - axis;
        // Two directions across the axis, each with the stated share of the total.
        of_axis.add(error.norm(), found.axis_std_rad);
        // The shortest turn onto z moves the sensor's x axis by what two turns commute to, which
        // the definition of the angle includes: compare with the exact one.
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
    )
    .expect("a good swing");
    let spec = attitude_spec(
        &AttitudeSpec::thesis(),
        &Calibrated {
            accelerometer: Some(&accelerometer.sensor),
            gyroscope: Some(&gyroscope.sensor),
            magnetometer: None,
            mounting: Some(&mounting),
            lever_arm_m: None,
            beta_rad_s: None,
        },
    );

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

/// A free swing from `start_rad` (w² = 95/s², slightly damped) in the counts of a sensor at `arm`
/// on a tilted mounting, its gyroscope's scale `scale_error` too small, and what is found.
/// The accelerometer's calibration is off by its own stated standard errors.
fn found_lever_arm(
    noise: &mut Noise,
    arm: [f64; 2],
    scale_error: f64,
    start_rad: f64,
    period_s: f64,
) -> Result<LeverArm, CalibrationError> {
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
    let mounting = mounting(&swing, &gyro, &hanging, &known)?;
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
    // A body that hardly moves says nothing of where the sensor sits: the standard error shows it.
    let still = found_lever_arm(&mut noise, [0.05, 0.0], 0.0, 0.02, 1e-3);
    match still {
        Ok(found) => assert!(found.position_std_m[0] > 2e-3, "{found:?}"),
        Err(error) => assert!(matches!(error, CalibrationError::NotDetermined { .. })),
    }
    // Over the top: faster than the gyroscope reads.
    let gyro = SensorLine::ideal(1e-3);
    let sensor = SensorCalibration {
        line: SensorLine::ideal(GRAVITY / 4096.0),
        bias_std: Vector3::zeros(),
        matrix_std: Matrix3::zeros(),
    };
    let hanging = vec![[-4096, 0, 0]; 100];
    let swing: Vec<[i16; 3]> = (0..2000).map(|k| [0, 0, (k % 1000) as i16]).collect();
    let place = mounting(&swing, &gyro, &hanging, &sensor).expect("one axis");
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
    assert!(mounting(&tumbling, &line, &hanging, &accel).is_err());
    let across: Vec<_> = (0..500)
        .map(|k| [(3000.0 * (f64::from(k) * 0.1).sin()) as i16, 0, 0])
        .collect();
    let error = mounting(&across, &line, &hanging, &accel).expect_err("axis along x");
    assert!(error.to_string().contains("45°"), "{error}");
}

#[test]
fn centre_of_mass_from_two_and_three_lines() {
    let truth = Vector2::new(0.012, -0.079);
    for lines in [2, 3] {
        let mut z = ChiSquared::default();
        let mut of_length = ChiSquared::default();
        let seeds = 2000;
        for seed in 0..seeds {
            let mut noise = Noise::new(5000 + seed);
            let mark = |noise: &mut Noise| Vector2::new(noise.one(), noise.one()) * 5e-4;
            let suspended = [
                Vector2::new(0.1, 0.02),
                Vector2::new(-0.09, 0.03),
                Vector2::new(0.05, 0.11),
            ];
            let drawn: Vec<_> = suspended[..lines]
                .iter()
                .map(|point| PlumbLine {
                    first: point + mark(&mut noise),
                    second: point + (truth - point) * 1.4 + mark(&mut noise),
                })
                .collect();
            let pivot = mark(&mut noise);
            let found = centre_of_mass(&drawn, pivot, 5e-4).expect("lines that cross");
            for axis in 0..2 {
                z.add(
                    found.position_m[axis] - truth[axis],
                    found.covariance_m2[(axis, axis)].sqrt(),
                );
            }
            of_length.add(
                found.pivot_to_com_m - truth.norm(),
                found.pivot_to_com_std_m,
            );
        }
        // With three lines one degree of freedom enlarges the covariance where χ² exceeds one:
        // E[1/max(1, χ²₁)] = 0.84 of the plain ratio.
        let expected = if lines == 2 { 1.0 } else { 0.84 };
        let name = format!("centre of mass from {lines} lines");
        z.assert_one(&name, 1.5 * seeds as f64, expected);
        assert!((of_length.sum / of_length.count - 1.0).abs() < 0.2);
    }
}

#[test]
fn nearly_parallel_plumb_lines_are_refused() {
    let line = |x: f64| PlumbLine {
        first: Vector2::new(x, 0.0),
        second: Vector2::new(x * 1.05, -0.1),
    };
    let error = centre_of_mass(&[line(0.01), line(-0.01)], Vector2::zeros(), 5e-4);
    assert!(matches!(error, Err(CalibrationError::NotDetermined { .. })));
}

/// The converter's line of the thesis: rpm = 8.53108 count − 6594.5.
#[test]
fn line_of_the_converter() {
    let (slope, offset) = (8.53108, -6594.5);
    let mut z = ChiSquared::default();
    let seeds = 500;
    for seed in 0..seeds {
        let mut noise = Noise::new(6000 + seed);
        let points: Vec<_> = (0..40)
            .map(|k| {
                let count = 100.0 + f64::from(k) * 35.0;
                (count, slope * count + offset + 20.0 * noise.one())
            })
            .collect();
        let found = fit_line(&points).expect("forty points");
        z.add(found.slope - slope, found.slope_std);
        z.add(found.offset - offset, found.offset_std);
        assert!((found.at(100.0) - (100.0 * found.slope + found.offset)).abs() < 1e-9);
        assert!(found.correlation < -0.8, "{}", found.correlation);
    }
    z.assert_one("line", seeds as f64, 38.0 / 36.0);
    assert!(fit_line(&[(1.0, 2.0), (1.0, 3.0), (1.0, 4.0)]).is_err());
    assert!(fit_line(&[(1.0, 2.0), (2.0, f64::NAN), (3.0, 4.0)]).is_err());
}

/// With noise below half a count the mean keeps the rounding's error, and the stated error
/// covers it.
#[test]
fn rounding_does_not_average_out() {
    let noiseless = vec![[4096, -3, 17]; 2000];
    let found = still(&noiseless).expect("enough samples");
    assert!((found.mean_std - Vector3::repeat((1.0_f64 / 12.0).sqrt())).norm() < 1e-12);
}
