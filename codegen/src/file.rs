//! The only place that touches the disk: writes emitted files, or compares them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::emit::MARK;

/// An emitted crate, still in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmittedCrate {
    /// Its files, `certificate.json` last.
    pub files: Vec<EmittedFile>,
}

/// One emitted file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmittedFile {
    /// Path inside the crate, with `/`.
    pub path: String,
    /// The whole text.
    pub contents: String,
}

/// Why emitted files could not be written, or are not what would be written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The operating system said no.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// A file stands there that this program did not write.
    #[error(
        "{} was not written by flywheel (no `{MARK}` in it) and is left alone; choose another folder or move the file away",
        path.display()
    )]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// The files on disk are not what the generator emits.
    #[error(
        "not what the generator emits: {}; run `flywheel generate` again without --check",
        list(paths)
    )]
    Differs {
        /// Files that are missing or differ.
        paths: Vec<PathBuf>,
    },
}

fn list(paths: &[PathBuf]) -> String {
    let names: Vec<_> = paths
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    names.join(", ")
}

impl EmittedCrate {
    /// The text of one file, by its path inside the crate.
    pub fn file(&self, path: &str) -> Option<&str> {
        let file = self.files.iter().find(|file| file.path == path)?;
        Some(&file.contents)
    }

    /// Writes the crate into `directory` (made if missing) and returns the files that changed.
    ///
    /// Files that are right already are not touched. All new texts are first written beside their
    /// places; only when every one of them is on the disk are they renamed. So a file that is not
    /// ours, a missing permission or a full disk leaves everything as it was.
    ///
    /// # Errors
    /// [`FileError::Foreign`] if a file in the way is not ours, [`FileError::Io`] otherwise.
    pub fn write(&self, directory: &Path) -> Result<Vec<PathBuf>, FileError> {
        let mut changes = Vec::new();
        for file in &self.files {
            let path = directory.join(&file.path);
            match read(&path)? {
                Some(old) if old == file.contents => {}
                Some(old) if !old.contains(MARK) => return Err(FileError::Foreign { path }),
                _ => changes.push((path, file.contents.as_str())),
            }
        }

        let texts = changes
            .iter()
            .map(|(path, contents)| (path.as_path(), contents.as_bytes()));
        atomic_files::write_all(texts).map_err(|(path, source)| FileError::Io { path, source })?;
        Ok(changes.into_iter().map(|(path, _)| path).collect())
    }

    /// Compares `directory` with what [`EmittedCrate::write`] would leave there.
    ///
    /// # Errors
    /// [`FileError::Differs`] with every file that is missing or differs, [`FileError::Io`] if one
    /// cannot be read.
    pub fn check(&self, directory: &Path) -> Result<(), FileError> {
        let mut paths = Vec::new();
        for file in &self.files {
            let path = directory.join(&file.path);
            if read(&path)?.as_deref() != Some(file.contents.as_str()) {
                paths.push(path);
            }
        }
        if paths.is_empty() {
            Ok(())
        } else {
            Err(FileError::Differs { paths })
        }
    }
}

/// The file as text; `None` where there is none. Other bytes than UTF-8 become replacement
/// characters, which differ from every emitted text.
fn read(path: &Path) -> Result<Option<String>, FileError> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(String::from_utf8_lossy(&bytes).into_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(source) => Err(FileError::Io {
            path: path.to_owned(),
            source,
        }),
    }
}
