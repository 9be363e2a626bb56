//! Which tests can run on this machine.

use std::path::Path;

use test_conditions::Condition;

/// Where Debian's package arduino-core-avr puts Arduino's core and its libraries.
const ARDUINO_AVR: &str = "/usr/share/arduino/hardware/arduino/avr";

fn main() {
    test_conditions::declare(&[
        Condition::Rustfmt,
        Condition::Recordings,
        Condition::Gcc,
        Condition::CrossGcc,
    ]);
    println!("cargo::rustc-check-cfg=cfg(have_arduino_avr)");
    println!("cargo::rustc-env=ARDUINO_AVR={ARDUINO_AVR}");
    let place = if Path::new(ARDUINO_AVR).is_dir() {
        ARDUINO_AVR
    } else {
        "/usr/share"
    };
    println!("cargo::rerun-if-changed={place}");
    if place == ARDUINO_AVR {
        println!("cargo::rustc-cfg=have_arduino_avr");
    }
}
