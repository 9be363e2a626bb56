//! The errors in files: what is wrong, where, and what would be right.

mod names;
mod problem;

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub(crate) use names::{Names, shortened};
pub use problem::Problem;

/// The place of an [`Error`] in the files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file, as it was named or found.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// Position in the line in characters, counted from 1 (TOML files).
    pub position: Option<usize>,
    /// Name of the column (logs).
    pub column: Option<String>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(position) = self.position {
            write!(f, ":{position}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ": column \"{column}\"")?;
        }
        Ok(())
    }
}

/// One error in one file. Its text is "place: problem". [`Error::excerpt`] returns the text of
/// a TOML file with the place in it.
#[derive(Clone, Debug)]
pub struct Error(Box<Inner>);

impl std::error::Error for Error {}

impl fmt::Display for Error {
    /// One line: names from a file may contain line breaks and terminal codes, which a message must not.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{}: {}", self.0.place, self.0.problem);
        f.write_str(&without_control_characters(&text))
    }
}

#[derive(Clone, Debug)]
struct Inner {
    place: Place,
    problem: Problem,
    excerpt: Option<(Arc<str>, Range<usize>)>,
}

impl Error {
    /// Where the error is.
    pub fn place(&self) -> &Place {
        &self.0.place
    }

    /// What the error is.
    pub fn problem(&self) -> &Problem {
        &self.0.problem
    }

    /// The text of the file and the range of its wrong bytes, for a display of the line (TOML files).
    pub fn excerpt(&self) -> Option<(&str, Range<usize>)> {
        let (text, span) = self.0.excerpt.as_ref()?;
        Some((text, span.clone()))
    }

    /// A problem with a whole file.
    pub(crate) fn in_file(file: &Path, problem: Problem) -> Error {
        Error::at(
            Place {
                file: file.to_path_buf(),
                line: None,
                position: None,
                column: None,
            },
            problem,
        )
    }

    /// A problem at a place.
    pub(crate) fn at(place: Place, problem: Problem) -> Error {
        Error(Box::new(Inner {
            place,
            problem,
            excerpt: None,
        }))
    }

    /// A problem at a place in a TOML file whose text can be shown.
    pub(crate) fn in_text(
        place: Place,
        problem: Problem,
        text: Arc<str>,
        span: Range<usize>,
    ) -> Error {
        Error(Box::new(Inner {
            place,
            problem,
            excerpt: Some((text, span)),
        }))
    }
}

fn without_control_characters(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect()
}
