//! All claims about an emitted crate in a folder, each by every engine that can decide it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::certificate::reader::{Certificate, CertificateError};
use crate::language::emitted::Emitted;
use crate::language::emitted_error::EmittedError;
use crate::prove::kani::kani;
use crate::prove::results::{ClaimResult, complete};
use crate::prove::settings::ProofSettings;
use crate::prove::settle::settle_saying;

/// The reason why there is nothing to prove.
#[derive(Debug, thiserror::Error)]
pub enum ProveError {
    /// The folder holds no emitted crate, or cannot be read.
    #[error("{0}")]
    Emitted(#[from] EmittedError),
    /// The certificate cannot be read.
    #[error("{0}")]
    Certificate(#[from] CertificateError),
    /// The model cannot be read.
    #[error("{}: {source}", path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Decides every claim about the crate in `directory`, compared with the user's `model` if one is given. `say` receives
/// progress messages.
///
/// # Errors
/// [`ProveError`] if the folder does not contain an emitted crate. Source or numbers that are wrong
/// are not an error but a failed claim.
pub fn prove(
    directory: &Path,
    model: Option<&Path>,
    settings: &ProofSettings,
    say: &dyn Fn(&str),
) -> Result<Vec<ClaimResult>, ProveError> {
    let emitted = Emitted::read(directory)?;
    let certificate = Certificate::parse(&emitted.certificate)?;
    let model = model
        .map(|path| {
            fs::read_to_string(path).map_err(|source| ProveError::Model {
                path: path.to_owned(),
                source,
            })
        })
        .transpose()?;
    let mut results = settle_saying(&emitted, &certificate, model.as_deref(), settings, say);
    results.extend(kani(&emitted, &certificate, settings));
    Ok(complete(results, "switched off"))
}
