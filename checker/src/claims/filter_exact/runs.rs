//! Runs of the source, compared with the second implementation of its functions.

use crate::claims::filter_exact::draw::Draw;
use crate::claims::filter_exact::second::*;
use crate::domains::machine::Machine;
use crate::language::module::Module;

/// Runs every function of the filter against [`crate::claims::filter_exact::second`].
///
/// # Errors
/// The first arguments for which a word differs.
pub fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    constants(module)?;
    let mut draw = Draw::new(seed);
    let same = |name: &str, arguments: &[i128], wanted: &[i128]| {
        let program = module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))?;
        let mut machine = Machine::new(program);
        let found = machine
            .call(arguments)
            .map_err(|trap| format!("{name}: {trap}"))?;
        if found == wanted {
            Ok(())
        } else {
            Err(format!(
                "{name} of {arguments:?} is {found:?}, not {wanted:?}"
            ))
        }
    };
    // Where pieces of one argument can meet, in any case.
    let powers = (0..31).flat_map(|bits| [-1, 0, 1].map(|step| (1_i128 << bits) + step));
    for n in powers.filter(|n| (0..=i32::MAX.into()).contains(n)) {
        same("inverse_length", &[n], &[inverse_length(n, 2)])?;
        same("coarse_inverse_length", &[n], &[inverse_length(n, 1)])?;
        same("arc_tangent_q31", &[n], &[arc_tangent(n)])?;
        if (1 << 28..ONE).contains(&n) {
            same("inverse_root_q30", &[n], &[inverse_root(n, 2)])?;
            same("coarse_inverse_root_q30", &[n], &[inverse_root(n, 1)])?;
        }
        if (1 << 29..=ONE).contains(&n) {
            same("reciprocal_q29", &[n], &[reciprocal(n)])?;
        }
    }
    for _ in 0..cases {
        let n = draw.within(1 << 28, ONE - 1);
        same("seed", &[n], &[root_seed(n)])?;
        same("inverse_root_q30", &[n], &[inverse_root(n, 2)])?;
        same("coarse_inverse_root_q30", &[n], &[inverse_root(n, 1)])?;
        let y = draw.within(0, 0x4c00_0000);
        same("root::refined", &[2 * n, y], &[root_step(2 * n, y)])?;
        let n = draw.within(i32::MIN.into(), i32::MAX.into());
        same("inverse_length", &[n], &[inverse_length(n, 2)])?;
        same("coarse_inverse_length", &[n], &[inverse_length(n, 1)])?;

        let n = draw.within(1 << 29, ONE);
        same("reciprocal_q29", &[n], &[reciprocal(n)])?;
        let r = draw.within(-0x0c00_0000, 0x5a00_0000);
        same("arc_tangent::refined", &[n, r], &[reciprocal_step(n, r)])?;
        let t = draw.within(0, i32::MAX.into());
        same("arc_tangent_q31", &[t], &[arc_tangent(t)])?;
        let v = draw.vector(2, ONE);
        same("arc_tangent2", &v, &[arc_tangent2(v[0], v[1])])?;
        same("scaled_up2", &v, &scaled(&v, 31))?;
        let near = [PI, -PI, TWO_PI, -TWO_PI][draw.0.choice(4) as usize];
        let near = (near + draw.0.choice(5) as i128 - 2).clamp(-2 * PI, 2 * PI);
        for angle in [near, draw.within(-2 * PI, 2 * PI)] {
            same("wrapped", &[angle], &[wrapped(angle)])?;
        }
        let v = draw.vector(3, ONE);
        same("scaled_up3", &v, &scaled(&v, 15))?;
        same("length_squared", &v, &[squares(&v)])?;
        same("unit_q28", &v, &unit(&v))?;
        let v = draw.vector(4, 7 << 28);
        same("scaled_up4", &v, &scaled(&v, 31))?;
        let v = draw.at_power(2, 30);
        same("scaled_up2", &v, &scaled(&v, 31))?;
        let v = draw.at_power(3, 30);
        same("scaled_up3", &v, &scaled(&v, 15))?;
        let v = draw.at_power(4, 30);
        same("scaled_up4", &v, &scaled(&v, 31))?;

        attitude(&mut draw, &same)?;
        steps(&mut draw, module, &same)?;
        let raw = draw.vector(3, 32_767);
        let line = draw.sensor_line();
        let arguments = [&raw[..], &line].concat();
        same("calibrate", &arguments, &calibrated(&raw, &line))?;
    }
    Ok(cases)
}

fn attitude(
    draw: &mut Draw,
    same: &impl Fn(&str, &[i128], &[i128]) -> Result<(), String>,
) -> Result<(), String> {
    let (q, measured, field) = (draw.quaternion(), draw.direction(), draw.direction());
    let beta = draw.within(0, (1 << 29) - 1);
    let mounting = draw.within(-PI, PI);
    same("up_q28", &q, &up(&q))?;
    same(
        "pivot_angle",
        &[&q[..], &[mounting]].concat(),
        &[pivot_angle(&q, mounting)],
    )?;
    same(
        "correction_imu",
        &[&q[..], &measured, &[beta]].concat(),
        &correction_imu(&q, &measured, beta),
    )?;
    let limit = beta >> 3;
    for field in [field, near_north(draw, &q)] {
        same(
            "heading_turn",
            &[&q[..], &field, &[limit]].concat(),
            &[heading_turn(&q, &field, limit)],
        )?;
    }
    let half = draw.within(-limit, limit);
    same(
        "turned_about_up",
        &[&q[..], &[half]].concat(),
        &turned_about_up(&q, half),
    )?;
    // A gradient that just stops the correction, and any other.
    let least = 1 << 8;
    let corners = [least, -least];
    let just = (0..4).map(|_| draw.at_corners(-least - 1, least + 1, &corners));
    for gradient in [just.collect(), draw.vector(4, 7 << 28)] {
        same(
            "scaled_correction",
            &[&gradient[..], &[least, beta]].concat(),
            &correction(&gradient, least, beta),
        )?;
    }
    // The level sensor in a field that just leaves the vertical, 2²⁴ of 2²⁸ to one side.
    let mut aslant = vec![0, 0, 1 << 28];
    aslant[draw.0.choice(2) as usize] = (1 << 24) + draw.0.choice(64) as i128 - 32;
    let level = [ONE, 0, 0, 0];
    same(
        "heading_turn",
        &[&level[..], &aslant, &[limit]].concat(),
        &[heading_turn(&level, &aslant, limit)],
    )?;
    // At rest the gradient is as small as its least value, which stops the correction.
    let at_rest: Words = up(&q)
        .iter()
        .map(|x| (x + draw.within(-400, 400)).clamp(-(5 << 27), 5 << 27))
        .collect();
    same(
        "correction_imu",
        &[&q[..], &at_rest, &[beta]].concat(),
        &correction_imu(&q, &at_rest, beta),
    )?;
    let turn = draw.vector(3, 1 << 29);
    let mut direction = draw.vector(4, 7 << 28);
    direction.push(draw.within(0, 1 << 25));
    same(
        "turned",
        &[&q[..], &turn, &direction].concat(),
        &turned(&q, &turn, &direction),
    )?;
    let error = rate_error(&q, &direction);
    same("rate_error", &[&q[..], &direction].concat(), &error)?;
    same("normalised", &q, &normalised(&q))?;
    same("aligned", &measured, &aligned(&measured))?;
    let mut near_down =
        [0; 3].map(|_| draw.at_corners(-0x4_0001, 0x4_0001, &[1 << 18, -(1 << 18)]));
    near_down[2] -= 1 << 28;
    same("aligned", &near_down, &aligned(&near_down))
}

/// A field of length 1 that lies near the estimated north, or south, where pieces of the turn meet.
fn near_north(draw: &mut Draw, q: &[i128]) -> Words {
    let [w, x, y, z] = four(q);
    let north = [
        (1 << 28) - 2 * nearest(y * y + z * z),
        2 * nearest(x * y - w * z),
        2 * nearest(w * y + x * z),
    ];
    let sign = 1 - 2 * draw.0.choice(2) as i128;
    let off = 1_i128 << draw.0.choice(24);
    north
        .iter()
        .map(|part| (sign * part + draw.within(-off, off)).clamp(-(5 << 27), 5 << 27))
        .collect()
}

/// Whole steps with the bench's constants or any calibration: any counts, each sensor saturated now and then without the
/// others, and least lengths that the readings just reach, or just miss.
fn steps(
    draw: &mut Draw,
    module: &Module,
    same: &impl Fn(&str, &[i128], &[i128]) -> Result<(), String>,
) -> Result<(), String> {
    let words = module
        .constant("constants", "FILTER")
        .filter(|words| words.len() == 58)
        .ok_or("constants::FILTER has not the 58 words of its documents")?;
    let mut filter = Filter {
        words: words.to_vec(),
    };
    // Any calibration, so that none can stand for another.
    for sensor in 0..3 {
        if draw.0.choice(2) == 0 {
            let line = draw.sensor_line();
            filter.words.splice(14 * sensor..14 * (sensor + 1), line);
        }
    }
    let mut counts = |limit: i128| {
        let mut counts: Words = (0..3).map(|_| draw.within(-limit, limit)).collect();
        if draw.0.choice(6) == 0 {
            counts[draw.0.choice(3) as usize] = [-32_768, 32_767][draw.0.choice(2) as usize];
        }
        counts
    };
    let (gyro, accel, mag) = (counts(20_000), counts(20_000), counts(3_000));
    let mut state = draw.of_length(4, ONE as f64);
    state.extend([
        draw.within(-(1 << 28), 1 << 28),
        draw.within(-(1 << 28), 1 << 28),
    ]);
    let turn = calibrated(&gyro, filter.gyro());
    let up = filter.gravity(&accel, turn[2], state[5]);
    let field = calibrated(&mag, filter.mag());
    for (at, length) in [
        (Filter::GRAVITY_MIN, squares(&up)),
        (Filter::FIELD_MIN, squares(&field)),
    ] {
        if draw.0.choice(2) == 0 {
            filter.words[at] = (length + draw.0.choice(3) as i128 - 1).clamp(1, (1 << 31) - 1);
        }
    }
    let words = &filter.words;
    same(
        "step_imu",
        &[&state[..], &gyro, &accel, words].concat(),
        &filter.step(&state, &gyro, &accel),
    )?;
    let limit = words[57];
    let drift: Words = (0..3).map(|_| draw.within(-limit, limit)).collect();
    same(
        "step_tracked",
        &[&state[..], &drift, &gyro, &accel, words].concat(),
        &filter.tracked(&state, &drift, &gyro, &accel),
    )?;
    same(
        "headed",
        &[&state[..], &mag, words].concat(),
        &filter.headed(&state, &mag),
    )?;
    let up = calibrated(&accel, filter.accel());
    let is_usable = filter.shows_gravity(&accel, &up);
    let mut next = state.clone();
    if is_usable {
        next.splice(..4, aligned(&unit(&up)));
    }
    next.push(i128::from(is_usable));
    same("align", &[&state[..], &accel, words].concat(), &next)
}

/// The named constants that stand for numbers of mathematics or bounds of a format.
fn constants(module: &Module) -> Result<(), String> {
    let known = [
        ("arc_tangent", "PI_Q28", PI),
        ("arc_tangent", "HALF_PI_Q28", HALF_PI),
        ("arc_tangent", "QUARTER_PI_Q28", QUARTER_PI),
        ("arc_tangent", "TWO_PI_Q28", TWO_PI),
        ("madgwick", "ONE", ONE),
        ("madgwick", "COMPONENT_MAX", COMPONENT_MAX),
        ("scaling", "SCALED_MIN", 1 << 29),
        ("calibration", "CALIBRATED_MAX", 1 << 29),
        ("lever_arm", "CORRECTION_MAX", 1 << 29),
        ("drift", "DRIFT_MAX", 1 << 30),
        ("madgwick", "GRADIENT_MIN_IMU", 1 << 8),
        ("madgwick", "HORIZONTAL_SQUARED_MIN", 1 << 21),
    ];
    let names = ["C0", "C1", "C2", "C3", "C4", "C5", "C6"];
    let series = names.iter().zip(ARC_TANGENT.iter().rev());
    let series = series.map(|(name, wanted)| ("arc_tangent", *name, *wanted));
    for (file, name, wanted) in known.into_iter().chain(series) {
        match module.constant(file, name) {
            Some([found]) if *found == wanted => {}
            found => return Err(format!("{file}::{name} is {found:?}, not {wanted}")),
        }
    }
    Ok(())
}
