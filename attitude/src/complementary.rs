//! Complementary filter about one axis.
//!
//! Above the frequency 1/τ, the integral of the rate is used; below, the accelerometer's angle:
//! θ ← θ + ω T, then θ ← θ + (1 − e^(−T/τ)) (θ_a − θ), with the difference taken on the circle.
//! A rate bias b causes a constant error b·τ instead of a drift.

use crate::pivot_angle::wrap_angle;

/// Angle from one rate and one accelerometer angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complementary {
    share: f64,
    sample_time_s: f64,
    angle_rad: f64,
}

impl Complementary {
    /// Starts at `angle_rad` (rad). Times in s.
    pub fn new(angle_rad: f64, time_constant_s: f64, sample_time_s: f64) -> Self {
        Complementary {
            share: -(-sample_time_s / time_constant_s).exp_m1(),
            sample_time_s,
            angle_rad,
        }
    }

    /// Processes the rate (rad/s) and, if it can be used, the accelerometer's angle (rad);
    /// returns the angle (rad) in [−π, π).
    pub fn update(&mut self, rate_rad_s: f64, measured_angle_rad: Option<f64>) -> f64 {
        self.angle_rad += rate_rad_s * self.sample_time_s;
        if let Some(measured) = measured_angle_rad {
            self.angle_rad += self.share * wrap_angle(measured - self.angle_rad);
        }
        self.angle_rad = wrap_angle(self.angle_rad);
        self.angle_rad
    }
}
