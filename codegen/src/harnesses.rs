//! The harness crate of the emitted crate: the folder `verify` beside its `src`.
//!
//! It states properties of the emitted code as plain functions, and the Kani proofs that call them. `cargo kani` in
//! that folder runs the proofs; `flywheel prove` does so where Kani is installed. The harnesses are ordinary Rust in
//! `codegen/harnesses/`. They are copied unchanged, without the parts for sensors and drives that the bench does not
//! have ([`crate::runtime_parts`]). The numbers that differ between two benches are constants of the emitted crate, or
//! are in `verify/src/modes.rs`. The crate `verify` of this workspace is compiled from the harnesses that were emitted
//! for `generated`, so that its tests run the same texts.

use crate::crate_name::CrateName;
use crate::emit::{cargo_toml, modes_rs, with_header};
use crate::file::EmittedFile;
use crate::modes::Modes;
use crate::runtime_parts::{Parts, PartsError, WheelPart};
use crate::spec::ModuleSpec;

/// A file of `codegen/harnesses/`.
struct Harness {
    /// Its path inside the emitted crate.
    path: &'static str,
    /// Its text.
    source: &'static str,
    /// Whether a module with these parts has it.
    is_part_of: fn(&Parts) -> bool,
}

/// The harness at this path, where the bench has what it speaks of; its text stands in a file of the same name, or of
/// another one.
macro_rules! harness {
    ($path:literal) => {
        harness!($path, |_| true)
    };
    ($path:literal, $is_part_of:expr) => {
        harness!($path, $path, $is_part_of)
    };
    ($path:literal, $file:literal, $is_part_of:expr) => {
        Harness {
            path: concat!("verify/src/", $path),
            source: include_str!(concat!("../harnesses/", $file)),
            is_part_of: $is_part_of,
        }
    };
}

/// Whether gyroscope and accelerometer show the body.
const IS_INERTIAL: fn(&Parts) -> bool = |parts| !parts.has_body_encoder;

/// Whether an encoder shows the body.
const HAS_BODY_ENCODER: fn(&Parts) -> bool = |parts| parts.has_body_encoder;

/// Whether there is an encoder.
const HAS_ENCODER: fn(&Parts) -> bool =
    |parts| parts.has_body_encoder || parts.wheel == WheelPart::Encoder;

/// Every source of the harness crate.
const HARNESSES: [Harness; 20] = [
    harness!("lib.rs"),
    harness!("proofs.rs"),
    harness!("proofs_attitude.rs", IS_INERTIAL),
    harness!("proofs_encoder.rs", HAS_ENCODER),
    harness!("proofs_lines.rs"),
    harness!("proofs_modes.rs", has_modes),
    harness!("proofs_product.rs"),
    harness!("proofs_step.rs", IS_INERTIAL),
    harness!("proofs_step.rs", "body_proofs_step.rs", HAS_BODY_ENCODER),
    harness!("proofs_supervisor.rs", IS_INERTIAL),
    harness!(
        "proofs_supervisor.rs",
        "body_proofs_supervisor.rs",
        HAS_BODY_ENCODER
    ),
    harness!("words.rs"),
    harness!("properties/mod.rs"),
    harness!("properties/attitude.rs", IS_INERTIAL),
    harness!("properties/control.rs"),
    harness!("properties/encoder.rs", HAS_ENCODER),
    harness!("properties/modes.rs", has_modes),
    harness!("properties/step.rs"),
    harness!("properties/supervisor.rs", IS_INERTIAL),
    harness!(
        "properties/supervisor.rs",
        "properties/body_supervisor.rs",
        HAS_BODY_ENCODER
    ),
];

impl Harness {
    /// The text that a bench with these parts has.
    fn text(&self, parts: &Parts) -> Result<String, PartsError> {
        parts.of_text(self.source)
    }
}

/// The harnesses of a module with these parts.
fn of_parts(parts: &Parts) -> impl Iterator<Item = &'static Harness> {
    HARNESSES
        .iter()
        .filter(move |harness| (harness.is_part_of)(parts))
}

/// Whether the harness crate speaks of the loop's modes: of a held current and the states themselves, not of a voltage or of
/// the turn over an encoder's window.
pub fn has_modes(parts: &Parts) -> bool {
    !HAS_ENCODER(parts) && !parts.has_voltage_drive
}

/// The harness crate for `spec` and the modes of its loop: manifest and sources.
pub fn files(spec: &ModuleSpec, name: &CrateName, modes: Option<&Modes>) -> Vec<EmittedFile> {
    let parts = spec.parts();
    let own_modes = has_modes(&parts).then(|| modes_rs::file(spec, modes));
    let sources = of_parts(&parts).map(|harness| EmittedFile {
        path: harness.path.to_owned(),
        contents: with_header(
            spec,
            &harness
                .text(&parts)
                .expect("every harness parses; a test of this module says so"),
        ),
    });
    [cargo_toml::harness_file(spec, name)]
        .into_iter()
        .chain(own_modes)
        .chain(sources)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_harness_parses_for_every_bench() {
        for parts in Parts::all() {
            let mut paths: Vec<&str> = Vec::new();
            for harness in of_parts(&parts) {
                let text = harness.text(&parts).unwrap();
                // What is left are conditions on Kani.
                let conditions = text.matches("#[cfg(").count();
                assert_eq!(
                    conditions,
                    text.matches("#[cfg(kani)]").count(),
                    "{parts:?}"
                );
                syn::parse_file(&text).unwrap();
                paths.push(harness.path);
            }
            let count = paths.len();
            paths.sort_unstable();
            paths.dedup();
            assert_eq!(paths.len(), count, "{parts:?}");
        }
    }
}
