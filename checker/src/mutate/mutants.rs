//! Every small damage to a source.

use serde::Serialize;

use crate::language::emitted::Emitted;
use crate::mutate::tokens::{Token, tokens};

/// One damaged source.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mutant {
    /// File.
    pub file: String,
    /// Line, from one.
    pub line: usize,
    /// Column, from one.
    pub column: usize,
    /// The kind of damage.
    pub kind: &'static str,
    /// The original text.
    pub before: String,
    /// The new text.
    pub after: String,
    /// The range of bytes in the file that was replaced.
    #[serde(skip)]
    range: (usize, usize),
}

/// Every mutant of one file.
pub fn mutants(file: &str, text: &str) -> Vec<Mutant> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    let mut is_use = false;
    let mut is_assertion = false;
    for (index, token) in tokens.iter().enumerate() {
        // Imports and module declarations are names, not code. An assertion about constants
        // computes nothing at run time; the checker derives what it asserts separately.
        match token.text.as_str() {
            "use" | "mod" => is_use = true,
            "_" if index > 0 && tokens[index - 1].text == "const" => is_assertion = true,
            "}" if is_assertion && tokens.get(index + 1).is_some_and(|t| t.text == ";") => {
                is_assertion = false;
            }
            ";" => is_use = false,
            _ => {}
        }
        if is_use || is_assertion {
            continue;
        }
        let previous = index.checked_sub(1).map_or("", |i| tokens[i].text.as_str());
        let next = tokens
            .get(index + 1)
            .map_or("", |token| token.text.as_str());
        let mut replace = |kind, after: String, start: usize, end: usize| {
            found.push(Mutant {
                file: file.to_owned(),
                line: token.line,
                column: token.column,
                kind,
                before: text[start..end].to_owned(),
                after,
                range: (start, end),
            });
        };
        if token.text.starts_with(|c: char| c.is_ascii_digit()) {
            number(token, previous, next, &mut replace);
        } else {
            symbol(token, previous, &mut replace);
        }
        // a, b inside parentheses or brackets: swapped.
        if token.text == ","
            && index > 0
            && is_operand(&tokens[index - 1].text)
            && tokens.get(index + 1).is_some_and(|t| is_operand(&t.text))
            && tokens
                .get(index.wrapping_sub(2))
                .is_some_and(|t| ["(", "[", ","].contains(&t.text.as_str()))
            && tokens
                .get(index + 2)
                .is_some_and(|t| [")", "]", ","].contains(&t.text.as_str()))
            && tokens[index - 1].text != tokens[index + 1].text
            && !is_product(&tokens, index)
        {
            let (a, b) = (&tokens[index - 1], &tokens[index + 1]);
            let swapped = format!("{}{}{}", b.text, &text[a.end..b.start], a.text);
            replace("swapped arguments", swapped, a.start, b.end);
        }
        // Another spelling of a name, and a receiver that says what it is.
        if token.text == "let" && is_operand(next) && next != "mut" {
            let name = &tokens[index + 1];
            replace("name", format!("r#{}", name.text), name.start, name.end);
        }
        if token.text == "self" && ["&", "mut"].contains(&previous) {
            let start = tokens[..index].iter().rposition(|token| token.text == "&");
            if let Some(start) = start.filter(|start| index - start <= 2) {
                let from = tokens[start].start;
                let after = format!("self: {}Self", &text[from..token.start]);
                replace("receiver", after, from, token.end);
            }
        }
        // What stands under `cfg` is not there; an assignment may be missing.
        if token.text == "let" {
            let after = "#[cfg(any())] let".to_owned();
            replace("conditional compilation", after, token.start, token.end);
        }
        if token.text == "self" && [";", "{", "}"].contains(&previous) {
            let end = tokens[index..].iter().find(|token| token.text == ";");
            if let Some(end) = end.filter(|end| !text[token.start..end.end].contains('{')) {
                let dropped = String::new();
                replace("dropped assignment", dropped, token.start, end.end);
            }
        }
        // + NAME and .clamp(…) dropped.
        if token.text == "+" && next == "HALF_UNIT" {
            replace(
                "dropped rounding",
                String::new(),
                token.start,
                tokens[index + 1].end,
            );
        }
        if token.text == "clamp" && next == "(" && previous == "." {
            let mut depth = 0;
            let close = tokens[index + 1..].iter().find(|token| {
                depth += i32::from(token.text == "(") - i32::from(token.text == ")");
                depth == 0
            });
            if let Some(close) = close {
                replace(
                    "dropped saturation",
                    String::new(),
                    tokens[index - 1].start,
                    close.end,
                );
            }
        }
    }
    found
}

/// Whether the comma stands in `mul_high(a, b)`, whose arguments may be swapped.
fn is_product(tokens: &[Token], comma: usize) -> bool {
    comma
        .checked_sub(3)
        .is_some_and(|name| tokens[name].text == "mul_high")
}

fn is_operand(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')
}

fn number(
    token: &Token,
    previous: &str,
    next: &str,
    replace: &mut impl FnMut(&'static str, String, usize, usize),
) {
    let plain: String = token.text.chars().filter(|c| *c != '_').collect();
    let digits = plain.trim_end_matches("i64").trim_end_matches("i32");
    let suffix = &plain[digits.len()..];
    let value = match digits.strip_prefix("0x") {
        Some(hex) => i128::from_str_radix(hex, 16),
        None => digits.parse(),
    };
    let Ok(value) = value else {
        return;
    };
    let mut to = |kind, value: i128| {
        replace(kind, format!("{value}{suffix}"), token.start, token.end);
    };
    if previous == "[" && next == "]" {
        to("index", if value == 0 { 1 } else { value - 1 });
    } else if [">>", "<<"].contains(&previous) {
        to("shift", value + 1);
        if value > 0 {
            to("shift", value - 1);
        }
    } else {
        to("constant", value + 1);
        if value > 0 {
            to("constant", value - 1);
        }
        if value > 1_000 {
            to("constant, one bit", value ^ (1 << 9));
        }
        if value > 1 {
            to("constant, half", value / 2);
        }
        if value > 0 && previous != "-" && previous != "." {
            replace("sign", format!("-{}", token.text), token.start, token.end);
        }
    }
}

fn symbol(
    token: &Token,
    previous: &str,
    replace: &mut impl FnMut(&'static str, String, usize, usize),
) {
    let is_binary = is_operand(previous) || [")", "]"].contains(&previous);
    let others: &[(&'static str, &str)] = match token.text.as_str() {
        "+" => &[("sign", "-")],
        "-" if is_binary => &[("sign", "+")],
        "-" => &[("sign", "")],
        "*" if is_binary => &[("operator", "+")],
        ">>" => &[("operator", "<<")],
        "<<" => &[("operator", ">>")],
        "<" if is_binary => &[("comparison", "<="), ("comparison", ">")],
        ">" if is_binary => &[("comparison", ">="), ("comparison", "<")],
        "<=" => &[("comparison", "<")],
        ">=" => &[("comparison", ">")],
        "==" => &[("comparison", "!=")],
        "&&" => &[("condition", "||")],
        "||" => &[("condition", "&&")],
        "!" if previous != "assert" => &[("condition", "")],
        "true" => &[("condition", "false")],
        "false" => &[("condition", "true")],
        "ANGLE_GAIN" => &[("swapped name", "RATE_GAIN")],
        "RATE_GAIN" => &[("swapped name", "WHEEL_SPEED_GAIN")],
        "WHEEL_SPEED_GAIN" => &[("swapped name", "ANGLE_GAIN")],
        "angle" if previous != "." => &[("swapped axis", "rate")],
        "rate" if previous != "." => &[("swapped axis", "wheel_speed")],
        "wheel_speed" if previous != "." => &[("swapped axis", "angle")],
        "gyro" => &[("swapped axis", "accel")],
        "accel" => &[("swapped axis", "gyro")],
        "mag" => &[("swapped axis", "accel")],
        "x" if previous != "." => &[("swapped axis", "y")],
        "y" if previous != "." => &[("swapped axis", "z")],
        "z" if previous != "." => &[("swapped axis", "x")],
        // What the reader reads: types, receivers, visibility.
        "i16" => &[("type", "u16")],
        "u16" => &[("type", "i16")],
        "i32" => &[("type", "i64"), ("type", "u32")],
        "i64" => &[("type", "i32")],
        "u32" => &[("type", "i32")],
        "bool" => &[("type", "i32")],
        "mut" if previous == "&" => &[("receiver", "")],
        "pub" => &[("visibility", ""), ("visibility", "pub(crate)")],
        _ => &[],
    };
    for (kind, after) in others {
        replace(kind, (*after).to_owned(), token.start, token.end);
    }
    if let Some(bits) = token.text.strip_prefix('I').and_then(|rest| {
        let (_, fraction) = rest.split_once('F')?;
        fraction.parse::<u32>().ok()
    }) {
        for other in [bits.saturating_sub(1), bits + 1] {
            if other <= 32 && other != bits {
                let after = format!("I{}F{other}", 32 - other);
                replace("format", after, token.start, token.end);
            }
        }
    }
}

/// The text with the mutant in it.
pub fn applied(text: &str, mutant: &Mutant) -> String {
    let (start, end) = mutant.range;
    format!("{}{}{}", &text[..start], mutant.after, &text[end..])
}

/// Damages to what surrounds the code: `Cargo.toml` and the attributes and modules of
/// `src/lib.rs`.
fn surroundings(emitted: &Emitted) -> Vec<Mutant> {
    let edits: [(&str, &str, &'static str); 10] = [
        ("#![no_std]", "", "attribute"),
        ("#![forbid(unsafe_code)]", "", "attribute"),
        (
            "#![forbid(unsafe_code)]",
            "#![allow(unsafe_code)]",
            "attribute",
        ),
        ("pub mod control;", "", "module"),
        (
            "pub mod control;",
            "#[path = \"controller.rs\"]\npub mod control;",
            "module",
        ),
        ("pub mod control;", "mod control;", "module"),
        (
            "default-features = false",
            "default-features = true",
            "manifest",
        ),
        (
            "[dependencies]",
            "[dependencies]\nlibm = \"0.2\"",
            "manifest",
        ),
        (
            "unsafe_code = \"forbid\"",
            "unsafe_code = \"allow\"",
            "manifest",
        ),
        (
            "[dependencies]",
            "build = \"build.rs\"\n[dependencies]",
            "manifest",
        ),
    ];
    let manifest = ("Cargo.toml".to_owned(), emitted.cargo.clone());
    let root = emitted
        .sources
        .iter()
        .filter(|(path, _)| path == "src/lib.rs");
    let mut found = Vec::new();
    for (file, text) in root.chain([&manifest]) {
        for (before, after, kind) in edits {
            let Some(start) = text.find(before) else {
                continue;
            };
            let above = &text[..start];
            found.push(Mutant {
                file: file.clone(),
                line: above.matches('\n').count() + 1,
                column: start - above.rfind('\n').map_or(0, |end| end + 1) + 1,
                kind,
                before: before.to_owned(),
                after: after.to_owned(),
                range: (start, start + before.len()),
            });
        }
    }
    found
}

/// The mutants of an emitted crate: all, or at most so many of each file, evenly spread.
pub fn chosen(emitted: &Emitted, most: Option<usize>) -> Vec<Mutant> {
    let mut chosen = surroundings(emitted);
    for (path, text) in &emitted.sources {
        let all = mutants(path, text);
        let count = most.map_or(all.len(), |most| most.min(all.len()));
        chosen.extend((0..count).map(|index| all[index * all.len() / count].clone()));
    }
    chosen
}
