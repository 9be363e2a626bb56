//! Claim `step-total` in random runs where an encoder shows the body: the duty is that of the law at the angle and the rate
//! that the counts show, computed here in floating point from the certificate.

use std::f64::consts::TAU;

use crate::certificate::hardware::CertifiedBodyEncoder;
use crate::certificate::reader::{Certificate, StatedDecimal};
use crate::claims::functions::Functions;
use crate::claims::random::Random;
use crate::claims::step_total::runs::{DriveNumbers, Wheel, wheel_speeds};
use crate::claims::supervisor::body::BodySupervisor;
use crate::claims::supervisor::second::{READY, RUNNING};
use crate::domains::machine::Machine;
use crate::language::module::Module;

/// Runs `Controller::step` on a body that sways.
///
/// # Errors
/// The first sample whose duty is not that of the law.
pub(super) fn step(
    module: &Module,
    certificate: &Certificate,
    encoder: &CertifiedBodyEncoder,
    cases: usize,
    seed: u64,
) -> Result<usize, String> {
    let f = Functions(module);
    let number = |stated: &StatedDecimal| -> Result<f64, String> {
        let found = stated.text.parse();
        found.map_err(|_| format!("`{stated}` is no number"))
    };
    let status = BodySupervisor::read(module)?.status();
    let drive = DriveNumbers::of(certificate)?;
    let mut wheel = Wheel::of(certificate, module)?;
    let speed = module.function("wheel_speed");
    let mut speed = Machine::new(speed.ok_or("there is no function wheel_speed")?);
    let line = module.constant_words("constants", "WHEEL_SPEED_LINE");
    let line = line.ok_or("src/constants.rs has no WHEEL_SPEED_LINE")?;
    wheel_speeds(&mut speed, &line, &certificate.hardware.wheel_speed)?;
    let step = module.function("Controller::step");
    let mut step = Machine::new(step.ok_or("there is no Controller::step")?);
    let unit = |index: usize| 2f64.powi(certificate.inputs[index].fraction_bits as i32);
    let ranges = [0, 1].map(|index| number(&certificate.inputs[index].range));
    let [angle_range, rate_range] = ranges;
    let (angle_range, rate_range) = (angle_range?, rate_range?);
    let current_unit = 2f64.powi(-(certificate.output.fraction_bits as i32));
    let per_count = TAU / number(&encoder.counts_per_turn)?;
    let period = number(&certificate.sample_time_s)?;
    let wrap = 1_i128 << encoder.bits;
    let window = encoder.window as usize;

    let mut random = Random::new(seed);
    let mut state = f.call("Controller::new", &[])?;
    let (mut place, mut rate) = (0.0, 0.0);
    // Counts from upright since the start, the youngest last; before the start it has not turned.
    let mut places: Vec<f64> = Vec::new();
    for case in 0..cases {
        let is_armed = case % 4 != 0;
        state[status] = if is_armed { RUNNING } else { READY };
        rate = 0.98 * rate + 0.1 * random.real();
        place = 0.999 * place + rate;
        let counts = f64::round(place);
        places.push(counts);
        let body = (i128::from(encoder.zero) + counts as i128).rem_euclid(wrap);
        let (reading, turned) = wheel.next(&mut random);
        let arguments = [&state[..], &[body, reading]].concat();
        let result = step
            .call(&arguments)
            .map_err(|trap| trap.to_string())?
            .to_vec();
        state = result[1..].to_vec();
        let before = places[places.len().saturating_sub(window + 1)];
        let angle = (counts * per_count).clamp(-angle_range, angle_range);
        let rate_s = (counts - before) * per_count / (window as f64 * period);
        let rate_s = rate_s.clamp(-rate_range, rate_range);
        let found = f.call("wheel_speed", &[turned])?[0];
        let words = [(angle * unit(0)), (rate_s * unit(1))].map(|word| word.round() as i128);
        let command = f.call("control", &[words[0], words[1], found])?[0];
        let wanted = if state[status] == RUNNING {
            drive.duty(command as f64 * current_unit, found as f64 / unit(2))
        } else {
            drive.zero
        };
        if (result[0] as f64 - wanted).abs() > 0.51 + DUTY_ROUNDING {
            return Err(format!(
                "Controller::step: duty {}, not {wanted}, for counts {counts} from upright, {before} before",
                result[0]
            ));
        }
    }
    Ok(cases)
}

/// What a unit of the words of angle and rate, which floating point may round the other way, does to the duty, counts.
const DUTY_ROUNDING: f64 = 0.01;
