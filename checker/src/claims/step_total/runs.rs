//! Claim `step-total` in random runs: the duty is that of the law at the filter's own angle, and the
//! bias observer computes its equations.

use crate::certificate::reader::Certificate;
use crate::claims::random::Random;
use crate::claims::supervisor::second::{ALIGNED, READY, RUNNING, STATUS};
use crate::domains::machine::Machine;
use crate::language::module::Module;
use crate::program::steps::Program;

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
    let has_observer = module
        .constant("constants", "BIAS_OBSERVER")
        .is_some_and(|words| words.iter().take(9).any(|word| *word != 0));
    let wheel = module
        .constant_words("constants", "WHEEL_SPEED_LINE")
        .ok_or("src/constants.rs has no WHEEL_SPEED_LINE")?;
    let per_count: f64 = certificate
        .drive
        .amperes_per_count
        .text
        .parse()
        .map_err(|_| "the drive's amperes_per_count is no number")?;
    let current_unit = 2f64.powi(-(certificate.output.fraction_bits as i32));

    wheel_speeds(&mut speed, &wheel)?;
    let mut state = Machine::new(get("Controller::new")?)
        .call(&[])
        .map_err(trapped)?
        .to_vec();
    let mut random = Random::new(seed);
    for case in 0..cases {
        let is_armed = case % 4 != 0;
        state[STATUS] = if is_armed { RUNNING } else { READY };
        state[ALIGNED] = 1;
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
        let adc = random.count(4095.0).abs();
        arguments.push(adc);
        let result = machine.call(&arguments).map_err(trapped)?.to_vec();
        state = result[1..=own].to_vec();
        let is_armed = state[STATUS] == RUNNING;

        let found_speed = speed.call(&[adc]).map_err(trapped)?[0];
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
        let wanted = f64::from(certificate.drive.duty_zero) + current / per_count;
        if (result[0] as f64 - wanted).abs() > 0.501 {
            return Err(format!(
                "Controller::step: duty {} for a current of {current} A, not {wanted}",
                result[0]
            ));
        }
    }
    Ok(cases)
}

/// Every count of the converter gives the word of its line, rounded down once and clamped.
fn wheel_speeds(speed: &mut Machine, wheel: &[(String, i128)]) -> Result<(), String> {
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
    for counts in 0..=i128::from(u16::MAX) {
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
