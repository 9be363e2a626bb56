//! Some tests need a tool or data that not every machine has, such as a solver, or recordings that are no part of the
//! project. The attribute of such a test names the condition, so that cargo's own summary counts the test as ignored
//! and gives the reason:
//!
//! ```text
//! #[test]
//! #[cfg_attr(not(have_z3), ignore = "needs z3")]
//! fn z3_agrees() { … }
//! ```
//!
//! The crate's build script finds out what is there:
//!
//! ```no_run
//! // build.rs
//! # use test_conditions::Condition;
//! test_conditions::declare(&[Condition::Z3]);
//! ```
//!
//! The reason is "needs z3", "needs rustfmt", "needs chromium", "needs the recordings", "needs gcc" or "needs the
//! cross compilers": `.ci/run` looks for these words
//! and fails where a test was ignored for something that the machine has.

use std::env;
use std::path::{Path, PathBuf};

/// Environment variable that names the folder of the recordings, by an absolute path.
pub const RECORDINGS: &str = "FLYWHEEL_RECORDINGS";

/// Something that a test may need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The solver z3 on the path of programs: `have_z3`.
    Z3,
    /// The formatter of Rust on the path of programs: `have_rustfmt`.
    Rustfmt,
    /// The browser chromium and its chromedriver on the path of programs: `have_chromium`.
    Chromium,
    /// Recordings of real rigs (`real/`) and the benches of an independent simulator (`hidden/`), in the
    /// folder that [`RECORDINGS`] names or else in `../shared/data` beside the project:
    /// `have_recordings`. Tests read the folder from `env!("FLYWHEEL_RECORDINGS")`.
    Recordings,
    /// The C compiler `gcc` on the path of programs: `have_gcc`.
    Gcc,
    /// The C compilers for AVR, ARM, RISC-V and Xtensa that Debian has, all of them: `have_cross_gcc`.
    CrossGcc,
}

/// The compilers of [`Condition::CrossGcc`].
const CROSS_GCC: [&str; 4] = [
    "avr-gcc",
    "arm-none-eabi-gcc",
    "riscv64-unknown-elf-gcc",
    "xtensa-lx106-elf-gcc",
];

impl Condition {
    /// The flag for `#[cfg]`.
    pub fn flag(self) -> &'static str {
        match self {
            Condition::Z3 => "have_z3",
            Condition::Rustfmt => "have_rustfmt",
            Condition::Chromium => "have_chromium",
            Condition::Recordings => "have_recordings",
            Condition::Gcc => "have_gcc",
            Condition::CrossGcc => "have_cross_gcc",
        }
    }
}

/// Tells cargo which of these conditions hold, and when to look again. To be called by build scripts.
///
/// Where the recordings are absent, only a change of [`RECORDINGS`] makes cargo look again. If cargo waited for the
/// missing folder, it would build the crate anew every time.
pub fn declare(conditions: &[Condition]) {
    for &condition in conditions {
        let flag = condition.flag();
        println!("cargo::rustc-check-cfg=cfg({flag})");
        let holds = match condition {
            Condition::Z3 => watch_program("z3"),
            Condition::Rustfmt => watch_program("rustfmt"),
            // Both programs are always looked for, because cargo must look again when either of them appears.
            Condition::Chromium => ["chromium", "chromedriver"].map(watch_program) == [true, true],
            Condition::Recordings => watch_recordings(),
            Condition::Gcc => watch_program("gcc"),
            Condition::CrossGcc => CROSS_GCC.map(watch_program) == [true; 4],
        };
        if holds {
            println!("cargo::rustc-cfg={flag}");
        }
    }
}

/// Whether the program exists. Cargo looks again when the program changes or, if it does not exist, when something is
/// installed.
fn watch_program(name: &str) -> bool {
    println!("cargo::rerun-if-env-changed=PATH");
    let path = env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = env::split_paths(&path).collect();
    match program(name, &folders) {
        Some(file) => {
            println!("cargo::rerun-if-changed={}", file.display());
            true
        }
        None => {
            for folder in folders.iter().filter(|folder| folder.is_dir()) {
                println!("cargo::rerun-if-changed={}", folder.display());
            }
            false
        }
    }
}

/// The first of these folders' files with this name.
fn program(name: &str, folders: &[PathBuf]) -> Option<PathBuf> {
    let name = format!("{name}{}", env::consts::EXE_SUFFIX);
    let files = folders.iter().map(|folder| folder.join(&name));
    files.into_iter().find(|file| file.is_file())
}

/// Whether the recordings exist. Tests receive their folder in an environment variable.
fn watch_recordings() -> bool {
    println!("cargo::rerun-if-env-changed={RECORDINGS}");
    let folder = env::var_os(RECORDINGS).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    println!("cargo::rustc-env={RECORDINGS}={}", folder.display());
    let holds = ["real", "hidden"].map(|part| folder.join(part).is_dir()) == [true, true];
    if holds {
        println!("cargo::rerun-if-changed={}", folder.display());
    }
    holds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_is_found_in_the_folders_that_are_searched() {
        let own = env::current_exe().expect("the test's own file");
        let folder = own.parent().expect("a folder").to_path_buf();
        let name = own.file_stem().and_then(|name| name.to_str());
        let name = name.expect("a name in UTF-8");
        let elsewhere = folder.join("no-such-folder");
        let found = program(name, &[elsewhere.clone(), folder]);
        assert_eq!(found.as_ref(), Some(&own));
        assert_eq!(program(name, &[elsewhere]), None);
    }
}
