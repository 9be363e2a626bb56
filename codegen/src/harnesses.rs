//! The harness crate of the emitted crate: the folder `verify` beside its `src`.
//!
//! It states properties of the emitted code as plain functions, and the Kani proofs that call them. `cargo kani` in
//! that folder runs the proofs; `flywheel prove` does so where Kani is installed. The harnesses are ordinary Rust in
//! `codegen/harnesses/`. They are copied unchanged; the numbers that differ between two benches are constants of the
//! emitted crate, or are in `verify/src/modes.rs`. The crate `verify` of this workspace is compiled from the harnesses
//! that were emitted for `generated`, so that its tests run the same texts.

use crate::crate_name::CrateName;
use crate::emit::{cargo_toml, modes_rs, with_header};
use crate::file::EmittedFile;
use crate::modes::Modes;
use crate::runtime_parts::WheelPart;
use crate::spec::ModuleSpec;

/// A file of `codegen/harnesses/`: its path inside the emitted crate, and its text.
macro_rules! harness {
    ($name:literal) => {
        (
            concat!("verify/src/", $name),
            include_str!(concat!("../harnesses/", $name)),
        )
    };
}

/// Every source of the harness crate.
const HARNESSES: [(&str, &str); 11] = [
    harness!("lib.rs"),
    harness!("proofs.rs"),
    harness!("proofs_attitude.rs"),
    harness!("proofs_modes.rs"),
    harness!("proofs_step.rs"),
    harness!("proofs_supervisor.rs"),
    harness!("properties/mod.rs"),
    harness!("properties/attitude.rs"),
    harness!("properties/control.rs"),
    harness!("properties/modes.rs"),
    harness!("properties/supervisor.rs"),
];

/// Whether a module for `spec` has a harness crate. The harnesses support inertial sensors, a converter's counts and a
/// current drive only.
pub fn exist_for(spec: &ModuleSpec) -> bool {
    let parts = spec.parts();
    !parts.has_body_encoder && parts.wheel == WheelPart::Converter && !parts.has_voltage_drive
}

/// The harness crate for `spec` and the modes of its loop: manifest and sources. The list is empty if no harness
/// supports the sensors or the drive.
pub fn files(spec: &ModuleSpec, name: &CrateName, modes: Option<&Modes>) -> Vec<EmittedFile> {
    if !exist_for(spec) {
        return Vec::new();
    }
    let sources = HARNESSES.iter().map(|(path, text)| EmittedFile {
        path: (*path).to_owned(),
        contents: with_header(spec, text),
    });
    [
        cargo_toml::harness_file(spec, name),
        modes_rs::file(spec, modes),
    ]
    .into_iter()
    .chain(sources)
    .collect()
}
