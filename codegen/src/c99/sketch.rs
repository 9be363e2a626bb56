//! The example sketch for Arduino: a frame, and the reading of the sensors for which the crate was emitted. The crate's
//! documentation names them. If the documentation does not name a sensor, or if this program cannot know how to read
//! it, the sketch has a place marked YOUR READING. This place fails until it is filled in, and the motor is not driven.

use crate::file::{EmittedCrate, EmittedFile, MARK};

const FRAME: &str = include_str!("sketch/frame.ino");
const BUS: &str = include_str!("sketch/bus.ino");
const WRITE_REGISTER: &str = include_str!("sketch/write_register.ino");
const FXOS8700: &str = include_str!("sketch/body_fxos8700.ino");
const MPU6050: &str = include_str!("sketch/body_mpu6050.ino");
const BODY_YOURS: &str = include_str!("sketch/body_yours.ino");
const PIVOT_YOURS: &str = include_str!("sketch/pivot_yours.ino");
const AS5600: &str = include_str!("sketch/as5600.ino");
const ADS1015: &str = include_str!("sketch/wheel_ads1015.ino");
const WHEEL_YOURS: &str = include_str!("sketch/wheel_yours.ino");

/// Number of bits of the timer, if the documentation of the crate does not state it.
const DUTY_BITS: &str = "16";

/// The sketch for an emitted crate.
pub fn file(emitted: &EmittedCrate) -> EmittedFile {
    let controller = emitted.file("src/controller.rs").unwrap_or_default();
    let documented = Documented(emitted.file("src/lib.rs").unwrap_or_default());
    let has_field = |name: &str| controller.contains(&format!("pub {name}:"));
    let body = body(has_field("body_count"), &documented);
    let wheel = match () {
        () if has_field("wheel_count") => wheel_encoder(&body, &documented),
        () if has_field("wheel_speed") => yours(
            "what receives the speed from the motor's driver",
            "wheel_speed",
            "the signed word that the driver sends",
        ),
        () => Reading::of("an ADS1015 for the wheel", ADS1015.to_string()),
    };
    let needs_registers = body.text.contains("write_register");
    let uses_bus = body.text.contains("read_bytes") || wheel.text.contains("read_bytes");
    let mut sensors = String::new();
    for line in documented.hardware() {
        sensors.push_str(&format!("// {line}\n"));
    }
    if uses_bus {
        sensors.push_str(BUS);
    }
    if needs_registers {
        sensors.push_str(WRITE_REGISTER);
    }
    sensors.push_str(&body.text);
    sensors.push_str(&wheel.text);
    let text = FRAME
        .replace("BODY_WORDS", body.words)
        .replace("WHEEL_WORDS", wheel.words)
        .replace("BITS_OF_THE_DUTY", documented.duty_bits())
        .replace("SENSORS\n", &sensors);
    EmittedFile {
        path: "examples/flywheel/flywheel.ino".to_string(),
        contents: format!("// {MARK}; save it under another name before you change it.\n{text}"),
    }
}

/// The functions that start and read a sensor, and the name of the sensor.
struct Reading {
    words: &'static str,
    text: String,
}

impl Reading {
    fn of(words: &'static str, text: String) -> Reading {
        Reading { words, text }
    }
}

/// The documentation of the hardware in the emitted crate: `src/lib.rs`.
struct Documented<'a>(&'a str);

impl Documented<'_> {
    /// The lines of the list of the hardware.
    fn hardware(&self) -> impl Iterator<Item = &str> {
        let lines = self.0.lines();
        lines
            .skip_while(|line| *line != "//! # Sensors and drive")
            .skip(1)
            .map_while(|line| line.strip_prefix("//! - "))
    }

    fn says(&self, start: &str) -> bool {
        self.hardware().any(|line| line.starts_with(start))
    }

    fn duty_bits(&self) -> &str {
        let drive = self.hardware().find(|line| line.starts_with("drive: "));
        let before = drive.and_then(|line| line.split_once(" bits, "));
        let bits = before.and_then(|(before, _)| before.rsplit(' ').next());
        bits.unwrap_or(DUTY_BITS)
    }
}

fn body(has_pivot: bool, documented: &Documented) -> Reading {
    match has_pivot {
        true if documented.says("body angle: encoder counts 0 to 4095,") => {
            as5600("body", "body_count", "on the pivot")
        }
        true => Reading::of("your encoder on the pivot", PIVOT_YOURS.to_string()),
        false
            if documented.says("gyroscope: FXAS21002,")
                && documented.says("accelerometer: FXOS8700,") =>
        {
            Reading::of("FXAS21002C and FXOS8700", FXOS8700.to_string())
        }
        false
            if documented.says("gyroscope: MPU-6050,")
                && documented.says("accelerometer: MPU-6050,") =>
        {
            Reading::of("MPU-6050", MPU6050.to_string())
        }
        false => Reading::of("your gyroscope and accelerometer", BODY_YOURS.to_string()),
    }
}

/// An encoder at the wheel. Every AS5600 has the same address, so that only one of them can be on the bus.
fn wheel_encoder(body: &Reading, documented: &Documented) -> Reading {
    if !documented.says("wheel speed: encoder counts 0 to 4095,") {
        return yours("the encoder of the wheel", "wheel_count", "its count");
    }
    if body.text.contains("AS5600") {
        return yours(
            "the encoder of the wheel: a second AS5600 has the address of the first, so give it another bus",
            "wheel_count",
            "its count",
        );
    }
    as5600("wheel", "wheel_count", "on the wheel")
}

fn as5600(part: &str, field: &str, place: &str) -> Reading {
    let words = match part {
        "body" => "an AS5600 on the pivot",
        _ => "an AS5600 on the wheel",
    };
    let text = AS5600
        .replace("WHERE", place)
        .replace("PART", part)
        .replace("FIELD", field);
    Reading::of(words, text)
}

fn yours(how: &str, field: &str, what: &str) -> Reading {
    let text = WHEEL_YOURS
        .replace("HOW", how)
        .replace("FIELD", field)
        .replace("WHAT", what);
    Reading::of("your reading for the wheel", text)
}
