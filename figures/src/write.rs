//! Writing a figure to a file as a whole or not at all.

use crate::error::FigureError;
use std::io::Write;
use std::path::Path;

/// Writes `svg` to `path`; makes missing folders. The text goes to a temporary
/// file beside the target first, so an interruption leaves the old file.
///
/// # Errors
/// [`FigureError::Write`] with the path.
pub fn write_svg(path: &Path, svg: &str) -> Result<(), FigureError> {
    let failed = |source| FigureError::Write {
        path: path.to_owned(),
        source,
    };
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(failed)?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".figure").suffix(".svg");
    // Temporary files are private by default; a figure is for everyone whom
    // the user's umask allows.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder).map_err(failed)?;
    file.write_all(svg.as_bytes()).map_err(failed)?;
    file.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}
