//! Mean of a sensor at rest, with its standard error.

use crate::error::CalibrationError;
use crate::error::at_least;
use nalgebra::Vector3;

/// Batches for the standard error of the mean.
const BATCHES: usize = 20;

/// Variance of rounding to a whole count.
const ROUNDING: f64 = 1.0 / 12.0;

/// A part of a recording.
struct Batch {
    mean: Vector3<f64>,
    variance: Vector3<f64>,
}

/// The readings of a sensor at rest, in counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Still {
    /// Mean of the samples, counts.
    pub mean: Vector3<f64>,
    /// Standard error of the mean, counts.
    pub mean_std: Vector3<f64>,
    /// Standard deviation of a sample, counts.
    pub deviation: Vector3<f64>,
    /// Largest distance of the mean of one of 20 batches from their median, counts.
    pub wander: Vector3<f64>,
    /// Standard deviation that white noise alone gives a batch's mean, from the
    /// median of the variances within the batches.
    pub wander_of_noise: Vector3<f64>,
    /// Number of samples.
    pub count: usize,
}

/// Mean, noise and standard error from at least 40 samples of a resting sensor.
///
/// The standard error comes from the means of 20 batches, so that slow noise is included
/// (σ²/n holds for white noise only). If the noise is below half a count, it does not
/// average out the rounding; the variance of rounding, 1/12, is therefore added.
///
/// # Errors
/// Fewer than 40 samples.
pub fn still(samples: &[[i16; 3]]) -> Result<Still, CalibrationError> {
    at_least("samples at rest", samples.len(), 2 * BATCHES)?;
    let vector = |raw: &[i16; 3]| Vector3::from(raw.map(f64::from));
    let count = samples.len() as f64;
    let mean = samples.iter().map(vector).sum::<Vector3<f64>>() / count;
    let variance = samples
        .iter()
        .map(|raw| (vector(raw) - mean).map(|x| x * x))
        .sum::<Vector3<f64>>()
        / (count - 1.0);
    let length = samples.len() / BATCHES;
    let batches: Vec<Batch> = samples
        .chunks_exact(length)
        .take(BATCHES)
        .map(|batch| {
            let mean = batch.iter().map(vector).sum::<Vector3<f64>>() / length as f64;
            let squares = batch.iter().map(|raw| (vector(raw) - mean).map(|x| x * x));
            Batch {
                mean,
                variance: squares.sum::<Vector3<f64>>() / (length as f64 - 1.0).max(1.0),
            }
        })
        .collect();
    let between = batches
        .iter()
        .map(|batch| (batch.mean - mean).map(|x| x * x))
        .sum::<Vector3<f64>>()
        / ((BATCHES - 1) * BATCHES) as f64;
    let middle = |value: &dyn Fn(&Batch) -> f64| {
        let mut values: Vec<f64> = batches.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let wander = Vector3::from_fn(|axis, _| {
        let usual = middle(&|batch| batch.mean[axis]);
        let far = batches.iter().map(|batch| (batch.mean[axis] - usual).abs());
        far.fold(0.0, f64::max)
    });
    let wander_of_noise = Vector3::from_fn(|axis, _| {
        let variance = middle(&|batch| batch.variance[axis]).max(ROUNDING);
        (variance / length as f64).sqrt()
    });
    let mean_std = between.zip_map(&variance, |between, variance| {
        let rounding = if variance < 0.25 { ROUNDING } else { 0.0 };
        (between + rounding).sqrt()
    });
    Ok(Still {
        mean,
        mean_std,
        deviation: variance.map(f64::sqrt),
        wander,
        wander_of_noise,
        count: samples.len(),
    })
}
