//! The output of commands: text for people, JSON for programs.

pub mod table;

use std::path::{Path, PathBuf};

use serde::Serialize;
use workbench::OutputFile;

use crate::failure::Failure;

/// The result of a command.
pub struct Report {
    /// The text for standard output, ending in a line break.
    pub text: String,
    /// The same result as JSON, ending in a line break.
    pub json: String,
    /// Exit code: 0 for success, 1 if a proof or a check failed, 2 if the data were refused,
    /// 3 if a proof left a claim undecided.
    pub code: u8,
}

impl Report {
    /// The report of a successful command.
    pub fn new(text: String, result: &impl Serialize) -> Result<Report, Failure> {
        let json = serde_json::to_string_pretty(result)
            .map_err(|error| Failure::new(format!("cannot write the result as JSON: {error}")))?;
        Ok(Report {
            text,
            json: json + "\n",
            code: 0,
        })
    }

    /// The same report with exit code 1.
    pub fn failed(self) -> Report {
        Report { code: 1, ..self }
    }

    /// The same report with exit code 2.
    pub fn refused(self) -> Report {
        Report { code: 2, ..self }
    }

    /// The same report with exit code 3.
    pub fn unsettled(self) -> Report {
        Report { code: 3, ..self }
    }
}

/// A result, with the paths of its figures.
#[derive(Serialize)]
pub struct WithFigures<'a, T> {
    /// The result.
    #[serde(flatten)]
    pub result: &'a T,
    /// The paths of its figures.
    pub figures: Vec<PathBuf>,
}

/// Writes figures and tables into a folder, which is created if missing; returns their paths.
pub fn write_files(folder: &Path, files: &[OutputFile]) -> Result<Vec<PathBuf>, Failure> {
    if files.is_empty() {
        return Ok(Vec::new());
    }
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::in_file(folder, format!("cannot create the folder: {error}")))?;
    let mut paths = Vec::new();
    for file in files {
        let path = folder.join(&file.name);
        bench_files::write_atomically(&path, file.text.as_bytes())?;
        paths.push(path);
    }
    Ok(paths)
}

/// The lines that list files.
pub fn listed(paths: &[PathBuf]) -> String {
    let lines = paths.iter().map(|path| format!("  {}\n", path.display()));
    lines.collect()
}
