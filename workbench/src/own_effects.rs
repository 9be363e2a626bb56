//! Effects that a user writes.

use std::path::Path;

use bench_files::OwnEffect;

use crate::error::Error;
use crate::session::Session;

/// A mistake in the text of an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnEffectError {
    /// The mistake, in words.
    pub message: String,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// Position in the line in characters, counted from 1.
    pub position: Option<usize>,
}

/// Checks a text as the content of `effects/NAME.toml` of a bench, and returns the names of the effect's parameters.
///
/// # Errors
/// The first mistake in the text.
pub fn check_own_effect(name: &str, text: &str) -> Result<Vec<String>, OwnEffectError> {
    let path = Path::new("effects").join(format!("{name}.toml"));
    OwnEffect::check(text, name, &path).map_err(|error| OwnEffectError {
        message: error.problem().to_string(),
        line: error.place().line,
        position: error.place().position,
    })
}

impl Session {
    /// Reads the effects in the bench's folder again, after a file was added or changed.
    ///
    /// # Errors
    /// The first mistake in one of the files.
    pub fn reread_own_effects(&mut self) -> Result<(), Error> {
        let found = OwnEffect::of_folder(&self.bench().folder)?;
        self.set_own_effects(found);
        Ok(())
    }
}
