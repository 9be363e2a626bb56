//! Writing files so that a reader never sees half of one.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Problem};

/// Writes `content` to `path` in one step: into a new file beside it, then renamed over it.
/// An interrupted write leaves the old file as it was. A symbolic link is followed, the old file's
/// permissions are kept.
///
/// # Errors
/// [`Problem::Unwritable`] with the system's reason.
pub fn write_atomically(path: &Path, content: &[u8]) -> Result<(), Error> {
    write(path, content).map_err(|error| Error::in_file(path, Problem::Unwritable(reason(&error))))
}

fn write(path: &Path, content: &[u8]) -> std::io::Result<()> {
    // Renaming over a link would replace the link, not what it points at.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".flywheel-").suffix(".tmp");
    // Temporary files are private by default; this one becomes an ordinary file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let permissions = match fs::metadata(&target) {
            Ok(old) => old.permissions(),
            Err(_) => fs::Permissions::from_mode(0o666),
        };
        builder.permissions(permissions);
    }
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(content)?;
    file.as_file().sync_all()?;
    file.persist(&target)?;
    Ok(())
}

/// An input/output error without the code that only programmers read.
pub(crate) fn reason(error: &std::io::Error) -> String {
    let text = error.to_string();
    match text.find(" (os error") {
        Some(end) => text[..end].to_string(),
        None => text,
    }
}
