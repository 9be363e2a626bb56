//! Writing files so that a reader never sees an incomplete one.

use std::path::Path;

use crate::error::{Error, Problem};

/// Writes `content` to `path` in one step: into a new file beside it, which is then renamed.
/// If the write is interrupted, the old file is unchanged. A symbolic link is followed, and the old file's
/// permissions are kept.
///
/// # Errors
/// [`Problem::Unwritable`] with the system's reason.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), Error> {
    atomic_files::write(path, content)
        .map_err(|error| Error::in_file(path, Problem::Unwritable(reason(&error))))
}

/// Whether files can be written into a folder that exists or can be created. No file is left there.
///
/// # Errors
/// [`Problem::Unwritable`] with the system's reason.
pub fn can_write_into(folder: &Path) -> Result<(), Error> {
    atomic_files::can_write_into(folder)
        .map_err(|error| Error::in_file(folder, Problem::Unwritable(reason(&error))))
}

/// Whether this file can be written, in a folder that exists or can be created. No file is left there.
///
/// # Errors
/// [`Problem::Unwritable`] with the system's reason.
pub fn can_write(path: &Path) -> Result<(), Error> {
    atomic_files::can_write(path)
        .map_err(|error| Error::in_file(path, Problem::Unwritable(reason(&error))))
}

/// An input/output error without its numerical code.
pub(crate) fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error") {
        Some(end) => text[..end].to_string(),
        None => text,
    }
}
