//! Magnetometer: hard and soft iron.

use crate::common::{ChiSquared, Noise, counts};
use calibrate::{magnetometer, sphere_coverage, usable_readings};
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

/// Readings that overflowed, and an axis that stops at the end of its range, are left out and
/// counted; the fit to the other readings is good, and its bias is within 4 counts.
#[test]
fn overflows_and_clipped_axes_are_left_out() {
    for seed in 0..40 {
        let mut noise = Noise::new(9000 + seed);
        let bias = Vector3::new(1500.0, -200.0, 80.0);
        let limit: i16 = 1500 + 300;
        let mut samples: Vec<[i16; 3]> = (0..1200)
            .map(|_| counts(noise.direction() * 480.0 + bias + noise.three(3.0)))
            .map(|[x, y, z]| [x.min(limit), y, z])
            .collect();
        let overflowed = 1 + seed as usize % 5;
        for index in 0..overflowed {
            let value = [32_767, -32_768, 12_000][index % 3];
            samples[37 * (index + 1)][index % 3] = value;
        }
        let found = usable_readings(&samples, [32_767; 3]);
        assert_eq!(found.overflowed, overflowed, "seed {seed}");
        // A cap of height (1 − 300/480)/2 of the sphere is clipped.
        let [(axis, end, times)] = found.clipped[..] else {
            panic!("seed {seed}: {:?}", found.clipped);
        };
        assert_eq!((axis, end), ("x", limit), "seed {seed}");
        assert!((150..300).contains(&times), "seed {seed}: {times}");
        let fit = magnetometer(&found.readings, 48.0).expect("most of the sphere");
        assert!(fit.fits(), "seed {seed}: {}", fit.spread_after);
        let off = (fit.sensor.line.bias_counts - bias).norm();
        assert!(off < 4.0, "seed {seed}: {off}");
    }
}

/// No reading is left out of a whole sphere, of a small or large radius in counts.
#[test]
fn a_whole_sphere_is_not_clipped() {
    for (seed, radius, readings) in [(1, 480.0, 1200), (2, 60.0, 5000), (3, 5000.0, 600)] {
        let mut noise = Noise::new(9100 + seed);
        let samples: Vec<_> = (0..readings)
            .map(|_| counts(noise.direction() * radius + noise.three(0.01 * radius)))
            .collect();
        let found = usable_readings(&samples, [32_767; 3]);
        assert_eq!(found.readings.len(), readings, "radius {radius}: {found:?}");
    }
}

/// Readings that lie on no ellipsoid, as near a motor that was switched on, are reported as not fitting.
#[test]
fn another_field_is_noticed() {
    let mut noise = Noise::new(77);
    let samples: Vec<_> = (0..1000)
        .map(|k| {
            let motor = if k % 2 == 0 { 90.0 } else { 0.0 };
            counts(noise.direction() * (480.0 + motor) + noise.three(3.0))
        })
        .collect();
    let found = magnetometer(&samples, 48.0).expect("readings all round");
    assert!(!found.fits(), "{}", found.spread_after);
}
