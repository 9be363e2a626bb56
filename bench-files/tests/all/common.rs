//! Folders of files for the tests.

use std::fs;
use std::path::{Path, PathBuf};

/// A folder that vanishes with its owner.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Folder {
        Folder(tempfile::tempdir().expect("temporary folder"))
    }

    /// A bench with one log.
    pub fn bench(toml: &str, log: &str) -> Folder {
        let folder = Folder::new();
        folder.write("bench.toml", toml.as_bytes());
        folder.write("log.csv", log.as_bytes());
        folder
    }

    pub fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        fs::write(&path, bytes).expect("write test file");
        path
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

/// bench.toml with one experiment of this kind; `more` goes below it.
pub fn one(kind: &str, more: &str) -> String {
    format!("[[experiment]]\nname = \"one\"\nkind = \"{kind}\"\nfile = \"log.csv\"\n{more}\n")
}

/// A CSV with this header and the rows that `row` gives.
pub fn csv(header: &str, rows: usize, row: impl Fn(usize) -> String) -> String {
    let mut text = format!("{header}\n");
    for i in 0..rows {
        text.push_str(&row(i));
        text.push('\n');
    }
    text
}

/// A file of the recordings that are no part of the project; only for tests that need them.
pub fn recordings(path: &str) -> PathBuf {
    Path::new(env!("FLYWHEEL_RECORDINGS")).join(path)
}
