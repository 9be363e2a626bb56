//! The texts of an emitted crate, fixed by digests.
//!
//! Two emitted crates differ in numbers only: the words of `src/constants.rs`, and gains,
//! limit and formats of `src/control.rs`. Everything else is one of a few texts that were audited once
//! (`cargo run --release -p checker --example audit`) and are identified by the SHA-256 of their tokens.
//! `audited.json` holds the digests and the results of the audit; only the audit writes it.
//!
//! An added method, a changed default, or a branch that is taken for a few words only (which random runs may
//! never reach) makes another text, which is refused.

pub mod digest;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

/// One text, with the results of its audit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AuditedText {
    /// Path in an emitted crate, `src/root.rs`.
    pub file: String,
    /// Digest of its tokens, see [`digest::of_file`].
    pub digest: String,
    /// Functions that were run on every input of their contract.
    pub every_input: Vec<String>,
    /// Functions that were run in `cases` random cases, chosen near the places where branches meet.
    pub in_cases: Vec<String>,
    /// Number of these cases.
    pub cases: usize,
}

/// Every audited text.
static AUDITED: LazyLock<Vec<AuditedText>> = LazyLock::new(|| {
    // A test of this crate reads the file, so that it cannot become invalid unnoticed. If it is invalid, no text counts as
    // audited.
    serde_json::from_str(include_str!("../../audited.json")).unwrap_or_default()
});

/// Every audited text.
pub fn audited() -> &'static [AuditedText] {
    &AUDITED
}

/// The audited text of `file` with this digest.
pub fn known(file: &str, digest: &str) -> Option<&'static AuditedText> {
    audited()
        .iter()
        .find(|text| text.file == file && text.digest == digest)
}
