//! Gyroscope: bias at rest, noise, and the filter gain that follows from them.

use crate::error::{CalibrationError, positive};
use crate::sensor_calibration::SensorCalibration;
use crate::still::{Still, still};
use attitude::{SensorLine, beta_from_gyro_noise};
use nalgebra::{Matrix3, Vector3};

/// A gyroscope at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroscopeRest {
    /// Line in rad/s per count: the bias is measured, the scale is the data sheet's.
    pub sensor: SensorCalibration,
    /// Mean, noise and standard error, counts.
    pub rest: Still,
    /// Noise density of the noisiest axis, rad/s/√Hz, if the noise is white up to half the
    /// sampling frequency: σ √(2 T).
    pub noise_rad_s_rthz: f64,
    /// Change of the bias from the first to the second half of the recording, rad/s.
    pub drift_rad_s: Vector3<f64>,
    /// Madgwick's β by the rule of [`beta_from_gyro_noise`], with the larger of drift and
    /// standard error as the bias' uncertainty; rad/s.
    pub beta_rad_s: f64,
}

/// A batch mean this many standard deviations away is not noise; Gaussian noise exceeds it once in 10¹⁵.
const NOISE_DEVIATIONS: f64 = 8.0;

/// Largest rate that counts as a wandering bias, rad/s: 0.2 °/s, several times
/// the in-run bias instability over minutes in the data sheets of such sensors. A larger rate is a rotation.
const BIAS_WANDER_RAD_S: f64 = 3.5e-3;

/// Refuses a recording that contains a rotation.
fn require_still(rest: &Still, scale: f64) -> Result<(), CalibrationError> {
    for (index, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let (wander, noise) = (rest.wander[index], rest.wander_of_noise[index]);
        if wander > NOISE_DEVIATIONS * noise && wander * scale > BIAS_WANDER_RAD_S {
            return Err(CalibrationError::NotStill {
                axis,
                wander,
                rate_deg_s: (wander * scale).to_degrees(),
                noise,
            });
        }
    }
    Ok(())
}

/// Bias and noise from at least 80 samples at rest, taken every `sample_time_s`; `scale` in
/// rad/s per count.
///
/// # Errors
/// Too few samples; a scale or sample time that is not positive; a sensor that turned.
pub fn gyroscope_rest(
    samples: &[[i16; 3]],
    scale: f64,
    sample_time_s: f64,
) -> Result<GyroscopeRest, CalibrationError> {
    let scale = positive("the gyroscope's scale", scale)?;
    let period = positive("the sample time", sample_time_s)?;
    crate::error::at_least("samples at rest", samples.len(), 80)?;
    let rest = still(samples)?;
    require_still(&rest, scale)?;
    let (first, second) = samples.split_at(samples.len() / 2);
    let drift_rad_s = (still(second)?.mean - still(first)?.mean) * scale;
    let noise_rad_s_rthz = rest.deviation.max() * scale * (2.0 * period).sqrt();
    let bias_std = drift_rad_s.amax().max(rest.mean_std.max() * scale);
    Ok(GyroscopeRest {
        sensor: SensorCalibration {
            line: SensorLine {
                bias_counts: rest.mean,
                matrix: Matrix3::from_diagonal_element(scale),
            },
            bias_std: rest.mean_std,
            matrix_std: Matrix3::zeros(),
        },
        rest,
        noise_rad_s_rthz,
        drift_rad_s,
        beta_rad_s: beta_from_gyro_noise(noise_rad_s_rthz, bias_std),
    })
}
