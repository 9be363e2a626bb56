//! Magnetometer: hard and soft iron.

use crate::common::{ChiSquared, Noise, counts};
use calibrate::{magnetometer, sphere_coverage};
use nalgebra::{Matrix3, Vector3};

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
