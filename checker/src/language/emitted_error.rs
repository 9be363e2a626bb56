//! The errors of reading an emitted crate.

use std::path::PathBuf;

use crate::language::module::ReadError;

/// The reason why a folder could not be read as an emitted crate.
#[derive(Debug, thiserror::Error)]
pub enum EmittedError {
    /// The folder cannot be read.
    #[error("{0}")]
    Read(ReadError),
    /// A file that every emitted crate has is missing.
    #[error("{} is no emitted crate: there is no {missing} in it; flywheel generate writes one", folder.display())]
    NoCrate {
        /// The folder.
        folder: PathBuf,
        /// What is missing.
        missing: &'static str,
    },
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}
