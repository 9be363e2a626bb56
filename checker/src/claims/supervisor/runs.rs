//! Claim `supervisor` in random runs: sequences of samples with faults are compared word by word with the
//! second implementation, and each condition alone must end the current within its number of steps.

use crate::claims::encoder_exact::second::EncoderWords;
use crate::claims::functions::{Functions, same};
use crate::claims::random::Random;
use crate::claims::supervisor::second::{RUNNING, Sample, Supervisor, TRIPPED_FAULT};
use crate::language::module::Module;

/// What a run of samples is like for a while.
#[derive(Clone, Copy)]
struct Phase {
    lean: f64,
    /// Out of the plane of motion, as a share of gravity: an axis that always read zero would hide what its
    /// words are compared with.
    side: f64,
    frozen: bool,
    /// One of the six axes of gyroscope and accelerometer stands at an end of its range.
    clipped: Option<(usize, i128)>,
    wheel_stuck: bool,
    falls: bool,
    quiet: bool,
}

/// Runs `cases` samples.
///
/// # Errors
/// The first sample for which source and second statement differ, or after which a current flows
/// where none may.
pub(super) fn run(module: &Module, cases: usize, seed: u64) -> Result<usize, String> {
    let f = Functions(module);
    let second = Supervisor::read(module)?;
    let rest = AtRest::read(&f)?;
    let zero = f.constant("constants", "ZERO_CURRENT")?[0];
    let (low, high) = (second.limit("wheel_low")?, second.limit("wheel_high")?);
    let window = second.limit("window")?;
    let mut random = Random::new(seed);
    let layout = second.layout;
    let (status, aligned) = (layout.status(), layout.aligned());
    let mut words = f.call_for_words("Controller::new", &[], layout.words())?;
    let mut wheel = WheelReadings::of(module, low, high)?;
    same(
        "Controller::default",
        &[],
        &f.call("Controller::default", &[])?,
        &words,
    )?;
    let mut done = 0;
    let mut armed = 0;
    let mut gyro = [0; 3];
    while done < cases {
        let roll = random.choice(8);
        let phase = Phase {
            lean: if roll == 0 {
                random.real() * 3.0
            } else {
                random.real() * 0.1
            },
            side: random.real() * 0.12,
            frozen: roll == 1,
            clipped: (roll == 2).then(|| {
                let axis = random.choice(6) as usize;
                (axis, [-32_768, 32_767][random.choice(2) as usize])
            }),
            wheel_stuck: roll == 3,
            falls: roll == 4,
            quiet: roll >= 5 || random.choice(2) == 0,
        };
        // Long enough for a window or a count to fill, now and then.
        let most = if random.choice(6) == 0 {
            2 * window as u64 + 40
        } else {
            40
        };
        let length = 1 + random.choice(most) as usize;
        for _ in 0..length.min(cases - done) {
            let sample = drawn(&mut random, phase, &rest, &mut gyro, &mut wheel);
            let current = (random.choice(16) == 0).then(|| random.word());
            let (duty, wanted) = second.step(&words, &sample, current)?;
            let mut arguments = [&words[..], &sample.words()].concat();
            let name = match current {
                Some(current) => {
                    arguments.push(current);
                    "Controller::step_with_current"
                }
                None => "Controller::step",
            };
            let found = f.call(name, &arguments)?;
            same(name, &arguments, &found, &[&[duty], &wanted[..]].concat())?;
            if wanted[status] != RUNNING && duty != zero {
                return Err(format!("{name}: duty {duty} while it does not run"));
            }
            words = wanted;
            done += 1;
        }
        same(
            "Controller::status",
            &words,
            &f.call("Controller::status", &words)?,
            &words[status..=status],
        )?;
        let (may, next) = second.armed(&words)?;
        let found = f.call("Controller::arm", &words)?;
        same(
            "arm",
            &words,
            &found,
            &[&[i128::from(may)], &next[..]].concat(),
        )?;
        armed += usize::from(may);
        if random.choice(4) == 0 {
            let mut wanted = words.clone();
            if wanted[status] == RUNNING {
                wanted[status] = 1;
            }
            same(
                "disarm",
                &words,
                &f.call("Controller::disarm", &words)?,
                &wanted,
            )?;
            let wanted = second.tripped(&words, TRIPPED_FAULT);
            same(
                "fault",
                &words,
                &f.call("Controller::fault", &words)?,
                &wanted,
            )?;
        }
        words = match random.choice(12) {
            0 => second.tripped(&words, TRIPPED_FAULT),
            _ if may => next,
            // The attitude as if a window had filled: windows of random runs rarely do.
            1..=6 => {
                let mut aligned_words = words.clone();
                aligned_words[aligned] = 1;
                aligned_words
            }
            _ => words,
        };
    }
    if cases >= 5000 && armed == 0 {
        return Err("in none of the runs the controller was armed".to_owned());
    }
    each_condition(&f, &second, &rest, zero)?;
    Ok(done)
}

/// What the sensors of this bench read at rest.
struct AtRest {
    /// Counts of the gyroscope.
    gyro: [f64; 3],
    /// Counts of the accelerometer without gravity.
    accel: [f64; 3],
    /// Counts of gravity along the sensor's x, its y and its z: three counts each.
    gravity: [[f64; 3]; 3],
    /// Angle of the body's axis in the sensor's frame, rad.
    mounting_rad: f64,
}

impl AtRest {
    /// By the calibration's own words, which the runs must not leave aside: a sensor with a bias, askew or turned is
    /// as good as any other.
    fn read(f: &Functions) -> Result<AtRest, String> {
        let filter = f.constant("constants", "FILTER")?;
        if filter.len() <= ACCEL_SHIFT {
            let count = filter.len();
            return Err(format!(
                "FILTER has {count} words, not at least {}",
                ACCEL_SHIFT + 1
            ));
        }
        let limits = f.0.constant_words("constants", "LIMITS");
        let limits = limits.ok_or("src/constants.rs has no LIMITS")?;
        let low = limits
            .iter()
            .find(|(name, _)| name.ends_with("gravity_low"))
            .ok_or("LIMITS has no gravity_low")?;
        // The shortest reading that may be gravity is 0.85 of it.
        let gravity = (low.1 as f64 * 2f64.powi(32)).sqrt() / 0.85;
        let bias = |line: usize| [0, 1, 2].map(|axis| filter[line + axis] as f64 / 32_768.0);
        let (gyro, accel) = (bias(0), bias(ACCEL));
        let unit = 2f64.powi(17 + filter[ACCEL_SHIFT] as i32);
        let matrix = [0, 1, 2]
            .map(|row| [0, 1, 2].map(|column| filter[ACCEL + 3 + 3 * row + column] as f64 / unit));
        let along = |axis: usize| {
            let mut reading = [0.0; 3];
            reading[axis] = gravity;
            solved(matrix, reading).ok_or("the accelerometer's matrix has no inverse")
        };
        let mounting = f.constant("constants", "MOUNTING_ANGLE")?[0];
        Ok(AtRest {
            gyro,
            accel,
            gravity: [along(0)?, along(1)?, along(2)?],
            mounting_rad: mounting as f64 / 2f64.powi(28),
        })
    }

    /// Counts of the accelerometer with the body leaning by `lean_rad` from upright, and with `side` of gravity
    /// along the pivot axis.
    fn accel_at(&self, lean_rad: f64, side: f64) -> [f64; 3] {
        let (sin, cos) = (lean_rad + self.mounting_rad).sin_cos();
        let [x, y, z] = &self.gravity;
        [0, 1, 2].map(|axis| self.accel[axis] + cos * x[axis] - sin * y[axis] + side * z[axis])
    }
}

/// Where the accelerometer's line begins among the words of FILTER: bias, three rows, shift, half a unit each.
const ACCEL: usize = 14;
/// The shift of that line.
const ACCEL_SHIFT: usize = ACCEL + 12;

/// x with m x = y, by Cramer's rule.
fn solved(m: [[f64; 3]; 3], y: [f64; 3]) -> Option<[f64; 3]> {
    let determinant = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(&m);
    let part = |column: usize| {
        let mut replaced = m;
        for row in 0..3 {
            replaced[row][column] = y[row];
        }
        determinant(&replaced) / whole
    };
    let x = [part(0), part(1), part(2)];
    x.iter().all(|value| value.is_finite()).then_some(x)
}

fn drawn(
    random: &mut Random,
    phase: Phase,
    rest: &AtRest,
    gyro: &mut [i128; 3],
    wheel: &mut WheelReadings,
) -> Sample {
    if !phase.frozen {
        let most = if phase.quiet { 40.0 } else { 2_000.0 };
        *gyro = rest.gyro.map(|zero| zero as i128 + random.count(most));
    }
    let reading = rest.accel_at(phase.lean, phase.side);
    let noise = if phase.quiet { 10.0 } else { 900.0 };
    let accel = if phase.falls {
        [0; 3].map(|_| random.count(20.0))
    } else {
        reading.map(|value| (value as i128 + random.count(noise)).clamp(-32_768, 32_767))
    };
    let (gyro, accel) = match phase.clipped {
        Some((axis, end)) => clipped(*gyro, accel, axis, end),
        None => (*gyro, accel),
    };
    Sample {
        gyro,
        accel,
        mag: (random.choice(5) == 0).then(|| [0; 3].map(|_| random.count(500.0))),
        wheel: wheel.next(random, phase.wheel_stuck),
    }
}

/// What the wheel's sensor says in random runs.
pub(crate) struct WheelReadings {
    low: i128,
    high: i128,
    /// Of an encoder: its words, its count, and how far it turns in a step.
    encoder: Option<(EncoderWords, i128, i128)>,
}

impl WheelReadings {
    pub(crate) fn of(module: &Module, low: i128, high: i128) -> Result<WheelReadings, String> {
        let encoder = EncoderWords::read(module, "WHEEL_ENCODER")?;
        Ok(WheelReadings {
            low,
            high,
            encoder: encoder.map(|words| (words, 0, 0)),
        })
    }

    /// The next reading: any that the sensor may give; one of those at its ends where it is `stuck`.
    pub(crate) fn next(&mut self, random: &mut Random, stuck: bool) -> i128 {
        let (low, high) = (self.low, self.high);
        let Some((words, count, turn)) = &mut self.encoder else {
            return if stuck {
                if random.choice(2) == 0 { low } else { high }
            } else {
                low + 1 + random.choice((high - low - 1).max(1) as u64) as i128
            };
        };
        // A wheel that runs up and down, at its largest speed where it is stuck, and now and then a count that is no
        // motion.
        let most = high / words.window + 1;
        let towards = if stuck {
            most
        } else {
            random.count(most as f64)
        };
        *turn += (towards - *turn).clamp(-words.jump / 2, words.jump / 2);
        let jump = if random.choice(400) == 0 {
            words.wrap / 3
        } else {
            0
        };
        *count = (*count + *turn + jump).rem_euclid(words.wrap);
        *count
    }
}

/// The readings of gyroscope and accelerometer with one of their six axes at `end`.
fn clipped(
    mut gyro: [i128; 3],
    mut accel: [i128; 3],
    axis: usize,
    end: i128,
) -> ([i128; 3], [i128; 3]) {
    if axis < 3 {
        gyro[axis] = end;
    } else {
        accel[axis - 3] = end;
    }
    (gyro, accel)
}

/// Each condition alone, from a controller that runs upright: no current after its steps.
fn each_condition(
    f: &Functions,
    second: &Supervisor,
    rest: &AtRest,
    zero: i128,
) -> Result<(), String> {
    let layout = second.layout;
    let status = layout.status();
    let middle = (second.limit("wheel_low")? + second.limit("wheel_high")?) / 2;
    let upright = |turn: i128| Sample {
        gyro: [
            rest.gyro[0] as i128 + turn % 7 - 3,
            rest.gyro[1] as i128 + turn % 5 - 2,
            rest.gyro[2] as i128 + turn % 3 - 1,
        ],
        accel: rest.accel_at(0.0, 0.0).map(|value| value as i128),
        mag: None,
        wheel: middle,
    };
    // The attitude by one reading stands for the window that sets it.
    let mut start = f.call_for_words("Controller::new", &[], layout.words())?;
    let attitude = f.call_for_words(
        "Attitude::align",
        &[&start[..layout.attitude], &upright(0).accel].concat(),
        1 + layout.attitude,
    )?;
    start[..layout.attitude].copy_from_slice(&attitude[1..]);
    start[layout.aligned()] = 1;
    start[status] = RUNNING;
    // With the lower end of the wheel's range, and the axis of a clipped reading.
    type Fault = fn(Sample, i128, usize) -> Sample;
    let clips: Fault = |sample, _, axis| {
        let (gyro, accel) = clipped(sample.gyro, sample.accel, axis, 32_767);
        Sample {
            gyro,
            accel,
            ..sample
        }
    };
    // By the index of their counts.
    let mut conditions: Vec<(usize, &str, usize, Fault)> = vec![
        (0, "wheel_steps", 0, |sample, low, _| Sample {
            wheel: low,
            ..sample
        }),
        (2, "frozen_steps", 0, |sample, _, _| Sample {
            gyro: [5, 5, 5],
            ..sample
        }),
        (3, "rejected_steps", 0, |sample, _, _| Sample {
            accel: [0; 3],
            ..sample
        }),
    ];
    conditions.extend((0..6).map(|axis| (1, "clipped_steps", axis, clips)));
    for (index, limit, axis, fault) in conditions {
        let steps = second.limit(limit)?;
        let low = second.limit("wheel_low")?;
        let turn = second
            .wheel_encoder()
            .map(|encoder| (encoder.wrap, -low / encoder.window + 1));
        // The condition has lasted for all but the last of its steps; that each counts by one, the
        // runs above show.
        let mut words = start.clone();
        words[layout.counts() + index] = (steps - 3).max(0);
        words[layout.gyro()..layout.gyro() + 3].fill(5);
        if let (Some(encoder), "wheel_steps") = (second.wheel_encoder(), limit) {
            // It turns at the end of its range, and goes on to.
            let turn = -low / encoder.window + 1;
            words[layout.attitude..status].copy_from_slice(&encoder.turning(turn));
        }
        let mut has_ended = false;
        for step in 0..3 {
            let mut sample = fault(upright(step), low, axis);
            match turn {
                Some((wrap, turn)) if limit == "wheel_steps" => {
                    sample.wheel = ((step + 1) * turn).rem_euclid(wrap);
                }
                Some(_) => sample.wheel = 0,
                None => {}
            }
            let arguments = [&words[..], &sample.words()].concat();
            let count = 1 + layout.words();
            let found = f.call_for_words("Controller::step", &arguments, count)?;
            words.copy_from_slice(&found[1..]);
            if words[status] != RUNNING {
                if found[0] != zero {
                    return Err(format!("{limit}: duty {} after a trip", found[0]));
                }
                has_ended = true;
                break;
            }
        }
        if !has_ended {
            return Err(format!(
                "{limit}: the condition lasts, and the controller runs on"
            ));
        }
    }
    Ok(())
}
