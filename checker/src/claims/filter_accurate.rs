//! Random runs of the interpreted source against what it stands for: tests, not proofs.
//!
//! The control law is compared in exact integers with the words of the certificate. The attitude
//! filter is compared with Madgwick's equations (report of 2010, eq. 25 to 46) in double precision,
//! written here from the paper. Beside [`crate::claims::filter_exact`], which draws its numbers with it, this is
//! the only file with floating point.

use crate::certificate::reader::Certificate;
use crate::domains::machine::Machine;
use crate::language::module::Module;
use crate::program::steps::Program;

/// Largest error of a quaternion's component in one step.
const COMPONENT_TOLERANCE: f64 = 2e-7;

/// Largest error of the pivot angle, rad.
const ANGLE_TOLERANCE: f64 = 1e-6;

/// A small generator of random numbers (xorshift64*), so that a run can be repeated.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// From a seed other than zero.
    pub fn new(seed: u64) -> Random {
        Random(seed.max(1))
    }

    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// A word of random length, so that small ones are as frequent as large ones.
    fn word(&mut self) -> i128 {
        let shift = self.next() % 32;
        let word = (self.next() >> 32) as u32 as i32;
        i128::from(word >> shift.min(31))
    }

    /// Uniform within [-1, 1).
    fn real(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Uniform within [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// One of `0..count`.
    pub fn choice(&mut self, count: u64) -> u64 {
        self.next() % count
    }

    /// An integer within ±`limit`.
    fn count(&mut self, limit: f64) -> i128 {
        (self.real() * limit) as i128
    }
}

/// Words at which integer code breaks.
const EXTREMES: [i128; 11] = [
    i32::MIN as i128,
    i32::MIN as i128 + 1,
    -(1 << 30),
    -65_536,
    -1,
    0,
    1,
    65_535,
    1 << 30,
    i32::MAX as i128 - 1,
    i32::MAX as i128,
];

/// Runs `control` on extreme and random words against the words of the certificate, in exact
/// integers: within half a unit of the saturated law, and monotone.
///
/// # Errors
/// The first words for which it is not.
pub fn control(
    module: &Module,
    certificate: &Certificate,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let program = module.function("control").ok_or("there is no `control`")?;
    if program.arguments.len() != 3 || program.results.len() != 1 {
        return Err("`control` does not take three words and give one".to_owned());
    }
    let mut machine = Machine::new(program);
    let mut random = Random::new(seed);
    let mut done = 0;
    for a in EXTREMES {
        for b in EXTREMES {
            for c in EXTREMES {
                one_command(&mut machine, certificate, [a, b, c])?;
                done += 1;
            }
        }
    }
    for _ in 0..cases {
        let words = [random.word(), random.word(), random.word()];
        let command = one_command(&mut machine, certificate, words)?;
        let state = (random.next() % 3) as usize;
        let mut raised = words;
        raised[state] = (words[state] + random.word().abs()).min(i32::MAX.into());
        let other = one_command(&mut machine, certificate, raised)?;
        let rises = certificate.constants[state].raw >= 0;
        if (rises && other < command) || (!rises && other > command) {
            return Err(format!("not monotone between {words:?} and {raised:?}"));
        }
        done += 1;
    }
    Ok(done)
}

fn one_command(
    machine: &mut Machine,
    certificate: &Certificate,
    words: [i128; 3],
) -> Result<i128, String> {
    let [a, b, c, limit] = &certificate.constants;
    let shift = certificate.bounds.shift.clamp(1, 62);
    let command = machine.call(&words).map_err(|trap| trap.to_string())?[0];
    let exact =
        i128::from(a.raw) * words[0] + i128::from(b.raw) * words[1] + i128::from(c.raw) * words[2];
    let limit = i128::from(limit.raw.max(0)) << shift;
    let error = (command << shift) - exact.clamp(-limit, limit);
    if error.abs() > 1 << (shift - 1) {
        return Err(format!(
            "the command for {words:?} is {command}, off by {error}/2^{shift} units"
        ));
    }
    Ok(command)
}

/// The constants of the filter as numbers.
#[derive(Clone, Debug)]
struct Filter {
    words: Vec<(String, i128)>,
    gyro: Sensor,
    accel: Sensor,
    mag: Sensor,
    beta_step: f64,
    centripetal: [f64; 2],
    tangential: [f64; 2],
}

/// M (raw − bias), in the units of the words.
#[derive(Clone, Debug)]
struct Sensor {
    bias: [f64; 3],
    matrix: [[f64; 3]; 3],
}

impl Sensor {
    fn read(words: &[(String, i128)], name: &str) -> Result<Sensor, String> {
        let get = |field: String| number(words, &format!(".{name}.{field}"));
        let mut bias = [0.0; 3];
        let mut matrix = [[0.0; 3]; 3];
        let shift = get("shift".to_owned())?;
        for i in 0..3 {
            bias[i] = get(format!("bias[{i}]"))? / 32_768.0;
            for (row, letter) in ["x", "y", "z"].into_iter().enumerate() {
                matrix[row][i] = get(format!("{letter}[{i}]"))? / 2f64.powf(17.0 + shift);
            }
        }
        Ok(Sensor { bias, matrix })
    }

    fn calibrated(&self, raw: [i128; 3]) -> [f64; 3] {
        let v = [0, 1, 2].map(|i| raw[i] as f64 - self.bias[i]);
        self.matrix.map(|row| dot3(row, v))
    }
}

fn number(words: &[(String, i128)], name: &str) -> Result<f64, String> {
    words
        .iter()
        .find(|(known, _)| known.ends_with(name))
        .map(|(_, word)| *word as f64)
        .ok_or_else(|| format!("the filter has no constant {name}"))
}

impl Filter {
    fn of(module: &Module) -> Result<Filter, String> {
        let words = module
            .constant_words("constants", "FILTER")
            .ok_or("src/constants.rs has no FILTER")?;
        Filter::new(words)
    }

    fn new(words: Vec<(String, i128)>) -> Result<Filter, String> {
        let get = |name: &str| number(&words, name);
        Ok(Filter {
            gyro: Sensor::read(&words, "gyro")?,
            accel: Sensor::read(&words, "accel")?,
            mag: Sensor::read(&words, "mag")?,
            beta_step: get(".beta")? / 2f64.powi(35),
            centripetal: [
                get(".lever_arm.centripetal[0]")?,
                get(".lever_arm.centripetal[1]")?,
            ],
            tangential: [
                get(".lever_arm.tangential[0]")?,
                get(".lever_arm.tangential[1]")?,
            ],
            words,
        })
    }

    /// The constants with a lever arm, which many benches do not have.
    fn with_lever_arm(&self) -> Result<Filter, String> {
        let mut words = self.words.clone();
        let values = [
            (".lever_arm.centripetal[0]", 91_000),
            (".lever_arm.centripetal[1]", -57_000),
            (".lever_arm.tangential[0]", 13_000_000),
            (".lever_arm.tangential[1]", -9_000_000),
        ];
        for (name, value) in values {
            for (known, word) in &mut words {
                if known.ends_with(name) {
                    *word = value;
                }
            }
        }
        Filter::new(words)
    }

    fn flat(&self) -> impl Iterator<Item = i128> + '_ {
        self.words.iter().map(|(_, word)| *word)
    }
}

fn dot3(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit<const N: usize>(v: [f64; N]) -> [f64; N] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// One step: q + ½ q ⊗ ω T − β T ∇/‖∇‖, normalised.
fn madgwick(
    q: [f64; 4],
    half: [f64; 3],
    up: Option<[f64; 3]>,
    field: Option<[f64; 3]>,
    beta_step: f64,
) -> [f64; 4] {
    let [w, x, y, z] = q;
    let [a, b, c] = half;
    let turn = [
        -x * a - y * b - z * c,
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
    ];
    let mut next = [0, 1, 2, 3].map(|i| q[i] + turn[i]);
    if let Some(up) = up {
        let gradient = unit(gradient(q, unit(up), field.map(unit)));
        for i in 0..4 {
            next[i] -= beta_step * gradient[i];
        }
    }
    unit(next)
}

/// Jᵀ f of the vertical and, with a field, of the field (eq. 25, 26, 29 to 34).
fn gradient(q: [f64; 4], measured_up: [f64; 3], field: Option<[f64; 3]>) -> [f64; 4] {
    let [w, x, y, z] = q;
    let up = [
        2.0 * (x * z - w * y),
        2.0 * (w * x + y * z),
        1.0 - 2.0 * (x * x + y * y),
    ];
    let up_slopes = [
        [-2.0 * y, 2.0 * z, -2.0 * w, 2.0 * x],
        [2.0 * x, 2.0 * w, 2.0 * z, 2.0 * y],
        [0.0, -4.0 * x, -4.0 * y, 0.0],
    ];
    let mut vertical = [0, 1, 2].map(|i| up[i] - measured_up[i]);
    let mut gradient = [0.0; 4];
    if let Some(field) = field {
        let north = [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (w * y + x * z),
        ];
        let west = [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ];
        let north_slopes = [
            [0.0, 0.0, -4.0 * y, -4.0 * z],
            [-2.0 * z, 2.0 * y, 2.0 * x, -2.0 * w],
            [2.0 * y, 2.0 * z, 2.0 * w, 2.0 * x],
        ];
        let horizontal = dot3(north, field).hypot(dot3(west, field));
        let field_up = dot3(up, field);
        for i in 0..3 {
            let error = horizontal * north[i] + field_up * up[i] - field[i];
            vertical[i] += field_up * error;
            for j in 0..4 {
                gradient[j] += horizontal * north_slopes[i][j] * error;
            }
        }
    }
    for i in 0..3 {
        for j in 0..4 {
            gradient[j] += up_slopes[i][j] * vertical[i];
        }
    }
    gradient
}

/// Runs the filter on random attitudes and readings against the equations.
///
/// # Errors
/// The first case in which they differ by more than the tolerance, or the source fails.
pub fn filter(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let plain = Filter::of(module)?;
    let levered = plain.with_lever_arm()?;
    let get = |name: &str| {
        module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))
    };
    let programs = [get("step_imu")?, get("step_marg")?, get("align")?];
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
    let [imu, marg, align] = programs;
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

    let near = |name: &str, found: &[i128], wanted: [f64; 4]| {
        for i in 0..4 {
            let value = found[i] as f64 / 2f64.powi(30);
            if (value - wanted[i]).abs() > COMPONENT_TOLERANCE {
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
        let usable = (squared_length(up) > gravity_min).then_some(up);
        let arguments = |parts: &[&[i128]]| -> Vec<i128> {
            let mut all = state.clone();
            for part in parts {
                all.extend_from_slice(part);
            }
            all.extend(filter.flat());
            all
        };
        let trapped = |trap: crate::domains::machine::Trap| trap.to_string();
        let mut machine = Machine::new(imu);
        let found = machine
            .call(&arguments(&[&gyro, &accel]))
            .map_err(trapped)?;
        near(
            "step_imu",
            found,
            madgwick(q, turn, usable, None, filter.beta_step),
        )?;
        rates("step_imu", found)?;

        // Near the vertical the field shows no heading, and the gradient depends on it.
        let field_unit = unit(field);
        let vertical = {
            let [w, x, y, z] = q;
            let up = [
                2.0 * (x * z - w * y),
                2.0 * (w * x + y * z),
                1.0 - 2.0 * (x * x + y * y),
            ];
            dot3(up, field_unit)
        };
        let is_heading = 1.0 - vertical * vertical;
        let has_field = squared_length(field) > field_min;
        if is_clear(squared_length(field), field_min) && (is_heading - 1.0 / 256.0).abs() > 1e-4 {
            let seen = (has_field && is_heading > 1.0 / 256.0).then_some(field);
            let mut machine = Machine::new(marg);
            let found = machine
                .call(&arguments(&[&gyro, &accel, &mag]))
                .map_err(trapped)?;
            near(
                "step_marg",
                found,
                madgwick(q, turn, usable, seen, filter.beta_step),
            )?;
            rates("step_marg", found)?;
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
    let is_usable = squared > gravity_min;
    if found[6] != i128::from(is_usable) {
        return Err(format!("align: usable is {} for {accel:?}", found[6]));
    }
    let a = unit(reading);
    // The turn's axis is the less certain the nearer the reading points straight down.
    // The calibration is good to three units.
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

/// Runs `Controller::step` on random samples: the duty is that of the law at the filter's own
/// angle, rate and speed.
///
/// # Errors
/// The first sample for which it is not.
pub fn step(
    module: &Module,
    certificate: &Certificate,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let get = |name: &str| {
        module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))
    };
    let step = get("Controller::step")?;
    let mut angle = Machine::new(get("Attitude::angle")?);
    let mut rate = Machine::new(get("Attitude::rate")?);
    let mut speed = Machine::new(get("wheel_speed")?);
    let mut control = Machine::new(get("control")?);
    let mut machine = Machine::new(step);
    let trapped = |trap: crate::domains::machine::Trap| trap.to_string();
    let own = step
        .inputs
        .iter()
        .filter(|name| name.starts_with("self."))
        .count();
    let armed = step
        .inputs
        .iter()
        .position(|name| name == "self.is_armed")
        .ok_or("the controller has no flag is_armed")?;
    let has_observer = module
        .constant("constants", "BIAS_OBSERVER")
        .is_some_and(|words| words.iter().take(9).any(|word| *word != 0));
    let wheel = module
        .constant_words("constants", "WHEEL_SPEED_LINE")
        .ok_or("src/constants.rs has no WHEEL_SPEED_LINE")?;
    let counts = f64::from(certificate.drive.duty_max) - f64::from(certificate.drive.duty_zero);
    let range: f64 = certificate
        .drive
        .current_range_a
        .text
        .parse()
        .map_err(|_| "the drive's range is no number")?;
    let current_unit = 2f64.powi(-(certificate.output.fraction_bits as i32));

    let mut state = Machine::new(get("Controller::new")?)
        .call(&[])
        .map_err(trapped)?
        .to_vec();
    let mut random = Random::new(seed);
    for case in 0..cases {
        let is_armed = case % 4 != 0;
        state[armed] = i128::from(is_armed);
        let mut arguments = state.clone();
        // The body leans a little about the pivot axis (the sensor's z): gravity along x.
        let lean = random.real() * 0.2;
        let (sin, cos) = lean.sin_cos();
        arguments.extend([0; 2].map(|_| random.count(300.0)));
        arguments.push(random.count(2_000.0));
        arguments.extend([
            (cos * 4096.0) as i128,
            (-sin * 4096.0) as i128,
            random.count(50.0),
        ]);
        let has_field = case % 2 == 0;
        arguments.push(i128::from(has_field));
        arguments.extend([0; 3].map(|_| random.count(500.0)));
        let adc = random.count(850.0).abs() * 2;
        arguments.push(adc);
        let result = machine.call(&arguments).map_err(trapped)?.to_vec();
        state = result[1..=own].to_vec();

        let found_speed = speed.call(&[adc]).map_err(trapped)?[0];
        let line = |name: &str| number(&wheel, name);
        let exact =
            ((adc as f64) * line(".scale")? + line(".offset")?) / 2f64.powf(line(".shift")?);
        let exact = exact.clamp(line(".low")?, line(".high")?);
        if (found_speed as f64 - (exact - 0.5)).abs() > 1.0 {
            return Err(format!("wheel_speed: {found_speed} for {adc} counts"));
        }
        if has_observer {
            continue;
        }
        let attitude: Vec<i128> = step
            .inputs
            .iter()
            .zip(&state)
            .filter(|(name, _)| name.starts_with("self.attitude."))
            .map(|(_, word)| *word)
            .collect();
        let words = [
            angle.call(&attitude).map_err(trapped)?[0],
            rate.call(&attitude).map_err(trapped)?[0],
            found_speed,
        ];
        let command = control.call(&words).map_err(trapped)?[0];
        let current = if is_armed {
            command as f64 * current_unit
        } else {
            0.0
        };
        let wanted = f64::from(certificate.drive.duty_zero) + counts * current / range;
        if (result[0] as f64 - wanted).abs() > 0.501 {
            return Err(format!(
                "Controller::step: duty {} for a current of {current} A, not {wanted}",
                result[0]
            ));
        }
    }
    Ok(cases)
}

/// Runs the bias observer with random constants against its equations.
///
/// # Errors
/// The first case in which they differ.
pub fn bias_observer(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let get = |name: &str| {
        module
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))
    };
    let estimate = get("estimated_bias")?;
    let advance = get("advanced")?;
    let wait = get("waiting")?;
    let mut random = Random::new(seed);
    for _ in 0..cases {
        let mut constants: Vec<i128> = Vec::new();
        // Short shifts reach the state's limit.
        let state_shift = 18 + random.count(10.0).abs();
        let names: Vec<&str> = estimate
            .inputs
            .iter()
            .filter_map(|name| name.strip_prefix("observer."))
            .collect();
        let mut value = std::collections::HashMap::new();
        for name in names {
            let word = match name {
                "state_shift" => state_shift,
                "angle_shift" => 29,
                "limit" => 1 << 26,
                "unit" => 1 << 28,
                _ => random.count(2f64.powi(27)),
            };
            value.insert(name.to_owned(), word);
            constants.push(word);
        }
        let get = |name: &str| value.get(name).copied().unwrap_or(0);
        let z = random.count(2f64.powi(28));
        let states = [0; 3].map(|_| random.count(2f64.powi(28)));
        let current = random.count(2f64.powi(29));
        let sum = |name: &str| -> i128 {
            (0..3)
                .map(|i| states[i] * get(&format!("{name}[{i}]")))
                .sum()
        };
        let rounded = |sum: i128, shift: i128, limit: i128| {
            let half = 1_i128 << (shift - 1);
            ((sum + half) >> shift).clamp(-limit, limit)
        };
        let most = i128::from(i32::MAX);
        let call = |program: &Program, head: &[i128]| -> Result<i128, String> {
            let mut arguments = head.to_vec();
            arguments.extend(&constants);
            let mut machine = Machine::new(program);
            Ok(machine.call(&arguments).map_err(|trap| trap.to_string())?[0])
        };
        let [a, b, c] = states;
        let cases = [
            (
                "estimated_bias",
                call(estimate, &[z, a, b, c])?,
                rounded(
                    z * get("unit") + sum("direct"),
                    get("angle_shift"),
                    get("limit"),
                ),
            ),
            (
                "advanced",
                call(advance, &[z, a, b, c, current])?,
                rounded(
                    z * get("decay") + sum("from_states") + current * get("from_current"),
                    get("state_shift"),
                    most,
                ),
            ),
            (
                "waiting",
                call(wait, &[a, b, c])?,
                rounded(-sum("direct"), get("state_shift"), most),
            ),
        ];
        for (name, found, wanted) in cases {
            if found != wanted {
                return Err(format!("{name} is {found}, not {wanted}"));
            }
        }
    }
    Ok(cases)
}

/// Functions by name, run on words.
struct Functions<'a>(&'a Module);

impl Functions<'_> {
    fn call(&self, name: &str, arguments: &[i128]) -> Result<Vec<i128>, String> {
        let program = self
            .0
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))?;
        Machine::new(program)
            .call(arguments)
            .map(<[i128]>::to_vec)
            .map_err(|trap| format!("{name}: {trap}"))
    }

    fn constant(&self, file: &str, name: &str) -> Result<&[i128], String> {
        self.0
            .constant(file, name)
            .ok_or_else(|| format!("there is no constant {file}::{name}"))
    }
}

fn same(what: &str, arguments: &[i128], found: &[i128], wanted: &[i128]) -> Result<(), String> {
    if found == wanted {
        Ok(())
    } else {
        Err(format!(
            "{what} of {arguments:?} is {found:?}, not {wanted:?}"
        ))
    }
}

fn near(what: &str, argument: i128, found: i128, wanted: f64, units: f64) -> Result<(), String> {
    if (found as f64 - wanted).abs() <= units {
        Ok(())
    } else {
        Err(format!("{what} of {argument} is {found}, not {wanted}"))
    }
}

/// Runs the primitives against what they stand for: products, clamps and lines exactly; scaling by
/// its definition; roots, reciprocal and arc tangent within the errors that their documents state.
///
/// # Errors
/// The first case in which they differ.
pub fn primitives(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let mut random = Random::new(seed);
    for case in 0..cases {
        let (a, b) = (random.word(), random.word());
        same(
            "mul_high",
            &[a, b],
            &f.call("mul_high", &[a, b])?,
            &[(a * b) >> 32],
        )?;
        let sum = (random.word() << 29) + random.word();
        let wanted = (sum + (1 << 31)) >> 32;
        same(
            "round_high",
            &[sum],
            &f.call("round_high", &[sum])?,
            &[wanted],
        )?;
        let (low, high) = (b.min(a), b.max(a));
        let value = random.word();
        let arguments = [value, low, high];
        same(
            "clamp",
            &arguments,
            &f.call("clamp", &arguments)?,
            &[value.clamp(low, high)],
        )?;
        let limit = a.abs().min(i32::MAX.into());
        let wide = (random.word() << 10) + random.word();
        let arguments = [wide, limit];
        let wanted = wide.clamp(-limit, limit);
        same(
            "clamp_wide",
            &arguments,
            &f.call("clamp_wide", &arguments)?,
            &[wanted],
        )?;
        let wanted = (a >> 1) + (b >> 1);
        same(
            "slow_rate",
            &[a, b],
            &f.call("slow_rate", &[a, b])?,
            &[wanted],
        )?;
        let shift = 1 + random.count(30.0).abs();
        let line = [
            value,
            random.word() >> 2,
            random.word() << 20,
            shift,
            low,
            high,
        ];
        let wanted = ((line[0] * line[1] + line[2]) >> shift).clamp(low, high);
        same("on_line", &line, &f.call("on_line", &line)?, &[wanted])?;
        motion(&f, &mut random)?;
        saturation(&f, &mut random, case)?;
        scaling(&f, &mut random)?;
        roots(&f, &mut random)?;
        calibration(&f, &mut random)?;
    }
    Ok(cases)
}

/// The lever-arm correction with any lever.
fn motion(f: &Functions, random: &mut Random) -> Result<(), String> {
    let limit = 1_i128 << 29;
    let accel = [0; 3].map(|_| random.count(limit as f64));
    let shift = random.next() % 20;
    let [rate, slow] = [0; 2].map(|_| random.count(limit as f64) >> shift);
    let arm = [0; 4].map(|_| random.count(2f64.powi(30)) >> (random.next() % 24));
    let squared = (rate * rate + (1 << 31)) >> 32;
    let excess = rate - slow;
    let x = (squared * arm[0] + excess * arm[3]) >> 16;
    let y = (squared * arm[1] - excess * arm[2]) >> 16;
    let wanted = [
        accel[0] + x.clamp(-limit, limit),
        accel[1] + y.clamp(-limit, limit),
        accel[2],
    ];
    let arguments = [&accel[..], &[rate, slow], &arm].concat();
    let found = f.call("without_motion", &arguments)?;
    same("without_motion", &arguments, &found, &wanted)
}

fn saturation(f: &Functions, random: &mut Random, case: usize) -> Result<(), String> {
    let ends = [-32_768, -32_767, 32_766, 32_767, 0, -16_384, 16_383];
    let mut raw = [0; 3].map(|_| random.count(30_000.0));
    raw[case % 3] = ends[case / 3 % ends.len()];
    let wanted = raw.iter().any(|count| [-32_768, 32_767].contains(count));
    same(
        "is_saturated",
        &raw,
        &f.call("is_saturated", &raw)?,
        &[i128::from(wanted)],
    )
}

/// A scaled vector is the vector times a power of two; its largest component is at least 2²⁹.
fn scaling(f: &Functions, random: &mut Random) -> Result<(), String> {
    // Least component for which that is promised, and the range that is kept.
    let kinds = [
        ("scaled_up2", 2, 1, 1_i128 << 30),
        ("scaled_up3", 3, 1 << 14, 1 << 30),
        ("scaled_up4", 4, 1, 7 << 28),
    ];
    for (name, length, least, limit) in kinds {
        let shift = random.next() % 31;
        let v: Vec<i128> = (0..length)
            .map(|_| random.count(limit as f64) >> shift)
            .collect();
        let found = f.call(name, &v)?;
        let largest = |v: &[i128]| v.iter().map(|x| x.abs()).max().unwrap_or(0);
        let factor = largest(&found) / largest(&v).max(1);
        let is_scaled =
            factor.count_ones() == 1 && v.iter().zip(&found).all(|(x, y)| x * factor == *y);
        let is_long = largest(&v) < least || largest(&found) >= 1 << 29;
        let is_zero = largest(&v) == 0 && largest(&found) == 0;
        if !(is_zero || is_scaled && is_long) || largest(&found) > limit {
            return Err(format!("{name} of {v:?} is {found:?}"));
        }
    }
    Ok(())
}

fn roots(f: &Functions, random: &mut Random) -> Result<(), String> {
    let one = 2f64.powi(30);
    // Powers of two and their neighbours are where the pieces meet.
    let bits = 22 + random.count(8.0).abs();
    let exact = (1_i128 << bits) + random.count(2.0);
    let any = random.word().abs();
    for n in [exact, any] {
        let within = |low: i128, high: i128| n.clamp(low, high);
        let m = within(1 << 28, (1 << 30) - 1);
        let wanted = one / (m as f64 / 2f64.powi(28)).sqrt();
        near(
            "inverse_root_q30",
            m,
            f.call("inverse_root_q30", &[m])?[0],
            wanted,
            8.5,
        )?;
        let m = within(1 << 26, (1 << 30) - 1);
        let wanted = one / (m as f64 / 2f64.powi(26)).sqrt();
        near(
            "inverse_length",
            n,
            f.call("inverse_length", &[n])?[0],
            wanted,
            8.5,
        )?;
        let m = within(1 << 22, (1 << 30) - 1);
        let wanted = one * (m as f64 / one).sqrt();
        near(
            "square_root_q30",
            n,
            f.call("square_root_q30", &[n])?[0],
            wanted,
            16.5,
        )?;
        let m = within(1 << 29, 1 << 30);
        let wanted = 2f64.powi(59) / m as f64;
        near(
            "reciprocal_q29",
            m,
            f.call("reciprocal_q29", &[m])?[0],
            wanted,
            24.5,
        )?;
    }
    let shift = random.next() % 28;
    let [y, x] = [0; 2].map(|_| random.count(one) >> shift);
    let wanted = (y as f64).atan2(x as f64) * 2f64.powi(28);
    near(
        "arc_tangent2",
        y,
        f.call("arc_tangent2", &[y, x])?[0],
        wanted,
        4.5e-7 * 2f64.powi(28),
    )
}

/// A sensor with any bias and cross-axis terms, not only the bench's.
fn calibration(f: &Functions, random: &mut Random) -> Result<(), String> {
    let raw = [0; 3].map(|_| random.count(32_767.0));
    let bias = [0; 3].map(|_| random.count(2f64.powi(28)));
    let matrix = [[0; 3]; 3].map(|row| row.map(|_: i32| random.count(2f64.powi(29))));
    let mut arguments = raw.to_vec();
    arguments.extend(bias);
    arguments.extend(matrix.iter().flatten());
    // The rounding of the three products: no further bits here.
    arguments.extend([0, 1]);
    let found = f.call("calibrate", &arguments)?;
    for (row, value) in matrix.iter().zip(&found) {
        let exact: i128 = (0..3).map(|i| row[i] * (raw[i] * 32_768 - bias[i])).sum();
        let wanted = exact as f64 / 2f64.powi(32);
        near("calibrate", raw[0], *value, wanted, 2.01)?;
    }
    Ok(())
}

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
    let mut random = Random::new(seed);
    for case in 0..cases {
        let q = unit([0; 4].map(|_| random.real()));
        let mut attitude: Vec<i128> = q
            .iter()
            .map(|x| (x * 2f64.powi(30)).round() as i128)
            .collect();
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
