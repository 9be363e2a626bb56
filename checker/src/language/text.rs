//! The text of an emitted file, before it is parsed.
//!
//! The reader and rustc must see the same program. Only text that both read alike is allowed:
//!
//! - outside of comments, printable ASCII, spaces and line feeds; in comments, everything that cannot change how text is
//!   displayed (no control character, no mark of writing direction);
//! - names of letters, digits and `_`; never `r#name`, and so no second spelling of a name;
//! - integers in decimal or hexadecimal, with `_`, and the suffix of an integer type or none;
//! - strings of printable ASCII without `\`, with no prefix, for the messages of assertions;
//! - the marks `+ - * & | < > = ! . , ; : # ( ) [ ] { }` and `//` comments.

use std::sync::Arc;

use crate::language::declarations::Read;
use crate::program::place::{SourceError, SourcePlace};
use crate::program::types::Integer;

/// Marks that stand in emitted code; `/` stands in `//` alone.
const MARKS: &str = "+-*&|<>=!.,;:#()[]{}";

/// Checks every character and token of `text`.
///
/// # Errors
/// [`SourceError`] at the first that is not in the list above.
pub fn check(path: &Arc<str>, text: &str) -> Read<()> {
    for (index, line) in text.split('\n').enumerate() {
        check_line(line).map_err(|(column, message)| SourceError {
            place: SourcePlace {
                file: path.clone(),
                line: index + 1,
                column: column + 1,
            },
            message,
        })?;
    }
    Ok(())
}

/// One line; the column, from zero, and what is wrong there.
fn check_line(line: &str) -> Result<(), (usize, String)> {
    let chars: Vec<char> = line.chars().collect();
    let mut at = 0;
    while at < chars.len() {
        let c = chars[at];
        let rest = &chars[at..];
        if rest.starts_with(&['/', '/']) {
            return comment(&chars, at);
        }
        let length = if c == ' ' {
            1
        } else if c == '"' {
            string(rest).map_err(|message| (at, message))?
        } else if is_of_word(c) {
            let length = rest.iter().take_while(|c| is_of_word(**c)).count();
            let word: String = rest[..length].iter().collect();
            match rest.get(length) {
                Some('#' | '"' | '\'') => {
                    let found: String = rest[..=length].iter().collect();
                    let message = format!(
                        "found `{found}`; names and strings have no prefix, and each name one spelling"
                    );
                    return Err((at, message));
                }
                _ if c.is_ascii_digit() && !is_integer(&word) => {
                    let message = format!(
                        "found `{word}`; numbers are decimal or hexadecimal integers, with the suffix of an integer type or none"
                    );
                    return Err((at, message));
                }
                _ => length,
            }
        } else if MARKS.contains(c) {
            1
        } else {
            let shown: String = c.escape_default().collect();
            let message = format!(
                "found `{shown}`; outside of comments stand ASCII names, integers, messages of assertions and {MARKS}"
            );
            return Err((at, message));
        };
        at += length;
    }
    Ok(())
}

fn is_of_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// A comment from `start` on: whatever is visible, and nothing that hides or moves other text.
fn comment(chars: &[char], start: usize) -> Result<(), (usize, String)> {
    let is_hidden = |c: char| {
        c.is_control()
            || matches!(c, '\u{061c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    match chars[start..].iter().position(|c| is_hidden(*c)) {
        Some(index) => {
            let found = chars[start + index].escape_default();
            let message = format!("found `{found}`; no comment holds what is not seen");
            Err((start + index, message))
        }
        None => Ok(()),
    }
}

/// Length of the string at the start of `rest`, its quotes included.
fn string(rest: &[char]) -> Result<usize, String> {
    let end = rest[1..].iter().position(|c| *c == '"');
    let is_plain = |c: &char| (c.is_ascii_graphic() || *c == ' ') && *c != '\\';
    match end {
        Some(end) if rest[1..=end].iter().all(is_plain) => Ok(end + 2),
        _ => {
            Err("found a string; messages are printable ASCII on one line, without `\\`".to_owned())
        }
    }
}

/// `1_000`, `0x7fff_ffff`, with the suffix of an integer type or none.
fn is_integer(word: &str) -> bool {
    let is_body = |body: &str, is_digit: fn(char) -> bool| {
        body.starts_with(is_digit) && body.chars().all(|c| is_digit(c) || c == '_')
    };
    let is_number = |number: &str| match number.strip_prefix("0x") {
        Some(digits) => is_body(digits, |c| c.is_ascii_hexdigit()),
        None => is_body(number, |c| c.is_ascii_digit()),
    };
    let suffix = word.find(['i', 'u']);
    is_number(word)
        || suffix.is_some_and(|at| {
            Integer::named(&word[at..]).is_some() && is_number(word[..at].trim_end_matches('_'))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers() {
        for good in ["0", "1_000", "0x7fff_ffff", "1i64", "1_i64", "0x8000_u32"] {
            assert!(is_integer(good), "{good}");
        }
        for bad in [
            "0b1", "0o7", "1e5", "1x", "0x", "1f32", "1usize", "0xg", "1i",
        ] {
            assert!(!is_integer(bad), "{bad}");
        }
    }
}
