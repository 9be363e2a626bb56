//! Functions of the source by name, their execution on words, and comparisons of their results.

use crate::domains::machine::Machine;
use crate::language::module::Module;

/// Functions by name, run on words.
pub(crate) struct Functions<'a>(pub(crate) &'a Module);

impl Functions<'_> {
    pub(crate) fn call(&self, name: &str, arguments: &[i128]) -> Result<Vec<i128>, String> {
        let program = self
            .0
            .function(name)
            .ok_or_else(|| format!("there is no function {name}"))?;
        Machine::new(program)
            .call(arguments)
            .map(<[i128]>::to_vec)
            .map_err(|trap| format!("{name}: {trap}"))
    }

    /// As [`Functions::call`], for a function that returns this many words.
    ///
    /// # Errors
    /// As [`Functions::call`], or that it returns another number of words.
    pub(crate) fn call_for_words(
        &self,
        name: &str,
        arguments: &[i128],
        count: usize,
    ) -> Result<Vec<i128>, String> {
        let words = self.call(name, arguments)?;
        if words.len() != count {
            return Err(format!("{name} returns {} words, not {count}", words.len()));
        }
        Ok(words)
    }

    pub(crate) fn constant(&self, file: &str, name: &str) -> Result<&[i128], String> {
        self.0
            .constant(file, name)
            .ok_or_else(|| format!("there is no constant {file}::{name}"))
    }
}

pub(crate) fn same(
    what: &str,
    arguments: &[i128],
    found: &[i128],
    wanted: &[i128],
) -> Result<(), String> {
    if found == wanted {
        Ok(())
    } else {
        Err(format!(
            "{what} of {arguments:?} is {found:?}, not {wanted:?}"
        ))
    }
}

pub(crate) fn near(
    what: &str,
    argument: i128,
    found: i128,
    wanted: f64,
    units: f64,
) -> Result<(), String> {
    if (found as f64 - wanted).abs() <= units {
        Ok(())
    } else {
        Err(format!("{what} of {argument} is {found}, not {wanted}"))
    }
}

pub(crate) fn number(words: &[(String, i128)], name: &str) -> Result<f64, String> {
    words
        .iter()
        .find(|(known, _)| known.ends_with(name))
        .map(|(_, word)| *word as f64)
        .ok_or_else(|| format!("the filter has no constant {name}"))
}
