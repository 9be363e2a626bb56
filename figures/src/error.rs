//! The errors of the figures.

/// The reason why a figure could not be drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Two slices that belong together differ in length.
    #[error("figure \"{figure}\": {what} has {found} values where {expected} are needed")]
    Length {
        /// Title of the figure.
        figure: String,
        /// The slice with the wrong length.
        what: String,
        /// Length that was needed.
        expected: usize,
        /// Length that was found.
        found: usize,
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
