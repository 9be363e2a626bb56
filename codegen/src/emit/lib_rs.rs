//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::{format_ident, quote};

use crate::crate_name::CrateName;
use crate::emit::{example, inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::runtime;
use crate::runtime_parts::{Parts, WheelPart};
use crate::spec::ModuleSpec;

/// The lines that a firmware with a monitor adds after each step; `CRATE` stands for the name of the crate, `WHEEL` for
/// the field of the wheel's sensor, `SPEED` for what the wheel's speed follows from.
const MONITOR_EXAMPLE: [&str; 19] = [
    "",
    "# Monitor",
    "",
    "```",
    "use CRATE::{Controller, Monitor, Sample, Status, wheel_speed};",
    "",
    "let (mut controller, mut monitor) = (Controller::new(), Monitor::new());",
    "let sample = Sample { gyro: [0; 3], accel: [0; 3], mag: None, WHEEL: 0 };",
    "let duty = controller.step(&sample);",
    "// Whether wheel and body move as the model predicts for the duties that were sent.",
    "let is_running = controller.status() == Status::Running;",
    "let (angle, rate) = (controller.attitude().angle(), controller.attitude().rate());",
    "if !monitor.allows(is_running, angle, rate, wheel_speed(SPEED), duty) {",
    "    controller.fault();",
    "}",
    "```",
    "",
    "The monitor notices a wheel that does not respond, a wrong sign or a motor that is stuck before the",
    "body leans far.",
];

/// The lines that an encoder at the wheel needs before the monitor is asked.
const ENCODER_EXAMPLE: [&str; 3] = [
    "// The turns of the wheel, counted for the monitor too.",
    "let mut wheel = CRATE::encoder::Encoder::new();",
    "wheel.update(sample.wheel_count, &CRATE::constants::WHEEL_ENCODER);",
];

/// The lines of the monitor's example.
fn monitor_lines(name: &CrateName, parts: &Parts) -> Vec<String> {
    let (wheel, speed) = (
        example::wheel_field(parts),
        "wheel.turned(&CRATE::constants::WHEEL_ENCODER)",
    );
    let has_encoder = parts.wheel == WheelPart::Encoder;
    let speed = if has_encoder { speed } else { "sample.WHEEL" };
    let mut lines = vec![];
    for line in MONITOR_EXAMPLE {
        if has_encoder && line.starts_with("// Whether wheel") {
            lines.extend(ENCODER_EXAMPLE);
        }
        lines.push(line);
    }
    let own = |line: &str| {
        line.replace("SPEED", speed)
            .replace("CRATE", &name.in_rust())
            .replace("WHEEL:", &format!("{wheel}:"))
            .replace("sample.WHEEL", &format!("sample.{wheel}"))
    };
    lines.into_iter().map(own).collect()
}

/// Emits `src/lib.rs`.
pub fn file(spec: &ModuleSpec, name: &CrateName, has_monitor: bool) -> EmittedFile {
    let mut lines = vec![
        "Fixed-point controller of a reaction-wheel pendulum.".to_owned(),
        String::new(),
        format!(
            "Emitted from the model `{}`. It needs no floating point, no heap and nothing but `core`",
            single_line(&spec.model_name)
        ),
        "and `fixed`, and it panics for no input. `certificate.json` beside this crate states every claim"
            .to_owned(),
        "about it, so that the claims can be checked without the generator.".to_owned(),
        String::new(),
        "A *word* is an integer that stands for a quantity: its value times a power of two. \"In Q28\""
            .to_owned(),
        "means times 2²⁸.".to_owned(),
        String::new(),
        "# Sensors and drive".to_owned(),
    ];
    let list = |lines: &mut Vec<String>, sentences: &[String]| {
        let items = sentences.iter();
        lines.extend(items.map(|text| format!("- {}", single_line(text))));
    };
    list(&mut lines, &spec.hardware.registers);
    if !spec.assumed.is_empty() {
        lines.push(String::new());
        lines.push("# Assumed".to_owned());
        lines.push(
            "The model does not state these values. They are the values of another bench:"
                .to_owned(),
        );
        list(&mut lines, &spec.assumed);
    }
    lines.extend(["", "# Use", "", "```"].map(str::to_owned));
    let parts = spec.parts();
    lines.extend(example::lines(name, &parts));
    let closing = "`status()` says why there is no current. A trip lasts until `arm()` succeeds.";
    lines.extend(["```", "", closing].map(str::to_owned));
    let mut monitor_use = quote!();
    if has_monitor {
        lines.extend(monitor_lines(name, &parts));
        monitor_use = quote!(
            pub use monitor::Monitor;
        );
    }
    let mut helpers: Vec<_> = runtime::of_parts(&parts)
        .map(|helper| helper.module)
        .collect();
    if has_monitor {
        helpers.extend(runtime::MONITOR_HELPERS.map(|helper| helper.module));
        helpers.push("monitor_words");
    }
    helpers.extend(["constants", "control"]);
    helpers.sort_unstable();
    let body_use = match parts.has_body_encoder {
        true => quote!(
            pub use body::{body_angle, body_rate};
        ),
        false => quote!(
            pub use attitude::Attitude;
        ),
    };
    let modules = helpers.iter().map(|name| format_ident!("{name}"));
    let docs = inner_docs(&lines);
    let tokens = quote! {
        #docs
        #![no_std]
        #![forbid(unsafe_code)]
        #![warn(missing_docs)]

        #(pub mod #modules;)*

        #body_use
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
