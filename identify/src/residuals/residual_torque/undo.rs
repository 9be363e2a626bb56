//! From the reading of a sensor back to the measured quantity: the sensor effects of the model are inverted.

use plant::{Output, Plant, State};

/// Number of rounds in which a curved characteristic is inverted. Each round multiplies the error by the eccentricity's
/// share.
const ROUNDS: usize = 40;
/// Below this, in the unit of the output, a characteristic is straight and an inversion has ended.
const STRAIGHT: f64 = 1e-12;

/// The reading of an output whose true value is given.
fn said(plant: &Plant<f64>, output: Output, value: f64) -> f64 {
    output.of(&plant.read(&State {
        angle_rad: value,
        rate_rad_s: value,
        wheel_speed_rad_s: value,
        ..State::rest()
    }))
}

/// The true values behind the samples of an output in its unit, and the factor by which the sensor enlarges a change.
pub(super) fn undone(
    plant: &Plant<f64>,
    output: Output,
    samples: &[f64],
    time_s: &[f64],
) -> (Vec<f64>, f64) {
    let (bias, one) = (said(plant, output, 0.0), said(plant, output, 1.0));
    let scale = one - bias;
    let bend = said(plant, output, -1.0) + one - 2.0 * bias;
    let straight = samples.iter().map(|sample| (sample - bias) / scale);
    let (values, scale) = if bend.abs() < STRAIGHT {
        (straight.collect(), scale.abs())
    } else {
        let inverted = samples
            .iter()
            .map(|&sample| inverted(plant, output, sample));
        (inverted.collect(), 1.0)
    };
    let (lag_s, delay_s) = plant.sensor_times_s(output);
    (in_time(values, time_s, lag_s, delay_s), scale)
}

/// The true value whose reading is `sample`, for a sensor whose reading is close to the true value.
fn inverted(plant: &Plant<f64>, output: Output, sample: f64) -> f64 {
    let mut value = sample;
    for _ in 0..ROUNDS {
        let error = said(plant, output, value) - sample;
        value -= error;
        if error.abs() < STRAIGHT {
            break;
        }
    }
    value
}

/// The input of a lag T and a delay δ from their output y: v(t) = y(t + δ) + T ẏ(t + δ). The slope is taken over ±T, so
/// that noise is not amplified. At the ends of the log, where samples are missing, the last value is kept.
fn in_time(values: Vec<f64>, time_s: &[f64], lag_s: f64, delay_s: f64) -> Vec<f64> {
    if lag_s <= 0.0 && delay_s <= 0.0 {
        return values;
    }
    let at = |asked_s: f64| -> f64 {
        let after = time_s.partition_point(|&sample_s| sample_s < asked_s);
        let (Some(before), true) = (after.checked_sub(1), after < time_s.len()) else {
            return values[after.min(values.len() - 1)];
        };
        let share = (asked_s - time_s[before]) / (time_s[after] - time_s[before]);
        values[before] + share * (values[after] - values[before])
    };
    let moved = |&sample_s: &f64| {
        let asked_s = sample_s + delay_s;
        if lag_s > 0.0 {
            at(asked_s) + 0.5 * (at(asked_s + lag_s) - at(asked_s - lag_s))
        } else {
            at(asked_s)
        }
    };
    time_s.iter().map(moved).collect()
}
