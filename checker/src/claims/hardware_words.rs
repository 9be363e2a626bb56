//! The words of `src/constants.rs` against the real numbers in its documentation and, for the observer
//! of the angle's bias (see [`crate::claims::bias_observer_words`]), in the certificate.
//!
//! What each word stands for is derived here from the formats that the emitted fields state:
//! half-angles a step in Q32, matrices in Q17 of which the accelerometer's and magnetometer's are
//! scaled so that the largest row adds up to 2³⁰, biases in 2⁻¹⁵ counts, lines as slope and offset
//! over one power of two.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::certificate::reader::Certificate;
use crate::claims::bias_observer_words::check_words;
use crate::claims::control_law::{EmittedLaw, exponent};
use crate::claims::named_words::{NamedWords, nearest};
use crate::exact::rational::{decimal, half, integer, power_of_two, rounded_up};
use crate::language::module::Module;

type Check = Result<(), String>;

/// The smallest power of two of a line's slope: with it the slope is off by 2⁻²⁴ of itself, a
/// hundredth of a count over a duty of 16 bits.
const SLOPE_BITS_MIN: i32 = 23;

/// Numbers in a line of text, in order.
pub(crate) fn numbers(text: &str) -> Vec<BigRational> {
    text.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
        .map(|piece| piece.trim_end_matches(['.', '+', '-', 'e']))
        .filter_map(decimal)
        .collect()
}

/// The line of documentation of `src/constants.rs` in which `mark` stands, from there on.
pub(crate) fn after<'a>(text: &'a str, mark: &str) -> Result<&'a str, String> {
    text.lines()
        .find_map(|line| line.strip_prefix("///")?.split_once(mark))
        .map(|(_, rest)| rest)
        .ok_or_else(|| format!("src/constants.rs does not document `{mark}`"))
}

/// Checks all words.
///
/// # Errors
/// A sentence that names the word.
pub fn check(certificate: &Certificate, module: &Module, law: &EmittedLaw) -> Check {
    let text = module
        .text("src/constants.rs")
        .ok_or("there is no src/constants.rs")?;
    let period = &certificate.sample_time_s.value;
    let stated = numbers(after(text, "Attitude filter at")?);
    let [stated_period, beta, ..] = stated.as_slice() else {
        return Err("the documents of FILTER do not state sample time and beta".to_owned());
    };
    if stated_period != period {
        return Err("the filter's sample time is not that of the certificate".to_owned());
    }
    let filter = NamedWords::read(module, "FILTER")?;
    let stated = numbers(after(text, "Gravity")?);
    let [gravity, .., field, lever_x, lever_y] = stated.as_slice() else {
        return Err("the documents of FILTER do not state gravity, field and lever".to_owned());
    };
    nearest(
        "FILTER.beta",
        &filter.get("FILTER.beta")?,
        &(beta * period * power_of_two(35)),
    )?;

    let clips = numbers(after(text, "Unknown at or beyond:")?);
    if clips.len() != 6 {
        return Err("the documents of FILTER do not state where the sensors clip".to_owned());
    }
    for (index, stated) in clips.iter().enumerate() {
        let sensor = ["accel", "mag"][index / 3];
        let name = format!("FILTER.{sensor}_clip[{}]", index % 3);
        let word = filter.get(&name)?;
        if word != *stated || !word.is_positive() {
            return Err(format!("{name} is {word}, its documents say {stated}"));
        }
    }

    drift(&filter, text, period)?;

    let gyro_unit = period * half() * power_of_two(49);
    sensor(
        &filter,
        text,
        "gyroscope, rad/s per count |",
        "gyro",
        Some(&gyro_unit),
    )?;
    let accel_unit = sensor(
        &filter,
        text,
        "accelerometer, m/s2 per count |",
        "accel",
        None,
    )?;
    let mag_unit = sensor(&filter, text, "magnetometer, uT per count |", "mag", None)?;

    // Units per m/s² and per uT, the matrices' Q17 taken off; squares in units of 2³².
    let per_m_s2 = accel_unit * power_of_two(-17);
    let shortest = gravity * integer(1) / integer(8) * &per_m_s2;
    squared(&filter, "FILTER.gravity_squared_min", &shortest)?;
    squared(
        &filter,
        "FILTER.field_squared_min",
        &(field * mag_unit * power_of_two(-17)),
    )?;
    let square = period * period;
    let centripetal = integer(4) / &square * &per_m_s2 * power_of_two(-16);
    let tangential = integer(1) / &square * &per_m_s2 * power_of_two(-16);
    for (index, lever) in [lever_x, lever_y].into_iter().enumerate() {
        let name = format!("FILTER.lever_arm.centripetal[{index}]");
        nearest(&name, &filter.get(&name)?, &(lever * &centripetal))?;
        let name = format!("FILTER.lever_arm.tangential[{index}]");
        nearest(&name, &filter.get(&name)?, &(lever * &tangential))?;
    }

    let angle_bits = exponent(law.state_bits[0]);
    let observer = NamedWords::read(module, "BIAS_OBSERVER")?;
    check_words(certificate, text, law, &observer)?;
    check_angle(module, text, angle_bits, &observer)?;

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

    let wheel_unit = power_of_two(exponent(law.state_bits[2]));
    let stated = numbers(after(text, "to the word of the wheel speed (")?);
    let [.., slope, offset, range] = stated.as_slice() else {
        return Err("the documents of WHEEL_SPEED_LINE do not state the line".to_owned());
    };
    if *range != certificate.inputs[2].range.value {
        return Err("the wheel speed's range is not that of the certificate".to_owned());
    }
    let end = (range * &wheel_unit).floor().min(largest);
    line(
        module,
        "WHEEL_SPEED_LINE",
        &(slope * &wheel_unit),
        &(offset * &wheel_unit),
        &-&end,
        &end,
    )?;

    let drive = &certificate.drive;
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
    )?;
    if let Some(closed_loop) = &certificate.closed_loop {
        check_sensor_steps(text, gravity, closed_loop)?;
    }
    Ok(())
}

/// The counts that the closed loop's certificate speaks of are those of the documented sensors.
fn check_sensor_steps(
    text: &str,
    gravity: &BigRational,
    stated: &crate::certificate::reader::CertifiedLoop,
) -> Check {
    let row = |mark: &str, rows: &[usize]| -> Result<BigRational, String> {
        let numbers = numbers(after(text, mark)?);
        rows.iter()
            .map(|row| {
                let entries = numbers.get(3 + 3 * row..6 + 3 * row);
                entries.map(|entries| entries.iter().map(Signed::abs).sum::<BigRational>())
            })
            .collect::<Option<Vec<_>>>()
            .and_then(|sums| sums.into_iter().max())
            .ok_or_else(|| format!("the row `{mark}` has no matrix"))
    };
    let wheel = numbers(after(text, "to the word of the wheel speed (")?);
    let wheel = wheel
        .iter()
        .rev()
        .nth(2)
        .ok_or("the wheel speed's line is not documented")?;
    let found = [
        row("accelerometer, m/s2 per count |", &[0, 1])? / gravity,
        row("gyroscope, rad/s per count |", &[2])?,
        wheel.abs(),
    ];
    for (index, found) in found.iter().enumerate() {
        let stated = &stated.sensor_steps[index];
        if (&stated.value - found).abs() > found * crate::exact::rational::power(10, -12) {
            return Err(format!(
                "sensor_steps[{index}] is stated as {stated}, the sensor's count is {}",
                rounded_up(found, 12)
            ));
        }
    }
    Ok(())
}

/// How the drift is followed: as documented, with as many bits as leave room for the largest.
fn drift(filter: &NamedWords, text: &str, period: &BigRational) -> Check {
    let stated = numbers(after(text, "drift is followed within")?);
    let [time, limit] = stated.as_slice() else {
        return Err("the documents of FILTER do not state how the drift is followed".to_owned());
    };
    if !time.is_positive() || !limit.is_positive() {
        return Err("the drift is followed in no time, or not at all".to_owned());
    }
    let shift = filter.small("FILTER.drift.shift")?;
    if !(0..=14).contains(&shift) {
        return Err(format!("FILTER.drift.shift is {shift}"));
    }
    nearest(
        "FILTER.drift.gain",
        &filter.get("FILTER.drift.gain")?,
        &(period / time * power_of_two(28 + shift)),
    )?;
    let word = filter.get("FILTER.drift.limit")?;
    let real = limit * period * half() * power_of_two(32 + shift);
    let real = real.min(power_of_two(30));
    if !word.is_positive() || (&word - &real).abs() > integer(1) + &real * power_of_two(-40) {
        return Err(format!("FILTER.drift.limit is {word}"));
    }
    Ok(())
}

/// One sensor's bias and matrix; returns the factor from matrix to words.
fn sensor(
    words: &NamedWords,
    text: &str,
    mark: &str,
    name: &str,
    unit: Option<&BigRational>,
) -> Result<BigRational, String> {
    let stated = numbers(after(text, mark)?);
    if stated.len() != 12 {
        return Err(format!(
            "the row `{mark}` does not hold a bias and a matrix"
        ));
    }
    let (bias, matrix) = stated.split_at(3);
    let unit = match unit {
        Some(unit) => unit.clone(),
        None => {
            let largest = (0..3)
                .map(|row| matrix[3 * row..3 * row + 3].iter().map(Signed::abs).sum())
                .max()
                .filter(|sum: &BigRational| sum.is_positive())
                .ok_or_else(|| format!("the matrix of `{name}` is zero"))?;
            power_of_two(30) / largest
        }
    };
    let shift = words.small(&format!("FILTER.{name}.shift"))?;
    // Half a unit of the output, and one for what the three products round down on average.
    let half_unit = words.get(&format!("FILTER.{name}.half_unit"))?;
    if half_unit != (power_of_two(shift) * half()).floor() + integer(1) {
        return Err(format!("FILTER.{name}.half_unit is {half_unit}"));
    }
    for (index, counts) in bias.iter().enumerate() {
        let word = format!("FILTER.{name}.bias[{index}]");
        nearest(&word, &words.get(&word)?, &(counts * power_of_two(15)))?;
    }
    for (row, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for column in 0..3 {
            let word = format!("FILTER.{name}.{letter}[{column}]");
            let real = &matrix[3 * row + column] * &unit * power_of_two(shift);
            nearest(&word, &words.get(&word)?, &real)?;
        }
    }
    Ok(unit)
}

fn squared(words: &NamedWords, name: &str, length: &BigRational) -> Check {
    let real = length * length * power_of_two(-32);
    nearest(name, &words.get(name)?, &real.max(BigRational::one()))
}

fn check_angle(module: &Module, text: &str, angle_bits: i32, observer: &NamedWords) -> Check {
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

    let stated = numbers(after(text, "Mounting angle")?);
    let mounting = stated
        .first()
        .ok_or("the mounting angle is not documented")?;
    // Wrapped by whole turns, with π to 40 digits.
    let pi = decimal("3.141592653589793238462643383279502884197").ok_or("π")?;
    let turns = (mounting / (&pi * integer(2))).round();
    let wrapped = mounting - turns * pi * integer(2);
    nearest(
        "MOUNTING_ANGLE",
        &single("MOUNTING_ANGLE")?,
        &(wrapped * power_of_two(28)),
    )
}

/// A line: slope to 30 bits, or fewer where the offset would not stay within 2⁶¹, offset with the
/// half that rounds, and its ends.
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
    // With one bit more the slope would have 31, or the offset be too large.
    let is_finest = word.abs() >= power_of_two(29) || real.abs() * integer(2) > power_of_two(61);
    if !is_finest || word.abs() < power_of_two(SLOPE_BITS_MIN) || word.abs() > power_of_two(30) {
        return Err(format!("{name}.scale has not the bits that fit"));
    }
    nearest(&format!("{name}.scale"), &word, &(slope * &scale))?;
    let offset = field("offset")?;
    // The offset is rounded in double precision, some 2⁻⁵² of itself, where it has more bits than that.
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
