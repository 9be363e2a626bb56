//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::quote;

use crate::emit::{inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// How a firmware uses the crate; compiled and run as a test of its documentation.
const EXAMPLE: [&str; 20] = [
    "",
    "# Use",
    "",
    "```",
    "use generated::{Controller, Sample, Status, ZERO_CURRENT};",
    "",
    "let mut controller = Controller::new();",
    "// Every SAMPLE_TIME_US: read the sensors, step, write the duty.",
    "let sample = Sample { gyro: [0; 3], accel: [0; 3], mag: None, wheel_adc: 0 };",
    "let duty = controller.step(&sample);",
    "assert_eq!(duty.0, ZERO_CURRENT);",
    "// On the operator's wish; it drives the motor only near upright, at rest, with sound sensors.",
    "assert!(!controller.arm());",
    "assert_eq!(controller.status(), Status::NotAligned);",
    "// A missed tick or a bus error: no current until `arm` succeeds again.",
    "controller.fault();",
    "assert_eq!(controller.step(&sample).0, ZERO_CURRENT);",
    "```",
    "",
    "`status()` says why there is no current; a trip lasts until `arm()` succeeds.",
];

/// Emits `src/lib.rs`.
pub fn file(spec: &ModuleSpec) -> EmittedFile {
    let mut lines = vec![
        "Fixed-point controller of a reaction-wheel pendulum.".to_owned(),
        String::new(),
        format!(
            "Emitted from the model `{}`. It needs no floating point, no heap and nothing but `core`",
            single_line(&spec.model_name)
        ),
        "and `fixed`; no input of whatever value makes it panic. `certificate.json` beside this"
            .to_owned(),
        "crate states everything that is claimed of it, so that it can be checked without the"
            .to_owned(),
        "generator.".to_owned(),
        String::new(),
        "# What the words mean".to_owned(),
    ];
    let list = |lines: &mut Vec<String>, sentences: &[String]| {
        let items = sentences.iter();
        lines.extend(items.map(|text| format!("- {}", single_line(text))));
    };
    list(&mut lines, &spec.hardware.registers);
    if !spec.assumed.is_empty() {
        lines.push(String::new());
        lines.push("# Assumed".to_owned());
        lines.push("The model does not state these; they are those of another bench:".to_owned());
        list(&mut lines, &spec.assumed);
    }
    lines.extend(EXAMPLE.iter().map(|line| (*line).to_owned()));
    let docs = inner_docs(&lines);
    let tokens = quote! {
        #docs
        #![no_std]
        #![forbid(unsafe_code)]
        #![warn(missing_docs)]

        pub mod arc_tangent;
        pub mod attitude;
        pub mod bias_observer;
        pub mod calibration;
        pub mod constants;
        pub mod control;
        pub mod controller;
        pub mod drift;
        pub mod filter;
        pub mod lever_arm;
        pub mod line;
        pub mod madgwick;
        pub mod pivot_angle;
        pub mod product;
        pub mod root;
        pub mod scaling;
        pub mod supervisor;

        pub use attitude::Attitude;
        pub use control::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed, control};
        pub use constants::{SAMPLE_TIME_US, ZERO_CURRENT};
        pub use controller::{Controller, Duty, Sample, duty, wheel_speed};
        pub use supervisor::Status;
    };
    EmittedFile {
        path: "src/lib.rs".to_owned(),
        contents: print(spec, tokens),
    }
}
