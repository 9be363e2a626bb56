//! Arguments that several commands share.

use std::path::{Path, PathBuf};

use clap::Args;
use workbench::Session;

use crate::failure::Failure;
use crate::progress::with_progress;

/// The place to which the result is written.
#[derive(Args)]
pub struct JsonOutput {
    /// Write everything that the text says to FILE as JSON ("-": standard output, instead of text)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

impl JsonOutput {
    /// The file for the JSON; `None` without one, and for standard output.
    pub fn json_file(&self) -> Option<&Path> {
        self.json.as_deref().filter(|path| path.as_os_str() != "-")
    }
}

/// The folder for figures beside a model, unless another is given.
pub fn out_beside(model: &Path) -> PathBuf {
    let beside = model.parent();
    beside.map_or_else(|| PathBuf::from("out"), |folder| folder.join("out"))
}

/// Paths that belong to a bench.
#[derive(Args)]
pub struct BenchFiles {
    /// The model of the bench [default: BENCH/model.toml]
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// Folder for figures and reports [default: BENCH/out]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl BenchFiles {
    /// Opens the bench with the given model.
    pub fn open(&self, bench: &Path) -> Result<Session, Failure> {
        let model = self.model.as_deref();
        Ok(with_progress(|progress| {
            Session::open_reporting(bench, model, progress)
        })?)
    }

    /// Opens the bench for a command that draws figures. The output folder is checked first, so that long work does not
    /// end with a folder that cannot be written to.
    pub fn open_to_draw(&self, bench: &Path) -> Result<Session, Failure> {
        let session = self.open(bench)?;
        bench_files::can_write_into(&self.out_of(&session))?;
        Ok(session)
    }

    /// Opens the bench for a command that writes its model.
    pub fn open_to_change(&self, bench: &Path) -> Result<Session, Failure> {
        let session = self.open(bench)?;
        let folder = session.model_path().parent();
        bench_files::can_write_into(folder.unwrap_or(Path::new(".")))?;
        Ok(session)
    }

    /// The folder for figures and reports of the bench.
    pub fn out_of(&self, session: &Session) -> PathBuf {
        let beside = || session.bench().folder.join("out");
        self.out.clone().unwrap_or_else(beside)
    }
}

/// Writes a session's model; the error names a way out if the bench is read-only.
pub fn save_model(session: &Session) -> Result<(), Failure> {
    session.save_model().map_err(|error| {
        Failure::new(format!(
            "{error}; --model FILE names another file, for example if the bench is read-only"
        ))
    })
}
