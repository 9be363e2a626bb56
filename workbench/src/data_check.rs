//! The check of a bench's data, before anything is fitted.

use std::path::{Path, PathBuf};

use ::data_check::{Finding, Proposal, Severity};
use bench_files::Bench;
use serde::{Deserialize, Serialize};

use crate::comparison::{BenchNote, notes};
use crate::error::Error;

/// The result of [`check_data`]: the findings for the data of a bench.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DataReport {
    /// The bench.
    pub bench: String,
    /// Number of its experiments.
    pub experiments: usize,
    /// Number of samples in all of them.
    pub samples: usize,
    /// The findings, refusals first.
    pub findings: Vec<Finding>,
    /// The notes from reading the files.
    pub notes: Vec<BenchNote>,
}

impl DataReport {
    /// Whether a finding prevents every command from going on.
    pub fn is_refused(&self) -> bool {
        self.findings.iter().any(is_refusal)
    }
}

/// Reads a bench (its folder, or its bench.toml), and compares its columns with each other, with the kinds of
/// the experiments, and with what such benches can do. Nothing is fitted.
///
/// # Errors
/// The first error that prevents a file from being read.
pub fn check_data(path: &Path) -> Result<DataReport, Error> {
    let bench = Bench::load(path)?;
    Ok(DataReport {
        findings: ::data_check::check(&bench),
        notes: notes(&bench),
        experiments: bench.experiments.len(),
        samples: bench.experiments.iter().map(|one| one.log.len()).sum(),
        bench: bench.name,
    })
}

/// A new bench folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewBench {
    /// The bench.toml that was written.
    pub written: PathBuf,
    /// Its content, with the reasons.
    #[serde(flatten)]
    pub proposal: Proposal,
}

/// Proposes a bench.toml for these logs and writes it into `folder`, which is created if it is missing. An
/// existing bench.toml is not changed.
///
/// # Errors
/// [`Error::BenchExists`]; a log that cannot be read; a folder that cannot be written to.
pub fn new_bench(folder: &Path, logs: &[PathBuf]) -> Result<NewBench, Error> {
    let written = folder.join("bench.toml");
    // Anything with this name is kept, even a symbolic link whose target does not exist.
    if std::fs::symlink_metadata(&written).is_ok() {
        return Err(Error::BenchExists { file: written });
    }
    let is_made = folder.is_dir();
    if !is_made {
        std::fs::create_dir_all(folder).map_err(|error| Error::NoFolder {
            folder: folder.to_path_buf(),
            reason: error.to_string(),
        })?;
    }
    let proposed = ::data_check::propose(folder, logs).inspect_err(|_| {
        if !is_made {
            // The folder is removed only if it is empty and this call created it.
            let _ = std::fs::remove_dir(folder);
        }
    });
    let proposal = proposed?;
    bench_files::write_atomically(&written, proposal.text.as_bytes())?;
    Ok(NewBench { written, proposal })
}

fn is_refusal(finding: &Finding) -> bool {
    finding.severity == Severity::Refuse
}

/// The warnings for a bench whose data can be used.
///
/// # Errors
/// [`Error::Data`] if a finding refuses the data.
pub(crate) fn usable(bench: &Bench) -> Result<Vec<Finding>, Error> {
    let (refusals, warnings): (Vec<Finding>, Vec<Finding>) =
        ::data_check::check(bench).into_iter().partition(is_refusal);
    let Some(first) = refusals.first() else {
        return Ok(warnings);
    };
    let named = first.experiment.as_deref();
    let experiment = named.and_then(|name| bench.experiment(name));
    Err(Error::Data {
        file: match bench.folder.as_os_str().is_empty() {
            true => PathBuf::from("bench.toml"),
            false => bench.folder.join("bench.toml"),
        },
        line: experiment.map(|experiment| experiment.line),
        refusals,
    })
}
