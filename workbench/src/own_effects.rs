//! Effects that a user writes.

use std::path::Path;

use bench_files::OwnEffect;

use crate::error::Error;
use crate::session::Session;

/// What is wrong with the text of an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OwnEffectError {
    /// What, in words.
    pub message: String,
    /// Line, counted from 1.
    pub line: Option<usize>,
    /// Position in the line in characters, counted from 1.
    pub position: Option<usize>,
}

/// Whether a text could stand in `effects/NAME.toml` of a bench, read as the file is. Returns the names of the
/// effect's parameters.
///
/// # Errors
/// What is wrong with it.
pub fn check_own_effect(name: &str, text: &str) -> Result<Vec<String>, OwnEffectError> {
    let path = Path::new("effects").join(format!("{name}.toml"));
    OwnEffect::check(text, name, &path).map_err(|error| OwnEffectError {
        message: error.problem().to_string(),
        line: error.place().line,
        position: error.place().position,
    })
}

impl Session {
    /// Reads the effects in the bench's folder anew: one was written, or changed.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn reread_own_effects(&mut self) -> Result<(), Error> {
        let found = OwnEffect::of_folder(&self.bench().folder)?;
        self.set_own_effects(found);
        Ok(())
    }
}
