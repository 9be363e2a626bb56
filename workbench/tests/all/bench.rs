//! A small bench: one spin-up and one swing of the demonstration's, whose pivot has dry friction.

use workbench::{FilesInMemory, Progress, Session};

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

/// Its files.
pub fn files() -> Vec<(&'static str, &'static str)> {
    let mut files = vec![("bench.toml", BENCH)];
    files.extend(
        demo::FILES
            .into_iter()
            .filter(|(name, _)| ["spin-up-0.4A.csv", "free-swing-20deg.csv"].contains(name)),
    );
    files
}

/// A session on it in memory.
pub fn session() -> Session {
    let files: FilesInMemory = files().into_iter().collect();
    Session::from_files(&files).expect("a bench")
}

/// Progress that is not shown and never cancels.
pub fn silent() -> Progress<'static> {
    Progress::silent()
}
