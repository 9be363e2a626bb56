//! Claim `step-total` in random runs: the methods are put together from their parts.

use crate::claims::filter_accurate::constants::Filter;
use crate::claims::filter_accurate::equations::unit;
use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::claims::upright::Upright;
use crate::language::module::Module;

/// Runs `Attitude` and `Controller` against the functions that they are made of, word by word.
///
/// # Errors
/// The first case in which they differ.
pub fn composition(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let constants = f.constant("constants", "FILTER")?;
    // What a calibrated magnetometer reads where there is no field: its bias.
    let no_field = Filter::of(module)?
        .mag
        .bias
        .map(|bias| bias.round() as i128);
    let one = 1 << 30;
    same(
        "Attitude::new",
        &[],
        &f.call("Attitude::new", &[])?,
        &[one, 0, 0, 0, 0, 0],
    )?;
    let new = [one, 0, 0, 0, 0, 0, 0, 0, 0];
    for name in ["Controller::new", "Controller::default"] {
        same(name, &[], &f.call(name, &[])?, &new)?;
    }
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
        let wanted = f.call("step_imu", &with(&[&gyro, &accel, constants]))?;
        same("update_imu", &attitude, &found, &wanted)?;
        let found = f.call("Attitude::update_marg", &with(&[&gyro, &accel, &mag]))?;
        let wanted = f.call("step_marg", &with(&[&gyro, &accel, &mag, constants]))?;
        same("update_marg", &attitude, &found, &wanted)?;
        // A field that is saturated or too weak is not used.
        let plain = f.call("Attitude::update_imu", &with(&[&gyro, &accel]))?;
        for useless in [[32_767, mag[1], mag[2]], no_field] {
            let found = f.call("Attitude::update_marg", &with(&[&gyro, &accel, &useless]))?;
            same("update_marg without a field", &attitude, &found, &plain)?;
        }
        let found = f.call("Attitude::align", &with(&[&accel]))?;
        let mut wanted = f.call("align", &with(&[&accel, constants]))?;
        wanted.rotate_right(1);
        same("Attitude::align", &attitude, &found, &wanted)?;
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

        let flags = [i128::from(case % 3 == 0), i128::from(case % 2 == 0)];
        let mag = (case % 7 < 3).then_some(mag);
        let bias = [random.count(2f64.powi(28))];
        let state = [&attitude[..], &flags, &bias].concat();
        for (name, flag) in [("Controller::arm", 1), ("Controller::disarm", 0)] {
            let mut wanted = state.clone();
            wanted[7] = flag;
            same(name, &state, &f.call(name, &state)?, &wanted)?;
        }
        let adc = random.count(4095.0).abs();
        one_sample(&f, &state, gyro, accel, mag, adc)?;
    }
    Ok(cases)
}

/// `Controller::step`, put together anew.
fn one_sample(
    f: &Functions,
    state: &[i128],
    gyro: [i128; 3],
    accel: [i128; 3],
    mag: Option<[i128; 3]>,
    adc: i128,
) -> Result<(), String> {
    let mut attitude = state[..6].to_vec();
    let (mut is_aligned, is_armed, bias_state) = (state[6], state[7], state[8]);
    if is_aligned == 0 {
        let result = f.call("Attitude::align", &[&attitude, &accel[..]].concat())?;
        is_aligned = result[0];
        attitude = result[1..].to_vec();
    }
    attitude = match mag {
        Some(mag) => {
            let arguments = [&attitude, &gyro[..], &accel, &mag].concat();
            f.call("Attitude::update_marg", &arguments)?
        }
        None => f.call(
            "Attitude::update_imu",
            &[&attitude, &gyro[..], &accel].concat(),
        )?,
    };
    let angle = f.call("Attitude::angle", &attitude)?[0];
    let rate = f.call("Attitude::rate", &attitude)?[0];
    let speed = f.call("wheel_speed", &[adc])?[0];
    let states = [angle, rate, speed];
    let observer = f.constant("constants", "BIAS_OBSERVER")?;
    let (duty, next) = if is_armed == 1 {
        let bias = f.call(
            "estimated_bias",
            &[&[bias_state], &states[..], observer].concat(),
        )?[0];
        let current = f.call("control", &[angle - bias, rate, speed])?;
        let arguments = [&[bias_state], &states[..], &current, observer].concat();
        (
            f.call("duty", &current)?[0],
            f.call("advanced", &arguments)?[0],
        )
    } else {
        let zero = f.constant("constants", "ZERO_CURRENT")?[0];
        (
            zero,
            f.call("waiting", &[&states[..], observer].concat())?[0],
        )
    };
    let mut arguments = state.to_vec();
    arguments.extend(gyro);
    arguments.extend(accel);
    arguments.push(i128::from(mag.is_some()));
    arguments.extend(mag.unwrap_or_default());
    arguments.push(adc);
    let wanted = [&[duty], &attitude[..], &[is_aligned, is_armed, next]].concat();
    same(
        "Controller::step",
        &arguments,
        &f.call("Controller::step", &arguments)?,
        &wanted,
    )
}
