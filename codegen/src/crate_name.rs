//! The name of the emitted crate.

use std::fmt;
use std::str::FromStr;

/// The default name.
const USUAL: &str = "generated";
/// Longest name, in characters, that both crates.io and Arduino's library index accept.
const LENGTH_MAX: usize = 63;
/// Names of other crates that the emitted crate or its tests use, and a keyword of Rust that `syn` does not know yet.
const TAKEN: [&str; 7] = ["alloc", "core", "fixed", "gen", "proc_macro", "std", "test"];

/// A name that Cargo, Rust source and Arduino's library index accept: lower-case ASCII letters, digits, `-` and `_`,
/// with a letter first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrateName(String);

/// Text that is no [`CrateName`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{name}` is no name for the emitted crate: {reason}; it takes lower-case letters, digits, - and _, a letter \
     first, at most {LENGTH_MAX} characters, for example my-pendulum"
)]
pub struct NoCrateName {
    /// The text.
    pub name: String,
    /// The rule that it breaks.
    pub reason: &'static str,
}

impl CrateName {
    /// The name as it is written in `Cargo.toml`.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The name as it is written in Rust source, with `_` for `-`.
    pub fn in_rust(&self) -> String {
        self.0.replace('-', "_")
    }

    /// The name for a list of libraries. The default name of the crate says nothing in such a list, so `Flywheel`
    /// replaces it.
    pub fn of_library(&self) -> &str {
        if self.0 == USUAL { "Flywheel" } else { &self.0 }
    }
}

impl Default for CrateName {
    fn default() -> Self {
        CrateName(USUAL.to_owned())
    }
}

impl fmt::Display for CrateName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl FromStr for CrateName {
    type Err = NoCrateName;

    fn from_str(name: &str) -> Result<CrateName, NoCrateName> {
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_".contains(c);
        let in_rust = name.replace('-', "_");
        let reason = if name.is_empty() {
            "it is empty"
        } else if name.len() > LENGTH_MAX {
            "it is too long"
        } else if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
            "it does not begin with a lower-case letter"
        } else if !name.chars().all(is_plain) {
            "it has other characters"
        } else if TAKEN.contains(&in_rust.as_str()) {
            "it is taken"
        } else if syn::parse_str::<syn::Ident>(&in_rust).is_err() {
            "it is a word of the language Rust"
        } else {
            return Ok(CrateName(name.to_owned()));
        };
        Err(NoCrateName {
            name: name.to_owned(),
            reason,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cargo_rust_and_arduino_take_is_a_name() {
        for name in ["generated", "my-pendulum", "a", "bench_2", "x-"] {
            assert_eq!(name.parse::<CrateName>().unwrap().as_str(), name);
        }
        let name: CrateName = "my-pendulum".parse().unwrap();
        assert_eq!(name.in_rust(), "my_pendulum");
        assert_eq!(name.of_library(), "my-pendulum");
        assert_eq!(CrateName::default().of_library(), "Flywheel");
        assert_eq!("generated".parse(), Ok(CrateName::default()));
    }

    #[test]
    fn what_one_of_them_refuses_is_one_message() {
        let long = "a".repeat(64);
        for (name, reason) in [
            ("", "empty"),
            (&long, "too long"),
            ("2nd", "lower-case letter"),
            ("_x", "lower-case letter"),
            ("My", "lower-case letter"),
            ("été", "lower-case letter"),
            ("a b", "other characters"),
            ("a\n[x]", "other characters"),
            ("a\"", "other characters"),
            ("../x", "lower-case letter"),
            ("core", "taken"),
            ("proc-macro", "taken"),
            ("fixed", "taken"),
            ("gen", "taken"),
            ("fn", "language Rust"),
            ("async", "language Rust"),
            ("abstract", "language Rust"),
        ] {
            let error = name.parse::<CrateName>().unwrap_err().to_string();
            assert!(error.contains(reason), "{error}");
            assert!(error.contains("my-pendulum"), "{error}");
        }
    }
}
