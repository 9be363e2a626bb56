//! Turns a designed controller into a `no_std` fixed-point Rust crate.
//!
//! The data passes through three forms, one module each:
//!
//! 1. [`spec::ModuleSpec`]: real numbers, as identification and design found them.
//! 2. [`ir`]: formats, raw integers and error bounds. All of them are determined here, in exact
//!    arithmetic ([`exact`]), or refused ([`Refusal`]).
//! 3. [`emit`]: text. One small file for each output; `quote` builds tokens and `prettyplease`
//!    prints them. No number is computed in this form.
//!
//! Only [`mod@file`] accesses the disk. Helpers that are ordinary tested Rust without
//! numbers are in `codegen/runtime/`; [`runtime`] copies them into the output.
//!
//! ```no_run
//! # fn spec() -> codegen::spec::ModuleSpec { unimplemented!() }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let emitted = codegen::generate(&spec())?;
//! emitted.write(std::path::Path::new("generated"))?; // writes only what changed
//! emitted.check(std::path::Path::new("generated"))?; // compares instead
//! # Ok(())
//! # }
//! ```

pub mod attitude;
pub mod c99;
pub mod claims;
pub mod closed_loop;
pub mod control;
pub mod emit;
pub mod exact;
pub mod file;
pub mod format;
pub mod hardware;
pub mod hardware_words;
pub mod helpers;
pub mod ir;
pub mod refusal;
pub mod runtime;
pub mod runtime_parts;
pub mod spec;
pub mod stability;
pub mod supervisor;

pub use file::{EmittedCrate, EmittedFile, FileError};
pub use refusal::Refusal;
pub use spec::ModuleSpec;

/// Whether sensors or drive add states to the loop.
fn has_other_loop(spec: &ModuleSpec) -> bool {
    let wheel = &spec.hardware.wheel;
    spec.drive.voltage.is_some() || matches!(wheel, hardware::WheelSensor::Encoder(_))
}

/// Emits the crate for `spec`, or refuses with the claim that could not be kept.
///
/// The result depends on `spec` alone: the same numbers give the same bytes.
///
/// # Errors
/// A [`Refusal`] that names what is wrong and what would cure it.
pub fn generate(spec: &ModuleSpec) -> Result<EmittedCrate, Refusal> {
    spec.validate()?;
    let law = control::derive(spec)?;
    stability::require_stable(spec, &law)?;
    let hardware = hardware_words::derive(spec, &law)?;

    let mut files = vec![
        emit::cargo_toml::file(spec),
        emit::lib_rs::file(spec),
        emit::control_rs::file(spec, &law),
        emit::constants_rs::file(spec, &law, &hardware),
    ];
    files.extend(runtime::helpers(spec));
    let closed_loop = match &spec.closed_loop {
        Some(given) => Some(given.clone()),
        // The bound holds for `control` on the measured states and a current that flows as it is asked for. An observer
        // that changes the angle, an encoder's speed that is half a window old, and a voltage in place of the current
        // make other loops, for which it is not claimed.
        None if spec.hardware.bias_observer.is_some() || has_other_loop(spec) => None,
        None => closed_loop::certify(spec, &law),
    };
    files.push(emit::certificate::file(spec, &law, closed_loop, &files));
    Ok(EmittedCrate { files })
}
