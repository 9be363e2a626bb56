//! Gyroscope at rest.

use crate::common::{ChiSquared, Noise, counts};
use calibrate::gyroscope_rest;
use nalgebra::Vector3;

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
