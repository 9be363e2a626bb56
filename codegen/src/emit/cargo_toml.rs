//! `Cargo.toml` of the emitted crate.
//!
//! It inherits nothing, so that the crate builds inside a workspace and alone.

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
