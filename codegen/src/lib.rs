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
//! numbers are in `codegen/runtime/`; [`runtime`] copies them into the output. [`harnesses`] does so for the
//! Kani proofs, which become a crate of their own beside it.
//!
//! ```
//! fn emit(spec: &codegen::ModuleSpec, folder: &std::path::Path) -> Result<(), Box<dyn std::error::Error>> {
//!     let emitted = codegen::generate(spec)?;
//!     emitted.write(folder)?; // writes only what changed
//!     emitted.check(folder)?; // compares instead
//!     Ok(())
//! }
//! ```

pub mod attitude;
pub mod c99;
pub mod claims;
pub mod closed_loop;
pub mod control;
pub mod crate_name;
pub mod emit;
pub mod exact;
pub mod file;
pub mod format;
pub mod hardware;
pub mod hardware_words;
pub mod harnesses;
pub mod held_voltage;
pub mod helpers;
pub mod ir;
pub mod modes;
pub mod monitor;
pub mod refusal;
pub mod runtime;
pub mod runtime_parts;
pub mod spec;
pub mod stability;
pub mod supervisor;

pub use crate_name::CrateName;
pub use file::{EmittedCrate, EmittedFile, FileError};
pub use monitor::MonitorSpec;
pub use refusal::Refusal;
pub use spec::ModuleSpec;

/// The options of an emitted module, in addition to its numbers.
#[derive(Debug, Clone, Default)]
pub struct EmissionOptions {
    /// Name of the crate, or of the library in C.
    pub name: CrateName,
    /// The noise at which the monitor must stay silent; `None` for a module without a monitor. A monitor is a function
    /// that says whether the model allows the measured motion.
    pub monitor: Option<MonitorSpec>,
}

/// Emits the crate for `spec` under its usual name and without a monitor.
///
/// # Errors
/// A [`Refusal`] that names what is wrong and what would cure it.
pub fn generate(spec: &ModuleSpec) -> Result<EmittedCrate, Refusal> {
    generate_with(spec, &EmissionOptions::default())
}

/// Emits the crate for `spec`, or refuses with the claim that could not be kept.
///
/// The result depends only on `spec` and `options`: the same numbers give the same bytes.
///
/// # Errors
/// A [`Refusal`] that names what is wrong and what would cure it; [`Refusal::Monitor`] if no bound of the model's
/// motion is known.
pub fn generate_with(
    spec: &ModuleSpec,
    options: &EmissionOptions,
) -> Result<EmittedCrate, Refusal> {
    let EmissionOptions { name, monitor } = options;
    let monitor = monitor.as_ref();
    spec.validate()?;
    let law = control::derive(spec)?;
    stability::require_stable(spec, &law)?;
    let hardware = hardware_words::derive(spec, &law)?;

    let mut files = vec![
        emit::cargo_toml::file(spec, name),
        emit::lib_rs::file(spec, name, monitor.is_some()),
        emit::control_rs::file(spec, &law),
        emit::constants_rs::file(spec, &law, &hardware),
    ];
    files.extend(runtime::emitted(runtime::of_parts(&spec.parts()), spec));
    let numbers = monitor
        .map(|told| monitor::derive(spec, &law, told))
        .transpose()?;
    if let Some(numbers) = &numbers {
        files.push(emit::monitor_rs::file(spec, numbers));
        files.extend(runtime::emitted(runtime::MONITOR_HELPERS.iter(), spec));
    }
    let closed_loop = match &spec.closed_loop {
        Some(given) => Some(given.clone()),
        // The bound holds for `control` on the measured states. An observer that changes the angle makes another loop,
        // and so does an encoder on the pivot, whose window has states of its own. The bound is not claimed for them.
        None if spec.hardware.bias_observer.is_some() || spec.hardware.body_encoder().is_some() => {
            None
        }
        None => closed_loop::certify(spec, &law),
    };
    // The claim about the modes is checked with the harnesses.
    let modes = match harnesses::has_modes(&spec.parts()) {
        true => modes::derive(spec, &law),
        false => None,
    };
    let found = emit::certificate::Found {
        monitor: monitor.zip(numbers.as_ref()),
        modes: modes.as_ref(),
        closed_loop,
    };
    let certificate = emit::certificate::file(spec, &law, found, &files);
    // The certificate lists none of the following files. The README states nothing, the harnesses are compared with
    // audited texts, and the claim `closed-loop-agreement` reads the words of the modes.
    files.extend(harnesses::files(spec, name, modes.as_ref()));
    files.extend([emit::readme::file(spec, name), certificate]);
    Ok(EmittedCrate { files })
}
