//! Parts of a runtime file that a bench may not have.
//!
//! A bench has one sensor of the body's angle, one of the wheel's speed and one kind of drive. In a file of
//! `codegen/runtime/` or `codegen/harnesses/`, text for other sensors and drives stands under `#[cfg(…)]` with the names of [`Parts::NAMES`]
//! and is not emitted. The emitted text has no `cfg` but Kani's, and a bench has no cost from parts that it lacks.

use std::ops::Range;

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// The parts that a module has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    /// Whether an encoder on the pivot shows the body, not gyroscope and accelerometer.
    pub has_body_encoder: bool,
    /// How the wheel's speed is read.
    pub wheel: WheelPart,
    /// Whether the drive sets the voltage, not the current.
    pub has_voltage_drive: bool,
}

/// How the wheel's speed is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WheelPart {
    /// Counts of a converter.
    Converter,
    /// Words of the motor's driver.
    Driver,
    /// Counts of an encoder.
    Encoder,
}

/// A text whose conditions are not written as this module requires.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PartsError {
    /// The text does not consist of Rust tokens.
    #[error("the text does not consist of Rust tokens: {0}")]
    NoTokens(String),
    /// A condition names something that is no part.
    #[error("line {line}: `{condition}` is no condition on the parts of a bench")]
    Condition {
        /// Line in the file, from one.
        line: usize,
        /// The condition.
        condition: String,
    },
}

impl Parts {
    /// The names that may stand in `#[cfg(…)]`. `test` never holds: tests are not emitted.
    pub const NAMES: [&str; 6] = [
        "body_encoder",
        "wheel_converter",
        "wheel_driver",
        "wheel_encoder",
        "voltage_drive",
        "test",
    ];

    /// All combinations of parts.
    pub fn all() -> impl Iterator<Item = Parts> {
        let wheels = [WheelPart::Converter, WheelPart::Driver, WheelPart::Encoder];
        wheels.into_iter().flat_map(|wheel| {
            [(false, false), (false, true), (true, false), (true, true)].map(
                |(has_body_encoder, has_voltage_drive)| Parts {
                    has_body_encoder,
                    wheel,
                    has_voltage_drive,
                },
            )
        })
    }

    /// Whether the bench has the part with this name; `None` if [`Parts::NAMES`] does not contain the name.
    pub fn has(&self, name: &str) -> Option<bool> {
        match name {
            "body_encoder" => Some(self.has_body_encoder),
            "wheel_converter" => Some(self.wheel == WheelPart::Converter),
            "wheel_driver" => Some(self.wheel == WheelPart::Driver),
            "wheel_encoder" => Some(self.wheel == WheelPart::Encoder),
            "voltage_drive" => Some(self.has_voltage_drive),
            "test" => Some(false),
            _ => None,
        }
    }

    /// The lines of `source` that belong to these parts. Lines are kept or dropped whole.
    ///
    /// # Errors
    /// [`PartsError`] for a text that is no Rust, and for a condition on something else.
    pub fn of_text(&self, source: &str) -> Result<String, PartsError> {
        let tokens: TokenStream = source
            .parse()
            .map_err(|error: proc_macro2::LexError| PartsError::NoTokens(error.to_string()))?;
        let written: Vec<&str> = source.lines().collect();
        let mut dropped = vec![false; written.len()];
        for (lines, is_node) in self.dropped(tokens)? {
            // Lines count from one.
            let mut first = lines.start - 1;
            // A comment belongs to what stands below it.
            while is_node && first > 0 && written[first - 1].trim_start().starts_with("// ") {
                first -= 1;
            }
            dropped[first..lines.end - 1].fill(true);
        }
        let mut text = String::with_capacity(source.len());
        // An empty line stands between two nodes: once, and not at the beginning or the end of a block.
        let mut is_apart = false;
        for (line, _) in written.iter().zip(dropped).filter(|(_, dropped)| !dropped) {
            if line.is_empty() {
                is_apart = true;
                continue;
            }
            let is_first = text.ends_with("{\n");
            if is_apart && !is_first && !line.trim_start().starts_with('}') {
                text.push('\n');
            }
            is_apart = false;
            text.push_str(line);
            text.push('\n');
        }
        Ok(text)
    }

    /// Lines that are not emitted, and whether they are a node, not a condition that holds.
    fn dropped(&self, tokens: TokenStream) -> Result<Vec<(Range<usize>, bool)>, PartsError> {
        let trees: Vec<TokenTree> = tokens.into_iter().collect();
        let mut lines = Vec::new();
        let mut at = 0;
        while at < trees.len() {
            // The attributes before a node, documentation among them, and the conditions in them.
            let start = at;
            let mut conditions = Vec::new();
            while let Some(after) = attribute_end(&trees, at) {
                if let Some(condition) = condition_of(&trees[after - 1]) {
                    let first = trees[at].span().start().line;
                    let last = trees[after - 1].span().end().line;
                    conditions.push((self.holds(&condition)?, first..last + 1));
                }
                at = after;
            }
            if conditions.iter().all(|(holds, _)| *holds) {
                lines.extend(conditions.into_iter().map(|(_, lines)| (lines, false)));
                if let Some(TokenTree::Group(group)) = trees.get(at) {
                    lines.extend(self.dropped(group.stream())?);
                }
                at += 1;
            } else {
                let end = node_end(&trees, at);
                let first = trees[start].span().start().line;
                let last = trees[end - 1].span().end().line;
                lines.push((first..last + 1, true));
                at = end;
            }
        }
        Ok(lines)
    }

    /// Whether a condition holds: a name, `not(…)`, `any(…)` or `all(…)`.
    fn holds(&self, condition: &TokenStream) -> Result<bool, PartsError> {
        let trees: Vec<TokenTree> = condition.clone().into_iter().collect();
        let refused = || PartsError::Condition {
            line: trees.first().map_or(0, |tree| tree.span().start().line),
            condition: condition.to_string(),
        };
        match trees.as_slice() {
            [TokenTree::Ident(name)] => self.has(&name.to_string()).ok_or_else(refused),
            [TokenTree::Ident(name), TokenTree::Group(group)] => {
                let mut parts = Vec::new();
                for part in separated(group.stream()) {
                    parts.push(self.holds(&part)?);
                }
                match (name.to_string().as_str(), parts.as_slice()) {
                    ("not", [one]) => Ok(!one),
                    ("any", parts) => Ok(parts.contains(&true)),
                    ("all", parts) => Ok(!parts.contains(&false)),
                    _ => Err(refused()),
                }
            }
            _ => Err(refused()),
        }
    }
}

/// The parts between commas.
fn separated(tokens: TokenStream) -> Vec<TokenStream> {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    trees
        .split(|tree| is_mark(tree, ','))
        .filter(|part| !part.is_empty())
        .map(|part| part.iter().cloned().collect())
        .collect()
}

fn is_mark(tree: &TokenTree, mark: char) -> bool {
    matches!(tree, TokenTree::Punct(found) if found.as_char() == mark)
}

/// The index after the attribute `#[…]` that begins at `at`; `None` if none begins there. A `///` comment is an
/// attribute, too.
fn attribute_end(trees: &[TokenTree], at: usize) -> Option<usize> {
    let is_attribute = is_mark(trees.get(at)?, '#')
        && matches!(trees.get(at + 1)?, TokenTree::Group(group) if group.delimiter() == Delimiter::Bracket);
    is_attribute.then_some(at + 2)
}

/// The condition between the parentheses of `[cfg(…)]`. `cfg(kani)` is emitted unchanged: Kani decides it, not the
/// bench.
fn condition_of(tree: &TokenTree) -> Option<TokenStream> {
    let TokenTree::Group(group) = tree else {
        return None;
    };
    let parts: Vec<TokenTree> = group.stream().into_iter().collect();
    match parts.as_slice() {
        [TokenTree::Ident(name), TokenTree::Group(condition)]
            if name == "cfg" && condition.stream().to_string() != "kani" =>
        {
            Some(condition.stream())
        }
        _ => None,
    }
}

/// The index after the node that begins at `at`: an item, a statement, a field or an argument. A node ends with a comma
/// or a semicolon, with a block that nothing continues (such as `else` or `.`), or with the group that contains it.
fn node_end(trees: &[TokenTree], mut at: usize) -> usize {
    while let Some(tree) = trees.get(at) {
        at += 1;
        // A last expression ends where the attribute of another one begins.
        if is_mark(tree, ';') || is_mark(tree, ',') || attribute_end(trees, at).is_some() {
            break;
        }
        let is_block =
            matches!(tree, TokenTree::Group(group) if group.delimiter() == Delimiter::Brace);
        let goes_on = match trees.get(at) {
            Some(TokenTree::Ident(next)) => next == "else",
            Some(TokenTree::Punct(next)) => ";,.?".contains(next.as_char()),
            _ => false,
        };
        if is_block && !goes_on {
            break;
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAIN: Parts = Parts {
        has_body_encoder: false,
        wheel: WheelPart::Converter,
        has_voltage_drive: false,
    };

    const SOURCE: &str = "\
//! A file.

use super::line::on_line;
#[cfg(voltage_drive)]
use super::plane::{Plane, on_plane};

/// A sample.
pub struct Sample {
    /// Of a converter.
    #[cfg(wheel_converter)]
    pub adc: u16,
    /// Of an encoder.
    #[cfg(wheel_encoder)]
    pub count: u16,
}

/// Kept.
pub fn f(a: i32) -> i32 {
    #[cfg(any(wheel_driver, wheel_encoder))]
    let c = if a > 0 { a } else { 1 };
    #[cfg(not(voltage_drive))]
    let c = Line { a: 1 }.a;
    // A comment is kept or dropped with the node below it.
    #[cfg(voltage_drive)]
    f(c)
    #[cfg(not(voltage_drive))]
    g(c)
}

// Dropped too.
/// Dropped.
#[cfg(all(wheel_driver, voltage_drive))]
#[inline]
fn dropped() {
    if true {
    }
}

/// Kept.
const A: i32 = 1;

#[cfg(test)]
mod tests {}
";

    #[test]
    fn what_a_bench_does_not_have_is_left_out() {
        let text = PLAIN.of_text(SOURCE).unwrap();
        let wanted = "\
//! A file.

use super::line::on_line;

/// A sample.
pub struct Sample {
    /// Of a converter.
    pub adc: u16,
}

/// Kept.
pub fn f(a: i32) -> i32 {
    let c = Line { a: 1 }.a;
    g(c)
}

/// Kept.
const A: i32 = 1;
";
        assert_eq!(text, wanted);
    }

    #[test]
    fn conditions_on_something_else_are_refused() {
        for bad in ["#[cfg(windows)]\nfn a() {}", "#[cfg(not(a, b))]\nfn a() {}"] {
            assert!(matches!(
                PLAIN.of_text(bad),
                Err(PartsError::Condition { line: 1, .. })
            ));
        }
        assert!(PLAIN.of_text("fn {").is_err());
    }

    #[test]
    fn every_name_is_known() {
        for parts in Parts::all() {
            assert!(Parts::NAMES.iter().all(|name| parts.has(name).is_some()));
        }
        assert_eq!(Parts::all().count(), 12);
    }
}
