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

/// What a firmware with a monitor adds after each step.
const MONITOR_EXAMPLE: [&str; 19] = [
    "",
    "# Monitor",
    "",
    "```",
    "use generated::{Controller, Monitor, Sample, Status, wheel_speed};",
    "",
    "let (mut controller, mut monitor) = (Controller::new(), Monitor::new());",
    "let sample = Sample { gyro: [0; 3], accel: [0; 3], mag: None, wheel_adc: 0 };",
    "let duty = controller.step(&sample);",
    "// Whether the wheel and the body move as the model allows after the duties that were sent.",
    "let is_running = controller.status() == Status::Running;",
    "let (angle, rate) = (controller.attitude().angle(), controller.attitude().rate());",
    "if !monitor.allows(is_running, angle, rate, wheel_speed(sample.wheel_adc), duty) {",
    "    controller.fault();",
    "}",
    "```",
    "",
    "A wheel that does not answer, a sign that is wrong or a motor that is stuck ends the motion that",
    "the model allows, before the body leans far.",
];

/// Emits `src/lib.rs`.
pub fn file(spec: &ModuleSpec, has_monitor: bool) -> EmittedFile {
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
    let (mut monitor_modules, mut monitor_use) = (quote!(), quote!());
    if has_monitor {
        lines.extend(MONITOR_EXAMPLE.iter().map(|line| (*line).to_owned()));
        monitor_modules = quote! {
            pub mod monitor;
            pub mod monitor_words;
            pub mod motion;
        };
        monitor_use = quote!(
            pub use monitor::Monitor;
        );
    }
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
        #monitor_modules
        pub mod pivot_angle;
        pub mod product;
        pub mod root;
        pub mod scaling;
        pub mod supervisor;

        pub use attitude::Attitude;
        pub use control::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed, control};
        pub use constants::{SAMPLE_TIME_US, ZERO_CURRENT};
        pub use controller::{Controller, Duty, Sample, duty, wheel_speed};
        #monitor_use
        pub use supervisor::Status;
    };
    EmittedFile {
        path: "src/lib.rs".to_owned(),
        contents: print(spec, tokens),
    }
}
