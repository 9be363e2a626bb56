//! Random runs of the filter against its equations: tests, not proofs.

use crate::claims::filter_accurate::constants::Filter;
use crate::claims::filter_accurate::equations::{dot3, in_earth, madgwick, to_north, unit};
use crate::claims::functions::number;
use crate::claims::random::Random;
use crate::domains::machine::{Machine, Trap};
use crate::language::module::Module;
use crate::program::steps::Program;

/// Largest error of a quaternion's component in one step, without the error of the normalisation.
const COMPONENT_TOLERANCE: f64 = 2e-7;

/// The error of the third-order normalisation after a step by `turn` (half-angles, rad) and a correction by
/// `correction` (rad): 5 |ε|³/16, where ε = ‖q‖² − 1 is the sum of the squares of both.
fn left_by_normalisation(turn: [f64; 3], correction: f64) -> f64 {
    let excess = (dot3(turn, turn).sqrt() + correction).powi(2);
    5.0 / 16.0 * excess.powi(3)
}

/// Largest error of the pivot angle, rad.
const ANGLE_TOLERANCE: f64 = 1e-6;

/// Runs the filter on random attitudes and readings against the equations.
///
/// # Errors
/// The first case in which they differ by more than the tolerance, or the source fails.
pub fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let plain = Filter::of(module)?;
    let levered = plain.with_lever_arm()?;
    let get = |name: &str| {
        module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))
    };
    let programs = [get("step_imu")?, get("headed")?, get("align")?];
    let mounting = match module.constant("constants", "MOUNTING_ANGLE") {
        Some([word]) => *word,
        _ => return Err("src/constants.rs has no MOUNTING_ANGLE".to_owned()),
    };
    let mut pivot = Machine::new(get("pivot_angle")?);
    let mut random = Random::new(seed);
    for case in 0..cases {
        let filter = if case % 2 == 0 { &plain } else { &levered };
        let q = unit([0; 4].map(|_| random.real()));
        one_step(&programs, filter, q, &mut random)?;
        one_angle(
            &mut pivot,
            q,
            mounting + random.count(8e8) * i128::from(case % 3 == 0),
        )?;
    }
    Ok(cases)
}

fn one_step(
    programs: &[&Program; 3],
    filter: &Filter,
    q: [f64; 4],
    random: &mut Random,
) -> Result<(), String> {
    let [imu, headed, align] = programs;
    let q_words = q.map(|x| (x * 2f64.powi(30)).round() as i128);
    let gyro = [0; 3].map(|_| random.count(30_000.0));
    let scale = 10f64.powf(2.2 + 2.2 * (random.real() + 1.0) / 2.0);
    let accel = [0; 3].map(|_| random.count(scale));
    let mag = [0; 3].map(|_| random.count(3_000.0));
    let slow = random.count(2f64.powi(27));

    let half = filter.gyro.calibrated(gyro);
    let reading = filter.accel.calibrated(accel);
    let excess = half[2].round() - slow as f64;
    let squared = half[2] * half[2] / 2f64.powi(32);
    let limited = |v: f64| (v / 65_536.0).clamp(-(2f64.powi(29)), 2f64.powi(29));
    let up = [
        reading[0] + limited(squared * filter.centripetal[0] + excess * filter.tangential[1]),
        reading[1] + limited(squared * filter.centripetal[1] - excess * filter.tangential[0]),
        reading[2],
    ];
    let field = filter.mag.calibrated(mag);
    let squared_length = |v: [f64; 3]| dot3(v, v) / 2f64.powi(32);
    let gravity_min = number(&filter.words, ".gravity_squared_min")?;
    let field_min = number(&filter.words, ".field_squared_min")?;
    let is_clear = |value: f64, limit: f64| (value - limit).abs() > 4.0 + 1e-3 * limit;
    let state: Vec<i128> = q_words.into_iter().chain([0, slow]).collect();
    let turn = half.map(|h| h / 2f64.powi(32));

    let tolerance = COMPONENT_TOLERANCE + left_by_normalisation(turn, filter.beta_step);
    let near = |name: &str, found: &[i128], wanted: [f64; 4]| {
        for i in 0..4 {
            let value = found[i] as f64 / 2f64.powi(30);
            if (value - wanted[i]).abs() > tolerance {
                return Err(format!(
                    "{name}: component {i} is {value}, not {} (gyro {gyro:?}, accel {accel:?}, mag {mag:?}, q {q:?})",
                    wanted[i]
                ));
            }
        }
        Ok(())
    };
    let rates = |name: &str, found: &[i128]| {
        let slower = (slow as f64 + half[2]) / 2.0;
        if (found[4] as f64 - half[2]).abs() > 3.0 || (found[5] as f64 - slower).abs() > 4.0 {
            return Err(format!("{name}: rates {found:?} for gyro {gyro:?}"));
        }
        Ok(())
    };

    if is_clear(squared_length(up), gravity_min) {
        let is_usable = filter.accel.shows(accel) && squared_length(up) > gravity_min;
        let usable = is_usable.then_some(up);
        let arguments = |parts: &[&[i128]]| -> Vec<i128> {
            let mut all = state.clone();
            for part in parts {
                all.extend_from_slice(part);
            }
            all.extend(filter.flat());
            all
        };
        let trapped = |trap: Trap| trap.to_string();
        let mut machine = Machine::new(imu);
        let found = machine
            .call(&arguments(&[&gyro, &accel]))
            .map_err(trapped)?;
        near(
            "step_imu",
            found,
            madgwick(q, turn, usable, filter.beta_step),
        )?;
        rates("step_imu", found)?;
    }
    let length = squared_length(field);
    let north = in_earth(q, unit(field));
    let horizontal = north[0].hypot(north[1]);
    // At the border between two rules, rounding may choose either.
    let is_known = is_clear(length, field_min)
        && (horizontal - 1.0 / 16.0).abs() > 1e-4
        && north[0].abs() > 1e-6
        && (north[0] > 0.0 || north[1].abs() > 1e-6);
    if is_known {
        let is_seen = filter.mag.shows(mag) && length > field_min && horizontal > 1.0 / 16.0;
        let seen = is_seen.then_some(north);
        let mut arguments = state.clone();
        arguments.extend_from_slice(&mag);
        arguments.extend(filter.flat());
        let mut machine = Machine::new(headed);
        let found = machine.call(&arguments).map_err(|trap| trap.to_string())?;
        near("headed", found, to_north(q, seen, filter.beta_step))?;
        if found[4..] != state[4..] {
            return Err(format!("headed: rates {found:?} of {state:?}"));
        }
    }
    one_alignment(align, filter, &state, accel, reading, gravity_min)
}

/// The alignment turns the vertical onto the reading by the shortest way.
fn one_alignment(
    align: &Program,
    filter: &Filter,
    state: &[i128],
    accel: [i128; 3],
    reading: [f64; 3],
    gravity_min: f64,
) -> Result<(), String> {
    let squared = dot3(reading, reading) / 2f64.powi(32);
    if (squared - gravity_min).abs() < 4.0 + 1e-3 * gravity_min {
        return Ok(());
    }
    let mut arguments = state.to_vec();
    arguments.extend_from_slice(&accel);
    arguments.extend(filter.flat());
    let mut machine = Machine::new(align);
    let found = machine.call(&arguments).map_err(|trap| trap.to_string())?;
    let is_usable = filter.accel.shows(accel) && squared > gravity_min;
    if found[6] != i128::from(is_usable) {
        return Err(format!("align: usable is {} for {accel:?}", found[6]));
    }
    let a = unit(reading);
    // The nearer the reading points straight down, the less certain the axis of the turn is. The calibration is
    // accurate to three units.
    let direction = COMPONENT_TOLERANCE + 3.0 / dot3(reading, reading).sqrt();
    let tolerance = direction / (2.0 * (1.0 + a[2])).sqrt().clamp(0.1, 1.0);
    let wanted = if is_usable && a[2] > -0.99 {
        unit([1.0 + a[2], a[1], -a[0], 0.0])
    } else if is_usable {
        return Ok(());
    } else {
        [0, 1, 2, 3].map(|i| state[i] as f64 / 2f64.powi(30))
    };
    for i in 0..4 {
        let value = found[i] as f64 / 2f64.powi(30);
        if (value - wanted[i]).abs() > tolerance {
            return Err(format!(
                "align: component {i} is {value}, not {}, for {accel:?}",
                wanted[i]
            ));
        }
    }
    Ok(())
}

/// θ = atan2(−v_y, v_x) − m.
fn one_angle(pivot: &mut Machine, q: [f64; 4], mounting: i128) -> Result<(), String> {
    let words = q.map(|x| (x * 2f64.powi(30)).round() as i128);
    let mounting = mounting.clamp(-843_314_856, 843_314_856);
    let [w, x, y, z] = q;
    let (up_x, up_y) = (2.0 * (x * z - w * y), 2.0 * (w * x + y * z));
    let share = up_x.hypot(up_y);
    if share < 1e-3 {
        return Ok(());
    }
    let mut arguments = words.to_vec();
    arguments.push(mounting);
    let found = pivot.call(&arguments).map_err(|trap| trap.to_string())?[0] as f64;
    let wanted = (-up_y).atan2(up_x) - mounting as f64 / 2f64.powi(28);
    let error = found / 2f64.powi(28) - wanted;
    let turns = (error / std::f64::consts::TAU).round();
    let error = error - turns * std::f64::consts::TAU;
    if error.abs() * share > ANGLE_TOLERANCE {
        return Err(format!("pivot_angle: off by {error} rad for {words:?}"));
    }
    if found.abs() > std::f64::consts::PI * 2f64.powi(28) + 2.0 {
        return Err(format!("pivot_angle: {found} is not wrapped"));
    }
    Ok(())
}
