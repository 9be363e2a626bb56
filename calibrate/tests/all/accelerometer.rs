//! Accelerometer: bias, scales and cross-axis terms from poses.

use crate::common::{ChiSquared, GRAVITY, Noise, counts, pose_directions};
use calibrate::{CalibrationError, Shape, accelerometer, still};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

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

/// With noise below half a count the mean keeps the rounding's error, and the stated error
/// covers it.
#[test]
fn rounding_does_not_average_out() {
    let noiseless = vec![[4096, -3, 17]; 2000];
    let found = still(&noiseless).expect("enough samples");
    assert!((found.mean_std - Vector3::repeat((1.0_f64 / 12.0).sqrt())).norm() < 1e-12);
}
