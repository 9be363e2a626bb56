//! Claim `texts-audited`: every part of the source that is not a number is an audited text.

use crate::audit::{AuditedText, audited, digest, known};
use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;

/// Compares each file with the digests of the audited texts.
pub fn by_digest(emitted: &Emitted) -> ClaimOutcome {
    let checked = texts(emitted).and_then(|texts| {
        let harnesses = of_files(&emitted.harnesses)?;
        Ok(match harnesses.len() {
            0 => format!("{} files", texts.len()),
            count => format!("{} files, and {count} of harnesses", texts.len()),
        })
    });
    ClaimOutcome::proved(checked)
}

/// The audited text of each file of the crate, without its harness crate.
///
/// # Errors
/// A sentence that names the first file that is none.
pub fn texts(emitted: &Emitted) -> Result<Vec<&'static AuditedText>, String> {
    of_files(&emitted.sources)
}

/// The audited text of each of these files.
///
/// # Errors
/// A sentence that names the first file that is none.
pub fn of_files(files: &[(String, String)]) -> Result<Vec<&'static AuditedText>, String> {
    let found = files.iter().map(|(path, text)| {
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

/// A sentence about the results of the audit that go beyond this run; empty for texts that were not
/// audited.
pub fn audit_of(emitted: &Emitted) -> String {
    let Ok(texts) = texts(emitted) else {
        return String::new();
    };
    let with_cases = texts.iter().filter(|text| !text.in_cases.is_empty());
    let cases = with_cases.map(|text| text.cases).min().unwrap_or_default();
    let on_all: Vec<&str> = texts
        .iter()
        .flat_map(|text| text.every_input.iter().map(String::as_str))
        .collect();
    let all = if on_all.is_empty() {
        String::new()
    } else {
        format!("; on every input: {}", on_all.join(", "))
    };
    format!("the text is the audited one, which was run in {cases} cases{all}")
}
