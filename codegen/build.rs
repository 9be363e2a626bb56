//! Which tests can run on this machine.

use std::env;
use std::path::{Path, PathBuf};

/// Tells cargo and the compiler whether there is such a program; it may be installed later.
fn declare(program: &str) {
    println!("cargo::rustc-check-cfg=cfg(have_{program})");
    println!("cargo::rerun-if-env-changed=PATH");
    let name = format!("{program}{}", env::consts::EXE_SUFFIX);
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = env::split_paths(&path).filter(|folder| folder.is_dir());
    let mut is_found = false;
    for folder in folders {
        println!("cargo::rerun-if-changed={}", folder.display());
        is_found |= folder.join(&name).is_file();
    }
    if is_found {
        println!("cargo::rustc-cfg=have_{program}");
    }
}

/// The folder of recordings from outside the project.
const RECORDINGS: &str = "FLYWHEEL_RECORDINGS";

/// Tells cargo and the compiler whether the recordings are at hand, and the tests where.
fn declare_recordings() {
    println!("cargo::rustc-check-cfg=cfg(have_recordings)");
    println!("cargo::rerun-if-env-changed={RECORDINGS}");
    let folder = env::var_os(RECORDINGS).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    println!("cargo::rustc-env={RECORDINGS}={}", folder.display());
    if folder.join("real").is_dir() {
        println!("cargo::rerun-if-changed={}", folder.display());
        println!("cargo::rustc-cfg=have_recordings");
    }
}

fn main() {
    declare("rustfmt");
    declare_recordings();
}
