//! C with one number, cast or operator changed. The test from bench to bench uses this file too.

/// What is damaged.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    Operators,
    /// Casts to 64 bits.
    Casts,
    Numbers,
}

/// The source with one number, cast or operator changed, and the line where that is.
pub fn mutants(source: &str, damage: Damage) -> Vec<(String, String)> {
    let mut found = vec![];
    let mut offset = 0;
    let mut is_comment = false;
    for line in source.split_inclusive('\n') {
        let code = line.trim_start();
        let starts = code.starts_with("/*");
        if !(starts || is_comment || code.starts_with('#') && !code.starts_with("#define")) {
            for (place, length, new) in changes(line, damage) {
                let at = offset + place;
                let text = format!("{}{new}{}", &source[..at], &source[at + length..]);
                found.push((format!("{} -> {new}", line.trim_end()), text));
            }
        }
        is_comment = (is_comment || starts) && !code.contains("*/");
        offset += line.len();
    }
    found
}

/// Place, length and replacement of everything in a line that can be changed.
fn changes(line: &str, damage: Damage) -> Vec<(usize, usize, String)> {
    let mut changes = vec![];
    if damage == Damage::Numbers {
        return changed_numbers(line);
    }
    for (old, new) in [
        (" + ", " - "),
        (" - ", " + "),
        (" * ", " + "),
        (" >> ", " << "),
        (" < ", " >= "),
        (" > ", " <= "),
        (" <= ", " > "),
        (" >= ", " < "),
        (" == ", " != "),
        (" && ", " || "),
        (" || ", " && "),
        ("(int64_t)", "(int32_t)"),
        ("!", ""),
    ] {
        for (place, _) in line.match_indices(old) {
            if (old == "(int64_t)") != (damage == Damage::Casts) {
                continue;
            }
            // One operand of 64 bits widens a product: only both casts of a product are a damage. A cast alone, in front of a
            // word of 32 bits, changes nothing where a product or a comparison follows.
            if damage == Damage::Casts {
                let rest = &line[place..];
                let product = rest.split([';', '+', ',']).next().unwrap_or(rest);
                if product.matches(old).count() == 2 && product.contains(" * ") {
                    changes.push((place, product.len(), product.replace(old, new)));
                }
                continue;
            }
            if old == " && " && only_saves_time(line) {
                continue;
            }
            changes.push((place, old.len(), new.to_string()));
        }
    }
    changes
}

/// Whether the line asks what the steps that scale a vector ask again, each for itself: where the first component alone is too
/// long, they change nothing.
fn only_saves_time(line: &str) -> bool {
    line.contains("scaling_is_within(v[0], INT32_C(0x4000000)) && ")
}

/// The same for the last digit of every number.
fn changed_numbers(line: &str) -> Vec<(usize, usize, String)> {
    let mut changes = vec![];
    let bytes = line.as_bytes();
    for place in 0..bytes.len() {
        let is_digit = |at: usize| bytes.get(at).is_some_and(u8::is_ascii_hexdigit);
        let is_name = |at: usize| bytes[at].is_ascii_alphanumeric() || bytes[at] == b'_';
        let is_last = bytes[place].is_ascii_digit() && !is_digit(place + 1);
        let start = (0..=place).rev().find(|&at| at == 0 || !is_name(at - 1));
        let is_number = start.is_some_and(|start| bytes[start].is_ascii_digit());
        let ends = bytes
            .get(place + 1)
            .is_none_or(|next| !next.is_ascii_alphabetic() || *next == b'u');
        // A longer array does the same.
        let is_length = start.is_some_and(|start| start > 0 && bytes[start - 1] == b'[')
            && line.contains("_t ");
        if only_saves_time(line) && line[..=place].ends_with("v[0") {
            continue;
        }
        if is_last && is_number && ends && !is_length && bytes.get(place + 1) != Some(&b'x') {
            let digit = if bytes[place] == b'9' {
                b'8'
            } else {
                bytes[place] + 1
            };
            changes.push((place, 1, char::from(digit).to_string()));
        }
    }
    changes
}
