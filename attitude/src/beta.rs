//! The filter gain β from the gyroscope's error.

/// β of a gyroscope whose rate is wrong by at most `gyro_error_rad_s` on each axis
/// (Madgwick 2010, eq. 50): β = √(3/4) ω̃.
///
/// A constant error ω̃ on all three axes rotates the estimate with |½ q ⊗ ω̃| = ½ √3 ω̃, and the
/// correction rotates it back with β: this is the smallest gain that compensates the error. A larger gain
/// only lets more of the accelerometer's noise through.
pub fn beta_from_gyro_error(gyro_error_rad_s: f64) -> f64 {
    0.75_f64.sqrt() * gyro_error_rad_s.abs()
}

/// β of a gyroscope with white noise of density `noise_rad_s_rthz` (rad/s/√Hz) whose bias is
/// known to a standard deviation `bias_std_rad_s` (rest bias and its drift together).
///
/// Rule: ω̃ = 3 √(σ_bias² + n²/T), three standard deviations of the rate error that remains
/// after the noise is averaged over T = 1 s, about the settling time of the filter.
pub fn beta_from_gyro_noise(noise_rad_s_rthz: f64, bias_std_rad_s: f64) -> f64 {
    const AVERAGING_TIME_S: f64 = 1.0;
    let noise = noise_rad_s_rthz / AVERAGING_TIME_S.sqrt();
    beta_from_gyro_error(3.0 * bias_std_rad_s.hypot(noise))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The report's own example (chapter 5): 5 °/s gives 0.0756.
    #[test]
    fn reports_example() {
        let beta = beta_from_gyro_error(5.0_f64.to_radians());
        assert!((beta - 0.0756).abs() < 5e-5, "{beta}");
    }

    #[test]
    fn noise_and_bias_add_as_variances() {
        let both = beta_from_gyro_noise(4e-4, 3e-4);
        assert!((both - beta_from_gyro_error(15e-4)).abs() < 1e-15);
    }
}
