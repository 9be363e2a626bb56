//! Claim `step-total` in random runs: the duty is that of the law at the filter's own angle, and the
//! bias observer computes its equations.

use std::ops::RangeInclusive;

use crate::certificate::hardware::CertifiedWheelSpeed;
use crate::certificate::reader::{Certificate, StatedDecimal};
use crate::claims::encoder_exact::second::{EncoderWords, WORDS};
use crate::claims::random::Random;
use crate::claims::supervisor::second::{Layout, READY, RUNNING};
use crate::domains::machine::Machine;
use crate::language::module::Module;
use crate::program::steps::Program;

/// Runs `Controller::step` on random samples: the duty is that of the law at the filter's own
/// angle, rate and speed.
///
/// # Errors
/// The first sample for which it is not.
pub(super) fn step(
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
    let has_observer = module
        .constant("constants", "BIAS_OBSERVER")
        .is_some_and(|words| words.iter().take(9).any(|word| *word != 0));
    let layout = Layout::of(module)?;
    let line = module
        .constant_words("constants", "WHEEL_SPEED_LINE")
        .ok_or("src/constants.rs has no WHEEL_SPEED_LINE")?;
    let drive = DriveNumbers::of(certificate)?;
    let current_unit = 2f64.powi(-(certificate.output.fraction_bits as i32));
    let speed_unit = 2f64.powi(-(certificate.inputs[2].fraction_bits as i32));
    let mut wheel = Wheel::of(certificate, module)?;

    wheel_speeds(&mut speed, &line, &certificate.hardware.wheel_speed)?;
    let mut state = Machine::new(get("Controller::new")?)
        .call(&[])
        .map_err(trapped)?
        .to_vec();
    let mut random = Random::new(seed);
    for case in 0..cases {
        let is_armed = case % 4 != 0;
        state[layout.status()] = if is_armed { RUNNING } else { READY };
        state[layout.aligned()] = 1;
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
        let (reading, counts) = wheel.next(&mut random);
        arguments.push(reading);
        let result = machine.call(&arguments).map_err(trapped)?.to_vec();
        state = result[1..=own].to_vec();
        let is_armed = state[layout.status()] == RUNNING;

        let found_speed = speed.call(&[counts]).map_err(trapped)?[0];
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
        let wanted = if is_armed {
            let current = command as f64 * current_unit;
            drive.duty(current, found_speed as f64 * speed_unit)
        } else {
            drive.zero
        };
        if (result[0] as f64 - wanted).abs() > 0.51 {
            return Err(format!(
                "Controller::step: duty {}, not {wanted}, for a command of {command}",
                result[0]
            ));
        }
    }
    Ok(cases)
}

/// The drive in floating point.
pub(super) struct DriveNumbers {
    pub(super) zero: f64,
    ends: [f64; 2],
    per_count: f64,
    /// Winding resistance and back-EMF of a voltage drive.
    voltage: Option<[f64; 2]>,
}

impl DriveNumbers {
    pub(super) fn of(certificate: &Certificate) -> Result<DriveNumbers, String> {
        let number = |stated: &StatedDecimal| -> Result<f64, String> {
            let number = stated.text.parse();
            number.map_err(|_| format!("`{stated}` of the drive is no number"))
        };
        let drive = &certificate.drive;
        let (per_count, voltage) = match &drive.voltage {
            None => (number(&drive.amperes_per_count)?, None),
            Some(voltage) => {
                let numbers = [
                    number(&voltage.winding_ohm)?,
                    number(&voltage.back_emf_v_s)?,
                ];
                (number(&voltage.volts_per_count)?, Some(numbers))
            }
        };
        Ok(DriveNumbers {
            zero: drive.duty_zero.into(),
            ends: [drive.duty_low.into(), drive.duty_high.into()],
            per_count,
            voltage,
        })
    }

    /// The duty for a current (A) at a wheel speed (rad/s), according to the law of the drive.
    pub(super) fn duty(&self, current: f64, speed: f64) -> f64 {
        let asked = match self.voltage {
            None => current,
            Some([winding, back_emf]) => winding * current + back_emf * speed,
        };
        (self.zero + asked / self.per_count).clamp(self.ends[0], self.ends[1])
    }
}

/// The wheel's sensor in random runs.
pub(super) struct Wheel {
    /// Largest magnitude of a reading.
    most: f64,
    has_sign: bool,
    /// For an encoder: its words, and its state according to the second statement.
    encoder: Option<(EncoderWords, Vec<i128>)>,
    count: i128,
}

impl Wheel {
    pub(super) fn of(certificate: &Certificate, module: &Module) -> Result<Wheel, String> {
        let stated = &certificate.hardware.wheel_speed;
        let words = EncoderWords::read(module, "WHEEL_ENCODER")?;
        Ok(Wheel {
            most: match stated.kind.as_str() {
                "converter" => 4095.0,
                _ => f64::from(stated.high_counts),
            },
            has_sign: stated.kind == "driver",
            encoder: words.map(|words| (words, vec![0; WORDS])),
            count: 0,
        })
    }

    /// What the sensor says, and the counts that stand for the speed.
    pub(super) fn next(&mut self, random: &mut Random) -> (i128, i128) {
        let Some((words, state)) = &mut self.encoder else {
            let reading = random.count(self.most);
            let reading = if self.has_sign {
                reading
            } else {
                reading.abs()
            };
            return (reading, reading);
        };
        let turn = random.count(words.jump as f64 / 2.0);
        self.count = (self.count + turn).rem_euclid(words.wrap);
        (*state, _) = words.update(state, self.count);
        (self.count, words.turned(state))
    }
}

/// Every count of the wheel's sensor gives the word of its line, rounded down once and clamped.
pub(super) fn wheel_speeds(
    speed: &mut Machine,
    wheel: &[(String, i128)],
    sensor: &CertifiedWheelSpeed,
) -> Result<(), String> {
    let word = |end: &str| {
        let found = wheel.iter().find(|(name, _)| name.ends_with(end));
        found
            .map(|(_, word)| *word)
            .ok_or_else(|| format!("WHEEL_SPEED_LINE has no {end}"))
    };
    let (scale, offset, shift) = (word(".scale")?, word(".offset")?, word(".shift")?);
    let (low, high) = (word(".low")?, word(".high")?);
    if !(0..63).contains(&shift) || low > high {
        return Err("WHEEL_SPEED_LINE is no line".to_owned());
    }
    let counts: RangeInclusive<i128> = match sensor.kind.as_str() {
        "converter" => 0..=i128::from(u16::MAX),
        "driver" => i128::from(i16::MIN)..=i128::from(i16::MAX),
        _ => 2 * i128::from(sensor.low_counts)..=2 * i128::from(sensor.high_counts),
    };
    for counts in counts {
        let wanted = ((scale * counts + offset) >> shift).clamp(low, high);
        let found = speed.call(&[counts]).map_err(|trap| trap.to_string())?[0];
        if found != wanted {
            return Err(format!(
                "wheel_speed of {counts} counts is {found}, not {wanted}"
            ));
        }
    }
    Ok(())
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
