//! Why a figure could not be made.

use std::path::PathBuf;

/// Why a figure could not be made.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Two slices that belong together differ in length.
    #[error("figure \"{figure}\": {what} has {found} values where {expected} are needed")]
    Length {
        /// Title of the figure.
        figure: String,
        /// The slice that does not fit.
        what: String,
        /// Length that was needed.
        expected: usize,
        /// Length that was found.
        found: usize,
    },
    /// The file could not be written; an older file is left as it was.
    #[error("{}: cannot write the figure: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Checks that `what` of the figure `figure` has `expected` values.
pub(crate) fn check_length(
    figure: &str,
    what: impl FnOnce() -> String,
    expected: usize,
    found: usize,
) -> Result<(), FigureError> {
    if expected == found {
        return Ok(());
    }
    Err(FigureError::Length {
        figure: figure.to_owned(),
        what: what(),
        expected,
        found,
    })
}
