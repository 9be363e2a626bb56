//! Copies hand-written helpers into the output.
//!
//! A helper is an ordinary Rust file in `codegen/runtime/`. It is compiled in [`crate::helpers`],
//! so that `codegen/tests/` can test it. Its text is copied with comments and layout unchanged,
//! but without its `#[cfg(test)]` items and without what the bench does not have
//! ([`crate::runtime_parts`]). To add one, append it to [`HELPERS`] and to [`crate::helpers`].

use crate::emit;
use crate::file::EmittedFile;
use crate::runtime_parts::{Parts, PartsError, WheelPart};
use crate::spec::ModuleSpec;

/// A hand-written file and its place in the emitted crate.
#[derive(Debug, Clone, Copy)]
pub struct Helper {
    /// Name of its module in the emitted crate.
    pub module: &'static str,
    /// Path inside the emitted crate.
    pub path: &'static str,
    /// Text of the file in `codegen/runtime/`.
    pub source: &'static str,
    /// Whether a module with these parts has it.
    pub is_part_of: fn(&Parts) -> bool,
}

/// The helper in a file of `codegen/runtime/`, as a module of this name, where the bench has this.
macro_rules! helper {
    ($module:literal) => {
        helper!($module, |_| true)
    };
    ($module:literal, $is_part_of:expr) => {
        helper!($module, $module, $is_part_of)
    };
    ($module:literal, $file:literal, $is_part_of:expr) => {
        Helper {
            module: $module,
            path: concat!("src/", $module, ".rs"),
            source: include_str!(concat!("../runtime/", $file, ".rs")),
            is_part_of: $is_part_of,
        }
    };
}

/// Whether gyroscope and accelerometer show the body.
const IS_INERTIAL: fn(&Parts) -> bool = |parts| !parts.has_body_encoder;

/// Whether an encoder shows the body.
const HAS_BODY_ENCODER: fn(&Parts) -> bool = |parts| parts.has_body_encoder;

impl Helper {
    /// The file as it is emitted: header, then the text that the bench has.
    ///
    /// # Errors
    /// [`PartsError`]; a test of this crate excludes it for every helper and every bench.
    pub fn file(&self, spec: &ModuleSpec, parts: &Parts) -> Result<EmittedFile, PartsError> {
        Ok(EmittedFile {
            path: self.path.to_owned(),
            contents: emit::with_header(spec, &parts.of_text(self.source)?),
        })
    }
}

/// Every helper that a module needs without a monitor, by the name of its module.
pub const HELPERS: [Helper; 19] = [
    helper!("arc_tangent", IS_INERTIAL),
    helper!("attitude", IS_INERTIAL),
    helper!("bias_observer", IS_INERTIAL),
    helper!("body", HAS_BODY_ENCODER),
    helper!("calibration", IS_INERTIAL),
    helper!("controller"),
    helper!("drift", IS_INERTIAL),
    helper!("encoder", |parts| parts.has_body_encoder
        || parts.wheel == WheelPart::Encoder),
    helper!("filter", IS_INERTIAL),
    helper!("lever_arm", IS_INERTIAL),
    helper!("line"),
    helper!("madgwick", IS_INERTIAL),
    helper!("pivot_angle", IS_INERTIAL),
    helper!("plane", |parts| parts.has_voltage_drive),
    helper!("product"),
    helper!("root", IS_INERTIAL),
    helper!("scaling", IS_INERTIAL),
    helper!("supervisor", IS_INERTIAL),
    helper!("supervisor", "body_supervisor", HAS_BODY_ENCODER),
];

/// The helpers of a monitor, beside [`HELPERS`].
pub const MONITOR_HELPERS: [Helper; 2] = [helper!("monitor"), helper!("motion")];

/// The helpers of a module with these parts.
pub fn of_parts(parts: &Parts) -> impl Iterator<Item = &'static Helper> {
    HELPERS
        .iter()
        .filter(move |helper| (helper.is_part_of)(parts))
}

/// Helpers as they are emitted for `spec`.
pub fn emitted<'a>(
    helpers: impl Iterator<Item = &'a Helper>,
    spec: &ModuleSpec,
) -> Vec<EmittedFile> {
    let parts = spec.parts();
    helpers
        .map(|helper| {
            helper
                .file(spec, &parts)
                .expect("every helper parses; a test of this module says so")
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_helper_parses_for_every_bench() {
        for parts in Parts::all() {
            let mut modules: Vec<&str> = Vec::new();
            for helper in of_parts(&parts) {
                let text = parts.of_text(helper.source).unwrap();
                assert!(!text.contains("#[cfg("), "{}: {parts:?}", helper.path);
                syn::parse_file(&text).unwrap();
                modules.push(helper.module);
            }
            assert!(modules.is_sorted_by(|a, b| a < b), "{modules:?}");
        }
    }
}
