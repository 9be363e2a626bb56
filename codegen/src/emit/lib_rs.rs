//! `src/lib.rs` of the emitted crate: the list of its modules.

use quote::quote;

use crate::emit::{inner_docs, print, single_line};
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// Emits `src/lib.rs`.
pub fn file(spec: &ModuleSpec) -> EmittedFile {
    let docs = inner_docs(&[
        "Fixed-point controller of a reaction-wheel pendulum.",
        "",
        &format!(
            "Emitted from the model `{}`. It needs no floating point, no heap and nothing but `core`",
            single_line(&spec.model_name)
        ),
        "and `fixed`; no input of whatever value makes it panic. `certificate.json` beside this",
        "crate states everything that is claimed of it, so that it can be checked without the",
        "generator.",
    ]);
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
        pub mod filter;
        pub mod lever_arm;
        pub mod line;
        pub mod madgwick;
        pub mod pivot_angle;
        pub mod product;
        pub mod root;
        pub mod scaling;

        pub use attitude::Attitude;
        pub use control::{Angle, CURRENT_LIMIT, Current, Rate, WheelSpeed, control};
        pub use controller::{Controller, Duty, Sample, duty, wheel_speed};
    };
    EmittedFile {
        path: "src/lib.rs".to_owned(),
        contents: print(spec, tokens),
    }
}
