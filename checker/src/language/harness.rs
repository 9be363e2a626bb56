//! The harness crate in the folder `verify` of an emitted crate, as text.

use std::fs;
use std::path::Path;

use crate::language::emitted_error::EmittedError;

/// The folder of the harness crate.
const FOLDER: &str = "verify";

/// The files of a harness crate.
#[derive(Debug, Default)]
pub(crate) struct HarnessFiles {
    /// `verify/src/**.rs`, by path.
    pub(crate) sources: Vec<(String, String)>,
    /// `verify/Cargo.toml`.
    pub(crate) cargo: Option<String>,
    /// Paths of everything else, except for what Cargo writes itself (`Cargo.lock`, `target`).
    pub(crate) strays: Vec<String>,
}

/// Reads the harness crate beside the `src` of an emitted crate; nothing where there is none.
///
/// # Errors
/// [`EmittedError::Io`] with the file.
pub(crate) fn read(directory: &Path) -> Result<HarnessFiles, EmittedError> {
    let mut files = HarnessFiles::default();
    if !directory.join(FOLDER).exists() {
        return Ok(files);
    }
    let mut waiting = vec![FOLDER.to_owned()];
    while let Some(folder) = waiting.pop() {
        let path = directory.join(&folder);
        let io = |source| EmittedError::Io {
            path: path.clone(),
            source,
        };
        for entry in fs::read_dir(&path).map_err(io)? {
            let entry = entry.map_err(io)?;
            let kind = entry.file_type().map_err(io)?;
            let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
            let text = || {
                let path = entry.path();
                fs::read_to_string(&path).map_err(|source| EmittedError::Io { path, source })
            };
            let is_below_src = folder != FOLDER;
            let is_rust = entry.path().extension().is_some_and(|e| e == "rs");
            match name.as_str() {
                "verify/Cargo.toml" if kind.is_file() => files.cargo = Some(text()?),
                "verify/Cargo.lock" if kind.is_file() => {}
                "verify/target" if kind.is_dir() => {}
                _ if kind.is_dir() && (is_below_src || name == "verify/src") => waiting.push(name),
                _ if kind.is_file() && is_below_src && is_rust => {
                    let text = text()?;
                    files.sources.push((name, text));
                }
                _ => files.strays.push(name),
            }
        }
    }
    files.sources.sort();
    files.strays.sort();
    Ok(files)
}
