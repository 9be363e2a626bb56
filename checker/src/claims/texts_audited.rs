//! Claim `texts-audited`: whatever is no number is a text that was audited.

use crate::audit::{AuditedText, audited, digest, known};
use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;

/// Compares each file with the digests of the audited texts.
pub fn by_digest(emitted: &Emitted) -> ClaimOutcome {
    ClaimOutcome::proved(texts(emitted).map(|texts| format!("{} files", texts.len())))
}

/// The audited text of each file.
///
/// # Errors
/// A sentence that names the first file that is none.
pub fn texts(emitted: &Emitted) -> Result<Vec<&'static AuditedText>, String> {
    let found = emitted.sources.iter().map(|(path, text)| {
        let digest = digest::of_file(path, text).unwrap_or_default();
        known(path, &digest).ok_or_else(|| {
            if audited().iter().any(|text| text.file == *path) {
                format!("{path} is not the audited text: its tokens have the digest {digest}")
            } else {
                format!("{path} is no file of an audited crate")
            }
        })
    });
    found.collect()
}
