//! Centre of mass from plumb lines.

use crate::common::{ChiSquared, Noise};
use calibrate::{CalibrationError, PlumbLine, centre_of_mass};
use nalgebra::Vector2;

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
