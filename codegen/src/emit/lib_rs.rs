//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::{format_ident, quote};

use crate::emit::{inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::runtime;
use crate::runtime_parts::{Parts, WheelPart};
use crate::spec::ModuleSpec;

/// How a firmware uses the crate; compiled and run as a test of its documentation.
fn example(parts: &Parts) -> Vec<String> {
    let wheel = match parts.wheel {
        WheelPart::Converter => "wheel_adc: 0",
        WheelPart::Driver => "wheel_speed: 0",
        WheelPart::Encoder => "wheel_count: 0",
    };
    let sample =
        format!("let sample = Sample {{ gyro: [0; 3], accel: [0; 3], mag: None, {wheel} }};");
    let lines = [
        "",
        "# Use",
        "",
        "```",
        "use generated::{Controller, Sample, Status, ZERO_CURRENT};",
        "",
        "let mut controller = Controller::new();",
        "// Every SAMPLE_TIME_US: read the sensors, step, write the duty.",
        &sample,
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
    lines.map(str::to_owned).to_vec()
}

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
    let parts = spec.parts();
    lines.extend(example(&parts));
    let mut modules: Vec<_> = runtime::of_parts(&parts)
        .map(|helper| helper.module)
        .chain(["constants", "control"])
        .collect();
    modules.sort_unstable();
    let modules = modules.iter().map(|name| format_ident!("{name}"));
    let docs = inner_docs(&lines);
    let tokens = quote! {
        #docs
        #![no_std]
        #![forbid(unsafe_code)]
        #![warn(missing_docs)]

        #(pub mod #modules;)*

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
