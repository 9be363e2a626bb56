//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::quote;

use crate::crate_name::CrateName;
use crate::emit::{example, inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// Emits `src/lib.rs`.
pub fn file(spec: &ModuleSpec, name: &CrateName) -> EmittedFile {
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
