//! The decimal numbers of a certificate, and its fields that may be null.

use std::fmt;

use num_rational::BigRational;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};

use crate::exact::rational::decimal;

/// A field that may be null but must not be missing.
pub(crate) fn stated<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    deserializer: D,
) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}

/// A decimal number as written, with its exact value.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedDecimal {
    /// As written.
    pub text: String,
    /// Its exact value.
    pub value: BigRational,
}

impl<'de> Deserialize<'de> for StatedDecimal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        match decimal(&text) {
            Some(value) => Ok(StatedDecimal { text, value }),
            None => Err(D::Error::custom(format!("`{text}` is no decimal number"))),
        }
    }
}

impl fmt::Display for StatedDecimal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.text)
    }
}
