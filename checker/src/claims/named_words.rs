//! Words of `src/constants.rs` by name, and the real numbers to which they must be nearest.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use crate::exact::rational::{half, integer, power, rounded_up};
use crate::language::module::Module;

/// Words of one constant by name.
pub(crate) struct NamedWords(pub(crate) Vec<(String, i128)>);

impl NamedWords {
    pub(crate) fn read(module: &Module, name: &str) -> Result<NamedWords, String> {
        module
            .constant_words("constants", name)
            .map(NamedWords)
            .ok_or_else(|| format!("src/constants.rs has no {name}"))
    }

    pub(crate) fn get(&self, name: &str) -> Result<BigRational, String> {
        self.0
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, word)| integer(*word))
            .ok_or_else(|| format!("src/constants.rs has no {name}"))
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, i128)> {
        self.0.iter().map(|(name, word)| (name.as_str(), *word))
    }

    pub(crate) fn small(&self, name: &str) -> Result<i32, String> {
        let word = self.get(name)?;
        word.to_integer()
            .to_i32()
            .ok_or_else(|| format!("{name} is too large"))
    }
}

/// A word is the nearest to a real number; half a unit and what double precision may add.
pub(crate) fn nearest(name: &str, word: &BigRational, real: &BigRational) -> Result<(), String> {
    let allowed = half() + power(10, -3);
    if (word - real).abs() <= allowed {
        Ok(())
    } else {
        Err(format!(
            "{name} is {}, its real number makes it {}",
            rounded_up(word, 12),
            rounded_up(real, 12)
        ))
    }
}
