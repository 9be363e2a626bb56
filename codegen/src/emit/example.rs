//! How a firmware uses the crate, in ten lines: for the documentation of the crate, where it is compiled and
//! run as a test, and for the README.

use crate::crate_name::CrateName;
use crate::runtime_parts::{Parts, WheelPart};

/// The example, a line each.
pub(super) fn lines(name: &CrateName, parts: &Parts) -> Vec<String> {
    let name = name.in_rust();
    let wheel = wheel_field(parts);
    let text = format!(
        r"use {name}::{{Controller, Sample, Status, ZERO_CURRENT}};

let mut controller = Controller::new();
// Every SAMPLE_TIME_US: read the sensors, step, write the duty to the timer.
let sample = Sample {{ gyro: [0; 3], accel: [0; 3], mag: None, {wheel}: 0 }};
let duty = controller.step(&sample);
assert_eq!(duty.0, ZERO_CURRENT); // nothing is driven before it is armed
// When the user wants it: true once the attitude is known, near upright and at rest; here it is not.
assert!(!controller.arm());
assert_eq!(controller.status(), Status::NotAligned);
controller.fault(); // a missed tick or a bus error: no current until `arm` succeeds again"
    );
    text.lines().map(str::to_owned).collect()
}

/// The field of a sample that the wheel's sensor fills.
pub(super) fn wheel_field(parts: &Parts) -> &'static str {
    match parts.wheel {
        WheelPart::Converter => "wheel_adc",
        WheelPart::Driver => "wheel_speed",
        WheelPart::Encoder => "wheel_count",
    }
}
