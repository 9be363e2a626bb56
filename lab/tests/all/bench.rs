//! A small bench on the disk: one spin-up and one swing of the demonstration's, whose pivot has dry friction.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

const BENCH: &str = r#"
[bench]
name = "two logs"

[known]
torque_constant = 0.033
gravity_torque = 0.238383

[[experiment]]
name = "spin-up"
kind = "spin-up"
file = "spin-up-0.4A.csv"

[[experiment]]
name = "swing"
kind = "free-swing"
file = "free-swing-20deg.csv"
"#;

/// Writes the bench, with its text changed by `change`.
pub fn write(folder: &Path, change: impl Fn(&str) -> String) {
    fs::create_dir_all(folder).expect("a folder");
    fs::write(folder.join("bench.toml"), change(BENCH)).expect("bench.toml");
    for (name, text) in demo::FILES {
        if BENCH.contains(name) {
            fs::write(folder.join(name), text).expect("a log");
        }
    }
}

/// The bench in a folder of its own.
pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write(folder.path(), str::to_owned);
    folder
}
