//! Gyroscope at rest.

use crate::common::{ChiSquared, Noise, counts};
use calibrate::{CalibrationError, gyroscope_rest};
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

/// A sensor that turns by a few degrees for a second or two of its recording is noticed, whichever axis it turns about.
/// A sensor that lies still, or whose bias drifts slowly by 0.1 °/s, passes.
#[test]
fn a_turn_while_lying_still_is_refused() {
    let scale = 62.5e-3_f64.to_radians();
    for seed in 0..60 {
        let mut noise = Noise::new(8000 + seed);
        let axis = (seed % 3) as usize;
        let turned_deg = 3.0 + (seed % 7) as f64;
        let mut record = |rate_deg_s: &dyn Fn(f64) -> f64| {
            let samples: Vec<_> = (0..8000)
                .map(|k| {
                    let mut reading = Vector3::new(11.0, -7.0, 5.0) + noise.three(3.0);
                    reading[axis] += rate_deg_s(f64::from(k) * 1e-3) / 62.5e-3;
                    counts(reading)
                })
                .collect();
            gyroscope_rest(&samples, scale, 1e-3)
        };
        let from_s = 0.05 * (seed % 40) as f64 + 1.0;
        let turn = |time_s: f64| {
            if (from_s..from_s + 2.0).contains(&time_s) {
                0.5 * turned_deg
            } else {
                0.0
            }
        };
        match record(&turn) {
            Err(CalibrationError::NotStill { axis: name, .. }) => {
                assert_eq!(name, ["x", "y", "z"][axis], "seed {seed}");
            }
            other => panic!("seed {seed}: {other:?}"),
        }
        assert!(record(&|_| 0.0).is_ok(), "seed {seed}");
        assert!(record(&|time_s| 0.1 * time_s / 8.0).is_ok(), "seed {seed}");
    }
}
