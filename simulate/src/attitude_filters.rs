//! The methods for the angle that the thesis discusses (its figure 3.3), compared on one simulated
//! free swing: low-pass the rate and integrate it; complementary filter; Madgwick's filter. All
//! receive the same raw counts.

use crate::error::{SimulateError, check_positive};
use crate::raw_counts::RawSensors;
use attitude::{
    AttitudeSpec, Complementary, LowPassIntegrator, RawFilter, pivot_angle_of_gravity, wrap_angle,
};
use plant::{Drive, Kind, Model, Plant, State};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Time constant of the low-pass on the rate, s: 8 Hz, five times the swing's frequency.
pub const LOW_PASS_S: f64 = 0.02;
/// Time constant of the complementary filter, s: above the swing's period, so that the
/// accelerometer's motion averages out.
pub const COMPLEMENTARY_S: f64 = 1.0;

/// Body angles during the swing, rad from hanging; one entry per sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilterComparison {
    /// Time in s.
    pub time_s: Vec<f64>,
    /// The true angle.
    pub truth_rad: Vec<f64>,
    /// From the direction of the accelerometer alone.
    pub accelerometer_rad: Vec<f64>,
    /// The low-passed rate, integrated.
    pub low_pass_rad: Vec<f64>,
    /// Complementary filter.
    pub complementary_rad: Vec<f64>,
    /// Madgwick's filter on six axes.
    pub madgwick_rad: Vec<f64>,
}

impl FilterComparison {
    /// The estimates, with their names.
    pub fn estimates(&self) -> [(&'static str, &[f64]); 4] {
        [
            ("accelerometer alone", &self.accelerometer_rad),
            ("low-pass and integrate", &self.low_pass_rad),
            ("complementary", &self.complementary_rad),
            ("Madgwick, six axes", &self.madgwick_rad),
        ]
    }

    /// RMS error of an estimate, rad.
    pub fn rms_error_rad(&self, estimate: &[f64]) -> f64 {
        let sum: f64 = estimate
            .iter()
            .zip(&self.truth_rad)
            .map(|(estimate, truth)| (estimate - truth).powi(2))
            .sum();
        (sum / self.truth_rad.len().max(1) as f64).sqrt()
    }
}

/// Lets the body of `model` swing from rest at `start_rad` from hanging for `duration_s`, and estimates the
/// angle with every filter. `sensors` produce the counts; `spec` holds the calibration that the filters use.
///
/// # Errors
/// Times that are not positive; a motion that is no longer finite.
pub fn compare_filters(
    model: &Model,
    values: &[f64],
    sensors: &RawSensors,
    spec: &AttitudeSpec,
    start_rad: f64,
    duration_s: f64,
    seed: u64,
) -> Result<FilterComparison, SimulateError> {
    check_positive("the sample time in s", spec.sample_time_s)?;
    check_positive("the duration in s", duration_s)?;
    let plant = Plant::new(model, values, Kind::FreeSwing);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut state = State {
        angle_rad: start_rad,
        ..State::rest()
    };
    let still = sensors.sample(&state, 0.0, &mut random);
    // Filters count from upright within ±π; here hanging is zero.
    let from_hanging = |from_upright: f64| wrap_angle(from_upright + PI);
    let seen =
        |accel: [i16; 3]| pivot_angle_of_gravity(&spec.accel.apply(accel), spec.mounting_angle_rad);
    let start = seen(still.accel);
    let mut low_pass = LowPassIntegrator::new(from_hanging(start), LOW_PASS_S, spec.sample_time_s);
    let mut complementary = Complementary::new(start, COMPLEMENTARY_S, spec.sample_time_s);
    let mut madgwick = RawFilter::new(spec);
    madgwick.align(still.accel);

    let mut found = FilterComparison::default();
    let samples = (duration_s / spec.sample_time_s).round() as usize + 1;
    for sample in 0..samples {
        let (acceleration, _) = plant.derivative(&state, 0.0, 0.0);
        let counts = sensors.sample(&state, acceleration, &mut random);
        let rate_rad_s = spec.gyro.apply(counts.gyro).z;
        let angle = seen(counts.accel);
        madgwick.update_imu(counts.gyro, counts.accel);
        found.time_s.push(sample as f64 * spec.sample_time_s);
        found.truth_rad.push(state.angle_rad);
        found.accelerometer_rad.push(from_hanging(angle));
        found.low_pass_rad.push(low_pass.update(rate_rad_s));
        found
            .complementary_rad
            .push(from_hanging(complementary.update(rate_rad_s, Some(angle))));
        found.madgwick_rad.push(from_hanging(madgwick.angle_rad()));
        let free = Drive {
            current_a: 0.0,
            push: [0.0; 3],
        };
        state = plant.step(&state, &free, spec.sample_time_s);
        if !(state.angle_rad + state.rate_rad_s).is_finite() {
            return Err(SimulateError::NotFinite {
                time_s: sample as f64 * spec.sample_time_s,
            });
        }
    }
    Ok(found)
}
