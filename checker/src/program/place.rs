//! Places in the emitted source, and messages about them.

use std::fmt;
use std::sync::Arc;

use proc_macro2::Span;

/// File, line and column (both from one).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SourcePlace {
    /// Path inside the emitted crate, with `/`.
    pub file: Arc<str>,
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

impl SourcePlace {
    /// Where `span` starts in `file`.
    pub fn of(file: &Arc<str>, span: Span) -> SourcePlace {
        let start = span.start();
        SourcePlace {
            file: file.clone(),
            line: start.line,
            column: start.column + 1,
        }
    }
}

impl fmt::Display for SourcePlace {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// A place where the source is not in the language of emitted code, with what was found and what is
/// allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct SourceError {
    /// Where.
    pub place: SourcePlace,
    /// The construct that was found, and those that are allowed there.
    pub message: String,
}
