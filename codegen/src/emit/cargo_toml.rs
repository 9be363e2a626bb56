//! `Cargo.toml` of the emitted crate, and that of its harness crate.
//!
//! The two manifests inherit nothing from a workspace, so that the crates build inside a workspace and alone.

use crate::crate_name::CrateName;
use crate::emit::header;
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// Emits `Cargo.toml`.
pub fn file(spec: &ModuleSpec, name: &CrateName) -> EmittedFile {
    let header = header(spec);
    let contents = format!(
        r#"# {header}.

[package]
name = "{name}"
version = "0.1.0"
edition = "2024"
description = "Fixed-point controller of a reaction-wheel pendulum"
license = "MIT OR Apache-2.0"
publish = false

[dependencies]
fixed = {{ version = "1.31", default-features = false }}

[lints.rust]
unsafe_code = "forbid"
missing_docs = "warn"
unexpected_cfgs = {{ level = "warn", check-cfg = ['cfg(kani)'] }}
"#
    );
    EmittedFile {
        path: "Cargo.toml".to_owned(),
        contents,
    }
}

/// Emits `verify/Cargo.toml`.
///
/// The harness crate is a workspace of its own. Otherwise Cargo would look for a workspace in the folders above and
/// require the crate to be its member. The harnesses call the emitted crate `generated`, whatever its name is.
pub fn harness_file(spec: &ModuleSpec, name: &CrateName) -> EmittedFile {
    let header = header(spec);
    let dependency = if *name == CrateName::default() {
        r#"{ path = ".." }"#.to_owned()
    } else {
        format!(r#"{{ package = "{name}", path = ".." }}"#)
    };
    let contents = format!(
        r#"# {header}.

[package]
name = "{name}-verify"
version = "0.1.0"
edition = "2024"
description = "Properties of the controller beside it, and their Kani proofs: run `cargo kani` here"
license = "MIT OR Apache-2.0"
publish = false

# Contracts of the primitives, and their use in place of the functions.
[package.metadata.kani.unstable]
function-contracts = true
stubbing = true

[dependencies]
generated = {dependency}

[lints.rust]
unsafe_code = "forbid"
missing_docs = "warn"
unexpected_cfgs = {{ level = "warn", check-cfg = ['cfg(kani)'] }}

[workspace]
"#
    );
    EmittedFile {
        path: "verify/Cargo.toml".to_owned(),
        contents,
    }
}
