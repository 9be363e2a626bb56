//! The words of `src/constants.rs`, checked against the real numbers of the certificate. Those of the observer
//! of the angle's bias are in [`crate::claims::bias_observer_words`].
//!
//! The meaning of each word is derived here from the formats in the documentation of the emitted fields:
//! half-angles per step in Q32; matrices in Q17, with those of accelerometer and magnetometer
//! scaled so that the largest row sum is 2³⁰; biases in 2⁻¹⁵ counts; lines as slope and offset
//! divided by a common power of two.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::certificate::hardware::{
    CertifiedBody, CertifiedBodyEncoder, CertifiedInertial, CertifiedSensor, CertifiedWheelSpeed,
};
use crate::certificate::reader::{Certificate, CertifiedLoop, CertifiedVoltage};
use crate::claims::bias_observer_words::check_words;
use crate::claims::control_law::EmittedLaw;
use crate::claims::drift_words;
use crate::claims::named_words::{NamedWords, nearest};
use crate::exact::rational::{decimal, exponent, half, integer, power_of_two, rounded_up};
use crate::language::module::Module;

type Check = Result<(), String>;

/// Strongest field of the Earth, µT: with a higher floor the compass would never be used.
const FIELD_MAX_UT: i128 = 67;

/// Smallest power of two of the duty's plane. With it, half a unit of a slope is 2⁻⁸ counts for the largest word.
const PLANE_SHIFT_MIN: i32 = 38;

/// Smallest power of two of a line's slope. With it, the relative error of the slope is 2⁻²⁴: a hundredth of a count
/// over a duty of 16 bits.
const SLOPE_BITS_MIN: i32 = 23;

/// Checks all words.
///
/// # Errors
/// A sentence that names the word.
pub fn check(certificate: &Certificate, module: &Module, law: &EmittedLaw) -> Check {
    let hardware = &certificate.hardware;
    let period = &certificate.sample_time_s.value;
    let limits = NamedWords::read(module, "LIMITS")?;
    let wheel = &hardware.wheel_speed;
    exactly(&limits, "LIMITS.wheel_low", wheel.low_counts.into())?;
    exactly(&limits, "LIMITS.wheel_high", wheel.high_counts.into())?;
    wheel_sensor(module, wheel, period)?;
    match &hardware.body {
        CertifiedBody::Inertial(inertial) => {
            check_inertial(certificate, module, law, inertial, &limits)?;
        }
        CertifiedBody::Encoder(encoder) => check_encoder(certificate, module, law, encoder)?,
    }

    let wheel_unit = power_of_two(exponent(law.state_bits[2]));
    let range = &certificate.inputs[2].range.value;
    let end = (range * &wheel_unit).floor().min(integer(i32::MAX.into()));
    line(
        module,
        "WHEEL_SPEED_LINE",
        &(&wheel.rad_s_per_count.value * &wheel_unit),
        &(&wheel.rad_s_at_zero.value * &wheel_unit),
        &-&end,
        &end,
    )?;
    drive(certificate, module, law)
}

/// Checks the words between the encoder on the pivot and the body's angle and rate.
fn check_encoder(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    encoder: &CertifiedBodyEncoder,
) -> Check {
    takes(module, "sample.body_count", "an encoder on the pivot")?;
    let sizes = (4..=16).contains(&encoder.bits) && (1..=16).contains(&encoder.window);
    let per_turn = &encoder.counts_per_turn.value;
    // If the count began again after less than a turn, one count would stand for several angles.
    if !sizes || per_turn.is_zero() || per_turn.abs() > integer(1 << encoder.bits) {
        return Err("the encoder on the pivot shows no angle like that".to_owned());
    }
    let zero = NamedWords::read(module, "BODY_ZERO")?;
    exactly(&zero, "BODY_ZERO", encoder.zero.into())?;
    if encoder.zero >= 1 << encoder.bits {
        return Err(format!("BODY_ZERO is {}, which is no count", encoder.zero));
    }
    let per_count = full_turn()? / per_turn;
    let period = &certificate.sample_time_s.value;
    let per_count_s = &per_count / (integer(encoder.window.into()) * period);
    for (index, name, slope) in [
        (0, "BODY_ANGLE_LINE", per_count),
        (1, "BODY_RATE_LINE", per_count_s),
    ] {
        let unit = power_of_two(exponent(law.state_bits[index]));
        let range = &certificate.inputs[index].range.value;
        let end = (range * &unit).floor().min(integer(i32::MAX.into()));
        line(
            module,
            name,
            &(slope * unit),
            &BigRational::zero(),
            &-&end,
            &end,
        )?;
    }
    let plant = &certificate.plant;
    let push = plant.b[1].value.abs();
    if push.is_zero() {
        return Err("no current turns the body".to_owned());
    }
    let holding = &plant.a[1][0].value / push;
    let angle_unit = power_of_two(exponent(law.state_bits[0]));
    let largest = integer(i32::MAX.into());
    line(
        module,
        "HOLDING_LINE",
        &(holding / (law.unit() * angle_unit)),
        &BigRational::zero(),
        &-&largest,
        &largest,
    )
}

/// A step takes this word.
fn takes(module: &Module, field: &str, what: &str) -> Check {
    let step = module.function("Controller::step");
    if step.is_none_or(|step| step.inputs.iter().all(|name| name != field)) {
        return Err(format!(
            "a step takes no `{field}`, as one with {what} does"
        ));
    }
    Ok(())
}

fn check_inertial(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    hardware: &CertifiedInertial,
    limits: &NamedWords,
) -> Check {
    takes(module, "sample.gyro[0]", "a gyroscope")?;
    let period = &certificate.sample_time_s.value;
    let filter = NamedWords::read(module, "FILTER")?;
    let (beta, gravity) = (&hardware.beta_rad_s.value, &hardware.gravity_m_s2.value);
    for (what, stated) in [
        ("beta_rad_s", &hardware.beta_rad_s),
        ("gravity_m_s2", &hardware.gravity_m_s2),
        ("field_min_uT", &hardware.field_min_ut),
    ] {
        if !stated.value.is_positive() {
            return Err(format!("{what} is {stated}; it is more than zero"));
        }
    }
    if hardware.field_min_ut.value > integer(FIELD_MAX_UT) {
        return Err(format!(
            "field_min_uT is {}: no field on Earth would be used",
            hardware.field_min_ut
        ));
    }
    nearest(
        "FILTER.beta",
        &filter.get("FILTER.beta")?,
        &(beta * period * power_of_two(35)),
    )?;

    let sensors = [
        (limits, "LIMITS.gyro_clip", &hardware.gyroscope),
        (&filter, "FILTER.accel_clip", &hardware.accelerometer),
        (&filter, "FILTER.mag_clip", &hardware.magnetometer),
    ];
    for (words, name, stated) in sensors {
        for (axis, clip) in stated.clip_counts.iter().enumerate() {
            let name = format!("{name}[{axis}]");
            exactly(words, &name, (*clip).into())?;
            if *clip <= 0 {
                return Err(format!("{name} is {clip}: no count would be known"));
            }
        }
    }
    drift_words::check(&filter, hardware, period)?;

    let gyro_unit = period * half() * power_of_two(49);
    sensor(&filter, &hardware.gyroscope, "gyro", Some(&gyro_unit))?;
    let accel_unit = sensor(&filter, &hardware.accelerometer, "accel", None)?;
    let mag_unit = sensor(&filter, &hardware.magnetometer, "mag", None)?;

    // Units per m/s² and per uT, without the Q17 of the matrices; squares in units of 2³².
    let per_m_s2 = accel_unit * power_of_two(-17);
    let shortest = gravity * integer(1) / integer(8) * &per_m_s2;
    squared(&filter, "FILTER.gravity_squared_min", &shortest)?;
    squared(
        &filter,
        "FILTER.field_squared_min",
        &(&hardware.field_min_ut.value * mag_unit * power_of_two(-17)),
    )?;
    let square = period * period;
    let centripetal = integer(4) / &square * &per_m_s2 * power_of_two(-16);
    let tangential = integer(1) / &square * &per_m_s2 * power_of_two(-16);
    for (index, lever) in hardware.lever_arm_m.iter().enumerate() {
        let lever = &lever.value;
        let name = format!("FILTER.lever_arm.centripetal[{index}]");
        nearest(&name, &filter.get(&name)?, &(lever * &centripetal))?;
        let name = format!("FILTER.lever_arm.tangential[{index}]");
        nearest(&name, &filter.get(&name)?, &(lever * &tangential))?;
    }

    let angle_bits = exponent(law.state_bits[0]);
    let observer = NamedWords::read(module, "BIAS_OBSERVER")?;
    check_words(certificate, law, &observer)?;
    let mounting = &hardware.mounting_angle_rad.value;
    check_angle(module, mounting, angle_bits, &observer)?;

    let rate_unit = power_of_two(exponent(law.state_bits[1]));
    let slope = integer(2) / period * rate_unit * power_of_two(-32);
    let largest = integer(i32::MAX.into());
    line(
        module,
        "RATE_LINE",
        &slope,
        &BigRational::zero(),
        &-&largest,
        &largest,
    )?;

    if let Some(closed_loop) = &certificate.closed_loop {
        check_sensor_steps(hardware, &certificate.hardware.wheel_speed, closed_loop)?;
    }
    Ok(())
}

/// The range of the wheel's sensor is one of its kind, and an encoder's line that of its counts.
fn wheel_sensor(module: &Module, wheel: &CertifiedWheelSpeed, period: &BigRational) -> Check {
    let field = match wheel.kind.as_str() {
        "converter" => "sample.wheel_adc",
        "driver" => "sample.wheel_speed",
        _ => "sample.wheel_count",
    };
    takes(module, field, &format!("a {} of the wheel", wheel.kind))?;
    let (low, high) = (wheel.low_counts, wheel.high_counts);
    if low >= high {
        return Err("the range of the wheel's sensor is empty".to_owned());
    }
    let is_line = wheel.rad_s_at_zero.value.is_zero() && low == -high;
    let (is_possible, is_encoder) = match (wheel.kind.as_str(), &wheel.encoder) {
        ("converter", None) => (low >= 0 && high <= 0xffff, false),
        ("driver", None) => (is_line && high <= 0x7fff, false),
        ("encoder", Some(encoder)) => {
            let sizes = (4..=16).contains(&encoder.bits) && (1..=16).contains(&encoder.window);
            let most = || (((1_i32 << encoder.bits) >> 1) - 1) * encoder.window as i32;
            (is_line && sizes && high <= most(), true)
        }
        _ => (false, false),
    };
    if !is_possible {
        return Err(format!(
            "no {} of the wheel shows {low} to {high} counts like that",
            wheel.kind
        ));
    }
    if let (true, Some(encoder)) = (is_encoder, &wheel.encoder) {
        let steps = integer(encoder.window.into());
        let wanted = full_turn()? / (&encoder.counts_per_turn.value * steps * period);
        let off = (&wanted - &wheel.rad_s_per_count.value).abs();
        if off > wanted.abs() * crate::exact::rational::power(10, -14) {
            return Err(format!(
                "rad_s_per_count is {}, the encoder's counts over its window make it {}",
                wheel.rad_s_per_count,
                rounded_up(&wanted, 16)
            ));
        }
    }
    Ok(())
}

/// 2π to 40 digits.
pub(crate) fn full_turn() -> Result<BigRational, String> {
    let pi = decimal("3.141592653589793238462643383279502884197").ok_or("pi")?;
    Ok(pi * integer(2))
}

/// The words from the current to the duty.
fn drive(certificate: &Certificate, module: &Module, law: &EmittedLaw) -> Check {
    let drive = &certificate.drive;
    if let Some(voltage) = &drive.voltage {
        return plane(certificate, module, law, voltage);
    }
    if drive.amperes_per_count.value.is_zero() {
        return Err("the drive's amperes_per_count is zero".to_owned());
    }
    line(
        module,
        "DUTY_LINE",
        &(law.unit() / &drive.amperes_per_count.value),
        &integer(drive.duty_zero.into()),
        &integer(drive.duty_low.into()),
        &integer(drive.duty_high.into()),
    )
}

/// The plane of a voltage drive: slopes and offset have one power of two in common, the largest for which all three
/// fit.
fn plane(
    certificate: &Certificate,
    module: &Module,
    law: &EmittedLaw,
    voltage: &CertifiedVoltage,
) -> Check {
    let drive = &certificate.drive;
    let per_count = &voltage.volts_per_count.value;
    if per_count.is_zero() {
        return Err("the drive's volts_per_count is zero".to_owned());
    }
    let words = NamedWords::read(module, "DUTY_PLANE")?;
    let field = |field: &str| words.get(&format!("DUTY_PLANE.{field}"));
    let shift = words.small("DUTY_PLANE.shift")?;
    let scale = power_of_two(shift);
    let wheel_unit = power_of_two(-exponent(law.state_bits[2]));
    let of_current = &voltage.winding_ohm.value * law.unit() / per_count;
    let of_speed = &voltage.back_emf_v_s.value * wheel_unit / per_count;
    let largest = of_current.abs().max(of_speed.abs()) * &scale;
    let real = (integer(drive.duty_zero.into()) + half()) * &scale;
    let is_finest = largest >= power_of_two(29) || real.clone() * integer(2) > power_of_two(61);
    let fits = largest <= power_of_two(30) && real <= power_of_two(61);
    if !is_finest || !fits || !(PLANE_SHIFT_MIN..=62).contains(&shift) {
        return Err("DUTY_PLANE has not the bits that fit".to_owned());
    }
    for (name, slope) in [("current", &of_current), ("speed", &of_speed)] {
        let name = format!("DUTY_PLANE.{name}");
        nearest(&name, &words.get(&name)?, &(slope * &scale))?;
    }
    let ends = [("low", drive.duty_low), ("high", drive.duty_high)];
    // The offset is a whole number of counts plus 2^shift/2, which is a whole number itself.
    if field("offset")? != real {
        return Err("DUTY_PLANE.offset is not half a count above the duty at 0 V".to_owned());
    }
    for (end, stated) in ends {
        if field(end)? != integer(stated.into()) {
            return Err(format!("DUTY_PLANE.{end} is not {stated}"));
        }
    }
    Ok(())
}

/// The certificate of the closed loop must use the steps of the stated sensors.
fn check_sensor_steps(
    hardware: &CertifiedInertial,
    wheel: &CertifiedWheelSpeed,
    stated: &CertifiedLoop,
) -> Check {
    let found = [
        hardware.angle_step(),
        hardware.rate_step(),
        wheel.rad_s_per_count.value.abs(),
    ];
    for (index, found) in found.iter().enumerate() {
        let stated = &stated.sensor_steps[index];
        if (&stated.value - found).abs() > found * crate::exact::rational::power(10, -12) {
            return Err(format!(
                "sensor_steps[{index}] is stated as {stated}, the sensor's step is {}",
                rounded_up(found, 12)
            ));
        }
    }
    Ok(())
}

/// One sensor's bias and matrix; returns the factor from matrix to words.
fn sensor(
    words: &NamedWords,
    stated: &CertifiedSensor,
    name: &str,
    unit: Option<&BigRational>,
) -> Result<BigRational, String> {
    let matrix: Vec<&BigRational> = stated
        .matrix
        .iter()
        .flatten()
        .map(|entry| &entry.value)
        .collect();
    let unit = match unit {
        Some(unit) => unit.clone(),
        None => {
            let largest = matrix
                .chunks(3)
                .map(|row| row.iter().map(|entry| entry.abs()).sum())
                .max()
                .filter(|sum: &BigRational| sum.is_positive())
                .ok_or_else(|| format!("the matrix of `{name}` is zero"))?;
            power_of_two(30) / largest
        }
    };
    let shift = words.small(&format!("FILTER.{name}.shift"))?;
    // The tolerance is half a unit of the output, and one unit for the three products, which are rounded down.
    let half_unit = words.get(&format!("FILTER.{name}.half_unit"))?;
    if half_unit != (power_of_two(shift) * half()).floor() + integer(1) {
        return Err(format!("FILTER.{name}.half_unit is {half_unit}"));
    }
    for (index, counts) in stated.bias_counts.iter().enumerate() {
        let word = format!("FILTER.{name}.bias[{index}]");
        let real = &counts.value * power_of_two(15);
        nearest(&word, &words.get(&word)?, &real)?;
    }
    for (row, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for column in 0..3 {
            let word = format!("FILTER.{name}.{letter}[{column}]");
            let real = matrix[3 * row + column] * &unit * power_of_two(shift);
            nearest(&word, &words.get(&word)?, &real)?;
        }
    }
    Ok(unit)
}

/// A word that is an integer of the certificate.
fn exactly(words: &NamedWords, name: &str, stated: i128) -> Check {
    let word = words.get(name)?;
    if word == integer(stated) {
        Ok(())
    } else {
        Err(format!("{name} is {word}, the certificate says {stated}"))
    }
}

fn squared(words: &NamedWords, name: &str, length: &BigRational) -> Check {
    let real = length * length * power_of_two(-32);
    nearest(name, &words.get(name)?, &real.max(BigRational::one()))
}

fn check_angle(
    module: &Module,
    mounting: &BigRational,
    angle_bits: i32,
    observer: &NamedWords,
) -> Check {
    let single = |name: &str| NamedWords::read(module, name)?.get(name);
    let exact = |name: &str, wanted: &BigRational| {
        let found = single(name)?;
        if found == *wanted {
            Ok(())
        } else {
            Err(format!("{name} is {found}, its formats make it {wanted}"))
        }
    };
    let up = (angle_bits - 28).max(0);
    exact("ANGLE_FACTOR", &power_of_two(up))?;
    exact("ANGLE_SHIFT", &integer((28 - angle_bits).max(0).into()))?;
    let limit = observer.get("BIAS_OBSERVER.limit")?;
    let largest = (integer(i32::MAX.into()) - limit) * power_of_two(-up);
    exact("ANGLE_MAX", &largest.floor())?;

    // Wrapped by whole turns.
    let turn = full_turn()?;
    let turns = (mounting / &turn).round();
    let wrapped = mounting - turns * turn;
    nearest(
        "MOUNTING_ANGLE",
        &single("MOUNTING_ANGLE")?,
        &(wrapped * power_of_two(28)),
    )
}

/// A line: its slope has 30 bits, or fewer if the offset would otherwise exceed 2⁶¹; its offset includes the half that
/// rounds; its ends follow.
fn line(
    module: &Module,
    name: &str,
    slope: &BigRational,
    at_zero: &BigRational,
    low: &BigRational,
    high: &BigRational,
) -> Check {
    let words = NamedWords::read(module, name)?;
    let field = |field: &str| words.get(&format!("{name}.{field}"));
    let scale = power_of_two(words.small(&format!("{name}.shift"))?);
    let word = field("scale")?;
    let real = (at_zero + half()) * &scale;
    // With one more bit, the slope would have 31 bits, or the offset would be too large.
    let is_finest = word.abs() >= power_of_two(29) || real.abs() * integer(2) > power_of_two(61);
    if !is_finest || word.abs() < power_of_two(SLOPE_BITS_MIN) || word.abs() > power_of_two(30) {
        return Err(format!("{name}.scale has not the bits that fit"));
    }
    nearest(&format!("{name}.scale"), &word, &(slope * &scale))?;
    let offset = field("offset")?;
    // An offset with more bits is rounded in double precision, by 2⁻⁵² of its value.
    let is_exact = real
        .to_f64()
        .and_then(BigRational::from_float)
        .is_some_and(|double| double == real);
    let allowed = if is_exact {
        half()
    } else {
        half() + real.abs() * power_of_two(-51)
    };
    if (&offset - &real).abs() > allowed {
        return Err(format!(
            "{name}.offset is {}, the line makes it {}",
            rounded_up(&offset, 20),
            rounded_up(&real, 20)
        ));
    }
    for (end, wanted) in [("low", low), ("high", high)] {
        let found = field(end)?;
        if found != *wanted {
            return Err(format!("{name}.{end} is {found}, not {wanted}"));
        }
    }
    Ok(())
}
