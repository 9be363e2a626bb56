//! Cargo in a folder of the checker's own, where the surroundings have no influence.
//!
//! The environment is cleared except for the paths of the tools, the build is offline, and the folders above are
//! checked for a `.cargo` or toolchain file.

use std::path::Path;
use std::process::{Command, Stdio};

/// The environment variables that Cargo, rustc and Kani need: their paths, and the user's folder of crates.
const KEPT: [&str; 13] = [
    "PATH",
    "HOME",
    "USERPROFILE",
    "CARGO_HOME",
    "KANI_HOME",
    "RUSTUP_HOME",
    "RUSTUP_TOOLCHAIN",
    "SYSTEMROOT",
    "TMPDIR",
    "TEMP",
    "TMP",
    "LD_LIBRARY_PATH",
    "DYLD_LIBRARY_PATH",
];

/// A file in a folder above that would influence Cargo or rustup.
pub(crate) fn in_the_way(folder: &Path) -> Option<String> {
    let own = std::env::var_os("CARGO_HOME")
        .map(std::path::PathBuf::from)
        .or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    let names = [".cargo", "rust-toolchain", "rust-toolchain.toml"];
    folder
        .ancestors()
        .flat_map(|above| names.map(|name| above.join(name)))
        .find(|path| path.exists() && own.as_ref() != Some(path))
        .map(|path| path.display().to_string())
}

/// Cargo in `root`, offline, with the tools' environment only.
pub(crate) fn cargo(root: &Path) -> Command {
    let mut command = Command::new("cargo");
    command.env_clear().current_dir(root).stdin(Stdio::null());
    command.env("CARGO_NET_OFFLINE", "true");
    for name in KEPT {
        if let Some(value) = std::env::var_os(name) {
            command.env(name, value);
        }
    }
    command
}
