//! How a firmware uses the crate, in ten lines: for the documentation of the crate, where it is compiled and
//! run as a test, and for the README.

use crate::crate_name::CrateName;
use crate::runtime_parts::{Parts, WheelPart};

/// The example, a line each.
pub(super) fn lines(name: &CrateName, parts: &Parts) -> Vec<String> {
    let name = name.in_rust();
    let (body, wheel) = (body_fields(parts), wheel_field(parts));
    let when = match parts.has_body_encoder {
        true => "once the body has stood near upright and at rest",
        false => "once the attitude is known, near upright and at rest",
    };
    let text = format!(
        r"use {name}::{{Controller, Sample, Status, ZERO_CURRENT}};

let mut controller = Controller::new();
// Every SAMPLE_TIME_US: read the sensors, step, write the duty to the timer.
let sample = Sample {{ {body}, {wheel}: 0 }};
let duty = controller.step(&sample);
assert_eq!(duty.0, ZERO_CURRENT); // nothing is driven before it is armed
// When the user wants it: true {when}; here it is not.
assert!(!controller.arm());
assert_eq!(controller.status(), Status::NotAligned);
controller.fault(); // a missed tick or a bus error: no current until `arm` succeeds again"
    );
    text.lines().map(str::to_owned).collect()
}

/// The fields of a sample that the sensors of the body fill, with zeros.
pub(super) fn body_fields(parts: &Parts) -> &'static str {
    match parts.has_body_encoder {
        true => "body_count: 0",
        false => "gyro: [0; 3], accel: [0; 3], mag: None",
    }
}

/// The field of a sample that the wheel's sensor fills.
pub(super) fn wheel_field(parts: &Parts) -> &'static str {
    match parts.wheel {
        WheelPart::Converter => "wheel_adc",
        WheelPart::Driver => "wheel_speed",
        WheelPart::Encoder => "wheel_count",
    }
}
