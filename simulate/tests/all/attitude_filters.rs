//! Figure 3.3 of the thesis: the errors of the methods for the angle.

use crate::bench::model;
use attitude::AttitudeSpec;
use nalgebra::Vector3;
use simulate::RawSensors;
use simulate::attitude_filters::{FilterComparison, compare_filters};

const DURATION_S: f64 = 20.0;

fn swing(sensors: &RawSensors, spec: &AttitudeSpec) -> FilterComparison {
    let (model, values) = model(true);
    compare_filters(&model, &values, sensors, spec, 1.0, DURATION_S, 21).unwrap()
}

#[test]
fn integration_drifts_with_the_bias_and_the_filters_do_not() {
    let mut sensors = RawSensors::of_the_thesis().unwrap();
    // A bias of 0.5 °/s, as of a gyroscope that was calibrated some days ago.
    sensors.gyro.bias_counts *= 5.0;
    let spec = AttitudeSpec {
        lever_arm_m: sensors.lever_arm_m,
        ..AttitudeSpec::thesis()
    };
    let found = swing(&sensors, &spec);
    for (name, estimate) in found.estimates() {
        let error = found.rms_error_rad(estimate).to_degrees();
        println!("{name}: {error:.3}° RMS");
    }
    // The mean error over the run is half of the integral of the gyroscope's bias. The tolerance covers noise and bias
    // of the first reading (three times 2.8 mrad, 1.4 mrad), the lag of the low-pass, (α(T) − α(0)) 20 ms/T (2 mrad),
    // and the random walk of the noise (2 mrad).
    let bias = sensors.gyro.bias_counts[2] / sensors.gyro.per_unit[(2, 2)];
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let drift = mean(&found.low_pass_rad) - mean(&found.truth_rad);
    let expected = 0.5 * bias * DURATION_S;
    assert!((drift - expected).abs() < 0.014, "{drift} {expected}");

    let rms = |estimate: &[f64]| found.rms_error_rad(estimate);
    assert!(
        rms(&found.madgwick_rad) < 0.01,
        "{}",
        rms(&found.madgwick_rad)
    );
    assert!(rms(&found.madgwick_rad) < rms(&found.complementary_rad));
    assert!(rms(&found.madgwick_rad) < rms(&found.low_pass_rad));
    assert!(rms(&found.complementary_rad) < rms(&found.accelerometer_rad));
}

#[test]
fn perfect_sensors_leave_nothing_to_choose() {
    let fine = 1e-2;
    let mut sensors = RawSensors::of_the_thesis().unwrap();
    sensors.gyro.bias_counts = Vector3::zeros();
    sensors.accel.bias_counts = Vector3::zeros();
    sensors.gyro_noise_rad_s = 0.0;
    sensors.accel_noise_m_s2 = 0.0;
    sensors.lever_arm_m = [0.0; 2];
    let found = swing(&sensors, &AttitudeSpec::thesis());
    for (name, estimate) in found.estimates() {
        let error = found.rms_error_rad(estimate);
        // The low-pass lags by 20 ms of up to 10 rad/s, but its integral only by its own lag.
        let allowed = if name == "low-pass and integrate" {
            0.2
        } else {
            fine
        };
        assert!(error < allowed, "{name}: {error}");
    }
}
