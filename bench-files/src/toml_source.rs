//! Values from a TOML text, with their places, so that every error can point to its cause.

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml_edit::Document;

use crate::error::{Error, Place, Problem};
use crate::files::Files;
use crate::write::reason;

/// Largest size of a TOML file, in bytes. A bench with a thousand experiments has a tenth of it.
const MAX_TOML_BYTES: u64 = 4 << 20;

/// A TOML text with the path it came from.
#[derive(Clone, Debug)]
pub(crate) struct TomlSource {
    path: PathBuf,
    text: Arc<str>,
}

/// A value, with the range of its bytes in the text.
#[derive(Clone, Debug)]
pub(crate) struct Located<T> {
    pub value: T,
    pub span: Range<usize>,
}

impl TomlSource {
    /// Reads the file.
    pub fn read(files: Files, path: &Path) -> Result<TomlSource, Error> {
        let text = read_text(files, path, MAX_TOML_BYTES)?;
        Ok(TomlSource::new(path, text))
    }

    /// A text that is already in memory.
    pub fn new(path: &Path, text: String) -> TomlSource {
        TomlSource {
            path: path.to_path_buf(),
            text: text.into(),
        }
    }

    /// The path the text came from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text without a byte order mark, which some editors write.
    fn text(&self) -> &str {
        self.text.strip_prefix('\u{feff}').unwrap_or(&self.text)
    }

    /// Parses the text.
    pub fn parse(&self) -> Result<Document<&str>, Error> {
        Document::parse(self.text()).map_err(|error| {
            // The library separates its sentences with line breaks.
            let message = error.message().trim().replace('\n', ", ");
            self.error(error.span().unwrap_or(0..0), Problem::TomlSyntax(message))
        })
    }

    /// An error at these bytes of the text.
    pub fn error(&self, span: Range<usize>, problem: Problem) -> Error {
        let text = self.text();
        let start = floor_char_boundary(text, span.start);
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |end| end + 1);
        let place = Place {
            file: self.path.clone(),
            line: Some(before.matches('\n').count() + 1),
            position: Some(before[line_start..].chars().count() + 1),
            column: None,
        };
        let mark = self.text.len() - text.len();
        let end = floor_char_boundary(text, span.end).max(start);
        Error::in_text(place, problem, self.text.clone(), start + mark..end + mark)
    }

    /// The line of a byte of the text, counted from 1.
    pub fn line(&self, span: &Range<usize>) -> usize {
        let text = self.text();
        let start = floor_char_boundary(text, span.start);
        text[..start].matches('\n').count() + 1
    }
}

fn floor_char_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// Reads a text file of at most `limit` bytes.
fn read_text(files: Files, path: &Path, limit: u64) -> Result<String, Error> {
    let file = files.open(path)?;
    let advice = "no bench.toml or model.toml is that long";
    let too_large = |bytes| {
        Error::in_file(
            path,
            Problem::TooLarge {
                bytes,
                limit,
                advice,
            },
        )
    };
    let unreadable =
        |error: std::io::Error| Error::in_file(path, Problem::Unreadable(reason(&error)));
    let length = file.length().map_err(unreadable)?;
    if length > limit {
        return Err(too_large(length));
    }
    let mut bytes = Vec::new();
    file.take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64));
    }
    String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..byte]
            .iter()
            .filter(|b| **b == b'\n')
            .count()
            + 1;
        Error::at(
            Place {
                file: path.to_path_buf(),
                line: Some(line),
                position: None,
                column: None,
            },
            Problem::NotUtf8 { byte: byte as u64 },
        )
    })
}
