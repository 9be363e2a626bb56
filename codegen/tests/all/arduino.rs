//! The example sketch as Arduino builds it, with `firmware/arduino-link`: with Arduino's AVR core, to an image that links.

use std::path::Path;
use std::process::Command;

use codegen::spec::ModuleSpec;
use codegen::{c99, generate};

use crate::benches::{with_body_encoder, with_driver, with_voltage, with_wheel_encoder};
use crate::thesis;

/// Arduino's AVR core, as Debian has it.
const CORE: &str = env!("ARDUINO_AVR");

/// Bytes of flash of the image for a library; a warning in the library or the sketch ends the test. The core's objects are
/// kept in `target`.
fn flash_bytes(options: &[&str], library: &Path, target: &Path) -> usize {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/arduino-link");
    let result = Command::new(script)
        .args(options)
        .arg(library)
        .env("ARDUINO_AVR", CORE)
        .env("ARDUINO_TARGET", target)
        .output()
        .expect("the script starts");
    let said = String::from_utf8_lossy(&result.stderr);
    assert!(result.status.success() && said.is_empty(), "{said}");
    let text = String::from_utf8_lossy(&result.stdout).into_owned();
    let size = text.lines().find_map(|line| line.strip_prefix("flash "));
    let bytes = size.and_then(|size| size.split(' ').next()?.parse().ok());
    bytes.unwrap_or_else(|| panic!("no size: {text}"))
}

/// A bench: its specification, what its documentation says of the hardware, texts that its sketch has, and whether it
/// leaves readings to the user.
struct Bench {
    spec: ModuleSpec,
    registers: &'static [&'static str],
    has: &'static [&'static str],
    is_left_to_the_user: bool,
}

fn all_benches() -> [Bench; 5] {
    [
        Bench {
            spec: thesis::spec(),
            registers: &[
                "gyroscope: FXAS21002, ±2000 °/s",
                "accelerometer: FXOS8700, ±8 g",
                "drive: duty 6554 to 58982 of a timer of 16 bits, 32768 without current",
            ],
            has: &[
                "GYRO = 0x21",
                "ACCEL = 0x1F",
                "WHEEL_SPEED = 0x48",
                "DUTY_BITS = 16;",
            ],
            is_left_to_the_user: false,
        },
        Bench {
            spec: with_body_encoder(thesis::spec()),
            registers: &["body angle: encoder counts 0 to 4095, 4096 a turn"],
            has: &["ENCODER = 0x36", "sample.body_count = word_of"],
            is_left_to_the_user: false,
        },
        Bench {
            spec: with_wheel_encoder(8),
            registers: &[
                "gyroscope: MPU-6050, ±2000 °/s",
                "accelerometer: MPU-6050, ±8 g",
                "drive: duty 410 to 3686 of a timer of 12 bits, 2048 without current",
                "wheel speed: encoder counts 0 to 4095, 4096 a turn",
            ],
            has: &[
                "BODY = 0x68",
                "sample.wheel_count = word_of",
                "DUTY_BITS = 12;",
            ],
            is_left_to_the_user: false,
        },
        // Two AS5600 have one address.
        Bench {
            spec: with_body_encoder(with_wheel_encoder(8)),
            registers: &[
                "body angle: encoder counts 0 to 4095, 4096 a turn",
                "wheel speed: encoder counts 0 to 4095, 4096 a turn",
            ],
            has: &[
                "sample.body_count = word_of",
                "YOUR READING: sample.wheel_count",
            ],
            is_left_to_the_user: true,
        },
        // Parts that nobody names, and a driver.
        Bench {
            spec: with_voltage(with_driver()),
            registers: &[
                "drive: voltage, duty 1 to 4095 of 12 bits, 2048 at 0 V, 0.0117 V per count",
            ],
            has: &[
                "DUTY_BITS = 12;",
                "YOUR READING: sample.gyro",
                "YOUR READING: sample.wheel_speed",
            ],
            is_left_to_the_user: true,
        },
    ]
}

/// Each bench's sketch on an Uno, that of the thesis on a Mega too.
#[test]
#[cfg_attr(
    not(all(have_arduino_avr, have_cross_gcc)),
    ignore = "needs the AVR core of Arduino"
)]
fn the_sketch_links_with_arduinos_avr_core() {
    let folder = tempfile::tempdir().expect("a folder");
    // What each chip has of flash beside its boot loader.
    for (options, flash, count) in [(&[][..], 32_256, 5), (&["--mega"], 253_952, 1)] {
        for (index, mut bench) in all_benches().into_iter().take(count).enumerate() {
            let registers = bench.registers.iter().map(ToString::to_string);
            bench.spec.hardware.registers = registers.collect();
            let emitted = generate(&bench.spec).expect("an emitted crate");
            let library = c99::emit(&emitted).expect("a translation");
            let own = folder.path().join(format!("library-{index}"));
            library.write(&own).expect("written");
            let sketch = library
                .file("examples/flywheel/flywheel.ino")
                .expect("the sketch");
            for text in bench.has {
                assert!(sketch.contains(text), "bench {index}: {text}\n{sketch}");
            }
            let is_left = sketch.contains("\n  // YOUR READING");
            assert_eq!(
                is_left, bench.is_left_to_the_user,
                "bench {index}\n{sketch}"
            );
            let bytes = flash_bytes(options, &own, &folder.path().join("target"));
            println!("bench {index} {options:?}: {bytes} bytes");
            assert!(bytes < flash, "bench {index} {options:?}: {bytes} bytes");
        }
    }
}

/// A sketch whose tables fill an Uno is refused with the board that has room, which links it; not with the linker's words.
#[test]
#[cfg_attr(
    not(all(have_arduino_avr, have_cross_gcc)),
    ignore = "needs the AVR core of Arduino"
)]
fn an_image_that_an_uno_cannot_hold_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let emitted = generate(&thesis::spec()).expect("an emitted crate");
    let library = c99::emit(&emitted).expect("a translation");
    library.write(folder.path()).expect("written");
    let example = library.file("examples/flywheel/flywheel.ino");
    let example = example.expect("the sketch");
    let target = folder.path().join("target");
    let linked = |options: &[&str], table_bytes: usize| {
        let sketch = folder.path().join("large.ino");
        let table = format!("const uint8_t TABLE[{table_bytes}] PROGMEM = {{1}};\n");
        let begins = "void setup() {\n";
        let uses =
            format!("{table}{begins}  OCR1B = pgm_read_byte(TABLE + micros() % {table_bytes});\n");
        std::fs::write(&sketch, example.replace(begins, &uses)).expect("written");
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/arduino-link");
        let result = Command::new(script)
            .args(options)
            .arg(folder.path())
            .arg(&sketch)
            .env("ARDUINO_AVR", CORE)
            .env("ARDUINO_TARGET", &target)
            .output()
            .expect("the script starts");
        let said = String::from_utf8_lossy(&result.stderr).into_owned();
        (result.status.code(), said)
    };
    // More than the chip has.
    let (code, said) = linked(&[], 20_000);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.starts_with("error: the image does not fit into the Uno (more than the chip has by")
            && said.contains("--mega"),
        "{said}"
    );
    let (code, said) = linked(&["--mega"], 20_000);
    assert_eq!((code, said.as_str()), (Some(0), ""));
}
