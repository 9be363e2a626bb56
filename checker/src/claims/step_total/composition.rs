//! Claim `step-total` in random runs: the methods equal the composition of their parts.

use crate::claims::filter_accurate::constants::Filter;
use crate::claims::filter_accurate::equations::unit;
use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::claims::upright::Upright;
use crate::language::module::Module;

/// Runs `Attitude` against the functions that it is made of, word by word; of `Controller` the claim
/// `supervisor` speaks.
///
/// # Errors
/// The first case in which they differ.
pub fn composition(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let constants = f.constant("constants", "FILTER")?;
    // The reading of a calibrated magnetometer without a field: its bias.
    let no_field = Filter::of(module)?
        .mag
        .bias
        .map(|bias| bias.round() as i128);
    let one = 1 << 30;
    same(
        "Attitude::new",
        &[],
        &f.call("Attitude::new", &[])?,
        &[one, 0, 0, 0, 0, 0, 0, 0, 0],
    )?;
    let near = Upright::find(module);
    let mut random = Random::new(seed);
    for case in 0..cases {
        // Any attitude, or one near upright, where the pendulum is kept.
        let mut attitude: Vec<i128> = match &near {
            Some(near) if case % 2 == 0 => near.attitude(&f, 0.05 * random.real())?,
            _ => {
                let q = unit([0; 4].map(|_| random.real()));
                q.iter()
                    .map(|x| (x * 2f64.powi(30)).round() as i128)
                    .collect()
            }
        };
        attitude.extend([random.count(2f64.powi(28)), random.count(2f64.powi(28))]);
        let drift = [0; 3].map(|_| random.count(2f64.powi(29)));
        attitude.extend(drift);
        let mut triple = |limit: f64| [0; 3].map(|_| random.count(limit));
        let (gyro, mag) = (triple(20_000.0), triple(3_000.0));
        let accel = if case % 5 == 0 {
            triple(200.0)
        } else {
            triple(20_000.0)
        };
        let with = |parts: &[&[i128]]| -> Vec<i128> { [&attitude, &parts.concat()[..]].concat() };

        let words = f.call("Attitude::quaternion", &attitude)?;
        same("quaternion", &attitude, &words, &attitude[..4])?;
        let found = f.call("Attitude::update_imu", &with(&[&gyro, &accel]))?;
        let arguments = [&attitude[..], &gyro, &accel, constants].concat();
        let wanted = f.call("step_tracked", &arguments)?;
        same("update_imu", &attitude, &found, &wanted)?;
        // The step of six axes, and a turn of its quaternion; a field that is saturated or too weak does not turn it.
        let found = f.call("Attitude::update_marg", &with(&[&gyro, &accel, &mag]))?;
        let plain = wanted;
        let turn = [&plain[..6], &mag, constants].concat();
        let wanted = [&f.call("headed", &turn)?[..], &plain[6..]].concat();
        same("update_marg", &attitude, &found, &wanted)?;
        for useless in [[32_767, mag[1], mag[2]], no_field] {
            let found = f.call("Attitude::update_marg", &with(&[&gyro, &accel, &useless]))?;
            same("update_marg without a field", &attitude, &found, &plain)?;
        }
        // The filter's own state, without the drift, which an alignment leaves as it is.
        let state =
            |parts: &[&[i128]]| -> Vec<i128> { [&attitude[..6], &parts.concat()[..]].concat() };
        let kept = |words: Vec<i128>| [words, drift.to_vec()].concat();
        let found = f.call("Attitude::align", &with(&[&accel]))?;
        let mut wanted = f.call("align", &state(&[&accel, constants]))?;
        wanted.rotate_right(1);
        same("Attitude::align", &attitude, &found, &kept(wanted))?;
        let sum = triple(2f64.powi(29));
        let found = f.call("Attitude::align_to", &with(&[&sum]))?;
        let wanted = f.call("align_to", &state(&[&sum, constants]))?;
        same("align_to", &attitude, &found, &kept(wanted))?;
        let line = f.constant("constants", "RATE_LINE")?;
        let wanted = f.call("on_line", &[&attitude[4..5], line].concat())?;
        same(
            "rate",
            &attitude,
            &f.call("Attitude::rate", &attitude)?,
            &wanted,
        )?;
        let mounting = f.constant("constants", "MOUNTING_ANGLE")?;
        let radians = f.call("pivot_angle", &[&attitude[..4], mounting].concat())?[0];
        let limit = f.constant("constants", "ANGLE_MAX")?[0];
        let factor = f.constant("constants", "ANGLE_FACTOR")?[0];
        let shift = f.constant("constants", "ANGLE_SHIFT")?[0];
        if limit < 0 || !(0..32).contains(&shift) {
            return Err(format!("ANGLE_MAX is {limit}, ANGLE_SHIFT is {shift}"));
        }
        let wanted = (radians.clamp(-limit, limit) * factor) >> shift;
        let found = f.call("Attitude::angle", &attitude)?;
        same("Attitude::angle", &attitude, &found, &[wanted])?;
    }
    Ok(cases)
}
