//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::quote;

use crate::crate_name::CrateName;
use crate::emit::{example, inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// What a firmware with a monitor adds after each step; `CRATE` is the name of the crate.
const MONITOR_EXAMPLE: [&str; 19] = [
    "",
    "# Monitor",
    "",
    "```",
    "use CRATE::{Controller, Monitor, Sample, Status, wheel_speed};",
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
pub fn file(spec: &ModuleSpec, name: &CrateName, has_monitor: bool) -> EmittedFile {
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
    lines.extend(["", "# Use", "", "```"].map(str::to_owned));
    lines.extend(example::lines(name));
    let closing = "`status()` says why there is no current; a trip lasts until `arm()` succeeds.";
    lines.extend(["```", "", closing].map(str::to_owned));
    let (mut monitor_modules, mut monitor_use) = (quote!(), quote!());
    if has_monitor {
        lines.extend(
            MONITOR_EXAMPLE
                .iter()
                .map(|line| line.replace("CRATE", &name.in_rust())),
        );
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
