//! Reads `[hardware]`, and fills in the presets.

use toml_edit::Item;

use super::parts::{Numbers, Part, Role, named, names};
use super::rotation::{by_axes, product, rotation};
use super::{AngleSensor, Drive, DriveKind, Hardware, InertialSensor, WheelSpeedSensor};
use crate::error::{Error, Names, Problem};
use crate::keys;
use crate::toml_section::Section;
use crate::toml_source::TomlSource;

/// Number of bits of the word that holds an inertial sensor's reading.
const WORD_BITS: u32 = 16;

impl Hardware {
    /// Reads the section of a document, if it has one.
    pub(crate) fn read(source: &TomlSource, root: &Section) -> Result<Option<Hardware>, Error> {
        let Some(section) = root.section("hardware")? else {
            return Ok(None);
        };
        section.allow_only(&keys::names(keys::BENCH, "hardware"))?;
        let sensor = |key, role| match section.section(key)? {
            Some(table) => inertial(&table, role).map(Some),
            None => Ok(None),
        };
        let gyroscope = sensor("gyroscope", Role::Gyroscope)?;
        let accelerometer = sensor("accelerometer", Role::Accelerometer)?;
        let mut magnetometer = sensor("magnetometer", Role::Magnetometer)?;
        // A magnetometer in the same housing turns with it; the part's own axes are kept.
        if let (Some(magnetometer), Some(other)) = (&mut magnetometer, &accelerometer)
            && let (Some(part), Some(of_other)) = (magnetometer.part, other.part)
            && part.name == of_other.name
            && section
                .section("magnetometer")?
                .is_some_and(|table| !table.has("axes") && !table.has("rotation"))
            && let (Some(own), Some(housing)) = (magnetometer.rotation, other.rotation)
        {
            magnetometer.rotation = Some(product(&housing, &own));
        }
        let wheel_speed = section.section("wheel_speed")?.as_ref().map(wheel_speed);
        let angle = section.section("angle")?.as_ref().map(angle);
        let drive = section.section("drive")?.as_ref().map(drive);
        Ok(Some(Hardware {
            gyroscope,
            accelerometer,
            magnetometer,
            wheel_speed: wheel_speed.transpose()?,
            angle: angle.transpose()?,
            drive: drive.transpose()?,
            text: text(source)?,
        }))
    }
}

/// The section's text, without its position in the document.
fn text(source: &TomlSource) -> Result<Item, Error> {
    fn loosened(item: &mut Item) {
        if let Item::Table(table) = item {
            table.set_position(None);
            for (_, inner) in table.iter_mut() {
                loosened(inner);
            }
        }
    }
    let mut document = source.parse()?.into_mut();
    let mut item = document.remove("hardware").unwrap_or(Item::None);
    loosened(&mut item);
    Ok(item)
}

/// The preset that `part` names.
fn preset(table: &Section, roles: &[Role]) -> Result<Option<&'static Part>, Error> {
    let Some(part) = table.text("part")? else {
        return Ok(None);
    };
    match named(&part.value, roles) {
        Some(preset) => Ok(Some(preset)),
        None => Err(table.error_at(
            "part",
            Problem::NoDataForPart {
                name: part.value,
                instead: match roles {
                    [Role::Encoder] => "counts_per_turn and bits",
                    [Role::CurrentDrive | Role::VoltageDrive, ..] => {
                        "kind, bits, duty_zero, duty_low, duty_high and amperes_per_count"
                    }
                    _ => "scale, bits, clip and rate",
                },
                names: Names::new(names(roles)),
            },
        )),
    }
}

fn inertial(table: &Section, role: Role) -> Result<InertialSensor, Error> {
    let section = match role {
        Role::Accelerometer => "hardware.accelerometer",
        _ => "hardware.gyroscope",
    };
    table.allow_only(&keys::names(keys::BENCH, section))?;
    let part = preset(table, &[role])?;
    let mut sensor = InertialSensor {
        part,
        scale: None,
        bits: WORD_BITS,
        is_left_justified: false,
        clip: [0; 3],
        rate_hz: None,
        rotation: None,
        lever_arm_m: None,
    };
    let mut preset_clip = None;
    if let Some(Numbers::Inertial {
        scale,
        bits,
        is_left_justified,
        clip,
        rate_hz,
        axes,
    }) = part.map(|part| &part.numbers)
    {
        sensor.scale = Some(*scale);
        sensor.bits = *bits;
        sensor.is_left_justified = *is_left_justified;
        sensor.rate_hz = Some(*rate_hz);
        // The bench determines the orientation of the housing; a magnetometer may have other axes inside it.
        if role == Role::Magnetometer {
            sensor.rotation = by_axes(axes);
        }
        preset_clip = Some(*clip);
    }
    if let Some(scale) = table.positive_number("scale")? {
        sensor.scale = Some(scale.value);
    }
    if let Some(bits) = whole(table, "bits", 8, WORD_BITS.into())? {
        sensor.bits = bits as u32;
        preset_clip = None;
    }
    if let Some(justified) = table.text("justified")? {
        sensor.is_left_justified = match justified.value.as_str() {
            "left" => true,
            "right" => false,
            _ => return Err(unknown(table, "justified", &["right", "left"])?),
        };
        preset_clip = None;
    }
    let largest = (1 << (sensor.bits - 1)) - 1;
    let shift = if sensor.is_left_justified {
        WORD_BITS - sensor.bits
    } else {
        0
    };
    sensor.clip = preset_clip.unwrap_or([largest << shift; 3]);
    let expected = "a list of three counts, one for each axis";
    if let Some(clip) = table.numbers("clip", &[3], expected)? {
        for (limit, counts) in sensor.clip.iter_mut().zip(&clip) {
            if counts.fract() != 0.0 || !(1.0..=32_767.0).contains(counts) {
                return Err(out_of_range(
                    table,
                    "clip",
                    *counts,
                    "whole counts from 1 to 32767",
                ));
            }
            *limit = *counts as i32;
        }
    }
    if let Some(rate) = table.positive_number("rate")? {
        sensor.rate_hz = Some(rate.value);
    }
    if let Some(rotation) = rotation(table)? {
        sensor.rotation = Some(rotation);
    }
    let expected = "a list of two numbers, along the body's x and y in m";
    if let Some(arm) = table.numbers("lever_arm", &[2], expected)? {
        sensor.lever_arm_m = Some([arm[0], arm[1]]);
    }
    Ok(sensor)
}

/// The kinds of wheel speed sensors.
const WHEEL_SPEED_KINDS: [&str; 3] = ["converter", "encoder", "driver"];
/// The kinds of angle sensors.
const ANGLE_KINDS: [&str; 2] = ["inertial", "encoder"];
/// The kinds of drives.
const DRIVE_KINDS: [&str; 2] = ["current", "voltage"];

/// Refuses keys that this kind of a part does not have, and says which kind has them.
fn allow_only_of(
    table: &Section,
    part: &str,
    kind: &'static str,
    kinds: &[&'static str],
) -> Result<(), Error> {
    let keys_of = |kind: &str| keys::names(keys::BENCH, &format!("{part}, {kind}"));
    let own = keys_of(kind);
    for key in table.keys() {
        if own.contains(&key.value.as_str()) {
            continue;
        }
        let mut others = kinds.iter().copied();
        if let Some(other) = others.find(|other| keys_of(other).contains(&key.value.as_str())) {
            return Err(table.error_at(
                &key.value,
                Problem::KeyOfOtherKind {
                    key: key.value.clone(),
                    section: format!("[{part}]"),
                    belongs_to: other,
                    kind,
                },
            ));
        }
    }
    table.allow_only(&own)
}

fn wheel_speed(table: &Section) -> Result<WheelSpeedSensor, Error> {
    let kind = table.required_text("kind", "kind = \"converter\" (or encoder, driver)")?;
    match kind.value.as_str() {
        "converter" => {
            allow_only_of(
                table,
                "hardware.wheel_speed",
                "converter",
                &WHEEL_SPEED_KINDS,
            )?;
            let count = |key: &str| -> Result<u16, Error> {
                match whole(table, key, 0, 65_535)? {
                    Some(count) => Ok(count as u16),
                    None => Err(table.error(table.missing(
                        key,
                        "low = 0 and high = 4095 (counts at the ends of the converter's range)",
                    ))),
                }
            };
            let (low, high) = (count("low")?, count("high")?);
            if low >= high {
                return Err(out_of_range(
                    table,
                    "high",
                    f64::from(high),
                    "greater than low",
                ));
            }
            let slope = table.number("slope")?.map(|slope| slope.value);
            if slope == Some(0.0) {
                return Err(out_of_range(table, "slope", 0.0, "other than zero"));
            }
            Ok(WheelSpeedSensor::Converter {
                slope,
                offset: table.number("offset")?.map(|offset| offset.value),
                low,
                high,
            })
        }
        "encoder" => {
            allow_only_of(table, "hardware.wheel_speed", "encoder", &WHEEL_SPEED_KINDS)?;
            let (counts_per_turn, bits) = encoder(table)?;
            Ok(WheelSpeedSensor::Encoder {
                counts_per_turn,
                bits,
                window: match whole(table, "window", 1, 64)? {
                    Some(window) => window as u32,
                    None => {
                        return Err(table.error(table.missing("window", "window = 8 (samples)")));
                    }
                },
                largest_rad_s: largest(table)?,
            })
        }
        "driver" => {
            allow_only_of(table, "hardware.wheel_speed", "driver", &WHEEL_SPEED_KINDS)?;
            let scale = table.required_number("scale")?;
            if scale == 0.0 {
                return Err(out_of_range(table, "scale", 0.0, "other than zero"));
            }
            Ok(WheelSpeedSensor::Driver {
                scale,
                largest_rad_s: largest(table)?,
            })
        }
        _ => Err(unknown(table, "kind", &WHEEL_SPEED_KINDS)?),
    }
}

/// The largest speed of the wheel, where it is stated.
fn largest(table: &Section) -> Result<Option<f64>, Error> {
    let stated = table.positive_number("largest")?;
    Ok(stated.map(|largest| largest.value))
}

fn angle(table: &Section) -> Result<AngleSensor, Error> {
    let kind = table.required_text("kind", "kind = \"inertial\" (or encoder)")?;
    match kind.value.as_str() {
        "inertial" => {
            allow_only_of(table, "hardware.angle", "inertial", &ANGLE_KINDS)?;
            Ok(AngleSensor::Inertial)
        }
        "encoder" => {
            allow_only_of(table, "hardware.angle", "encoder", &ANGLE_KINDS)?;
            let (counts_per_turn, bits) = encoder(table)?;
            let largest = (1_i64 << bits) - 1;
            match whole(table, "zero", 0, largest)? {
                Some(zero) => Ok(AngleSensor::Encoder {
                    counts_per_turn,
                    bits,
                    zero: zero as u32,
                }),
                None => Err(table.error(table.missing("zero", "zero = 2048 (the count upright)"))),
            }
        }
        _ => Err(unknown(table, "kind", &ANGLE_KINDS)?),
    }
}

/// Counts per turn and bits of an encoder.
fn encoder(table: &Section) -> Result<(f64, u32), Error> {
    let part = preset(table, &[Role::Encoder])?;
    let (mut counts, mut bits) = match part.map(|part| &part.numbers) {
        Some(Numbers::Encoder {
            counts_per_turn,
            bits,
        }) => (Some(*counts_per_turn), *bits),
        _ => (None, WORD_BITS),
    };
    if let Some(stated) = table.number("counts_per_turn")? {
        counts = Some(stated.value);
    }
    if let Some(stated) = whole(table, "bits", 4, WORD_BITS.into())? {
        bits = stated as u32;
    }
    match counts {
        Some(counts) if counts.abs() >= 4.0 => Ok((counts, bits)),
        Some(counts) => Err(out_of_range(
            table,
            "counts_per_turn",
            counts,
            "at least 4 either way",
        )),
        None => Err(table.error(table.missing("counts_per_turn", "counts_per_turn = 4096"))),
    }
}

fn drive(table: &Section) -> Result<Drive, Error> {
    let part = preset(table, &[Role::CurrentDrive, Role::VoltageDrive])?;
    let kind = match table.text("kind")? {
        Some(kind) => kind.value,
        None => match part {
            Some(part) if part.role == Role::VoltageDrive => "voltage".to_owned(),
            Some(_) => "current".to_owned(),
            None => {
                let example = "kind = \"current\" (or voltage)";
                return Err(table.error(table.missing("kind", example)));
            }
        },
    };
    let kind = match kind.as_str() {
        "current" => {
            allow_only_of(table, "hardware.drive", "current", &DRIVE_KINDS)?;
            DriveKind::Current
        }
        "voltage" => {
            allow_only_of(table, "hardware.drive", "voltage", &DRIVE_KINDS)?;
            DriveKind::Voltage {
                supply_v: table
                    .required_positive_number("supply_voltage", "supply_voltage = 12.0 (V)")?,
                winding_ohm: table.required_positive_number(
                    "winding_resistance",
                    "winding_resistance = 1.2 (Ohm)",
                )?,
            }
        }
        _ => return Err(unknown(table, "kind", &DRIVE_KINDS)?),
    };
    let mut drive = Drive {
        kind,
        bits: WORD_BITS,
        duty_zero: None,
        duty_low: None,
        duty_high: None,
        amperes_per_count: None,
    };
    if let Some(Numbers::Drive {
        bits,
        duty,
        amperes_per_count,
    }) = part.map(|part| &part.numbers)
    {
        drive.bits = *bits;
        if let Some([low, zero, high]) = duty {
            drive.duty_low = Some(*low);
            drive.duty_zero = Some(*zero);
            drive.duty_high = Some(*high);
        }
        drive.amperes_per_count = *amperes_per_count;
    }
    if let Some(bits) = whole(table, "bits", 4, WORD_BITS.into())? {
        drive.bits = bits as u32;
    }
    let largest = (1_i64 << drive.bits) - 1;
    for (key, duty) in [
        ("duty_zero", &mut drive.duty_zero),
        ("duty_low", &mut drive.duty_low),
        ("duty_high", &mut drive.duty_high),
    ] {
        if let Some(stated) = whole(table, key, 0, largest)? {
            *duty = Some(stated as u16);
        } else if let Some(preset) = *duty
            && i64::from(preset) > largest
        {
            return Err(table.error(table.missing(key, "a duty within the timer's bits")));
        }
    }
    if let (Some(low), Some(high)) = (drive.duty_low, drive.duty_high) {
        let zero = drive.duty_zero.unwrap_or(low.saturating_add(1));
        if low >= high || !(low < zero && zero < high) {
            return Err(out_of_range(
                table,
                "duty_zero",
                f64::from(zero),
                "between duty_low and duty_high",
            ));
        }
    }
    if let Some(slope) = table.number("amperes_per_count")? {
        if slope.value == 0.0 {
            let must_be = "other than zero";
            return Err(out_of_range(table, "amperes_per_count", 0.0, must_be));
        }
        drive.amperes_per_count = Some(slope.value);
    }
    Ok(drive)
}

/// The whole number under a key, within these limits.
fn whole(table: &Section, key: &str, low: i64, high: i64) -> Result<Option<i64>, Error> {
    let Some(number) = table.number(key)? else {
        return Ok(None);
    };
    let value = number.value;
    if value.fract() != 0.0 || value < low as f64 || value > high as f64 {
        let must_be = format!("a whole number from {low} to {high}");
        return Err(out_of_range(table, key, value, &must_be));
    }
    Ok(Some(value as i64))
}

fn out_of_range(table: &Section, key: &str, value: f64, must_be: &str) -> Error {
    table.error_at(
        key,
        Problem::OutOfRange {
            key: key.to_string(),
            value,
            must_be: must_be.to_string(),
        },
    )
}

/// The error for a text that is not in a list.
fn unknown(table: &Section, key: &'static str, known: &[&str]) -> Result<Error, Error> {
    let name = table.required_text(key, "one of the known names")?.value;
    Ok(table.error_at(
        key,
        Problem::UnknownName {
            what: key.to_string(),
            name,
            names: Names::new(known),
        },
    ))
}
