//! Damages the emitted source in many small ways and shows which engine notices.
//!
//! A mutant is one edit of one token in a function, constant or alias: a constant moved by one or
//! by a bit, a sign turned, an operator or comparison exchanged, a shift or index moved, a format
//! changed, two arguments or names swapped, a rounding, saturation or assignment dropped, a `let`
//! made conditional. Documentation is left alone. The manifest and the head of `src/lib.rs` are
//! damaged line by line.
//!
//! No compiler runs: a mutant that `rustc` would refuse counts as noticed only where an engine
//! notices it.

use std::collections::BTreeMap;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use serde::Serialize;

use crate::certificate::reader::Certificate;
use crate::claims::filter_exact::Draw;
use crate::domains::machine::Machine;
use crate::domains::smt::{self, Answer};
use crate::language::contracts::stated;
use crate::language::module::Module;
use crate::program::steps::Program;
use crate::prove::{Emitted, Outcome, Settings, settle};

/// One damaged source.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mutant {
    /// File.
    pub file: String,
    /// Line, from one.
    pub line: usize,
    /// Column, from one.
    pub column: usize,
    /// What was done.
    pub kind: &'static str,
    /// Text that was there.
    pub before: String,
    /// Text that is there now.
    pub after: String,
    /// Bytes of the file that were replaced.
    #[serde(skip)]
    range: (usize, usize),
}

/// What came of a mutant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The mutant.
    pub mutant: Mutant,
    /// Claims that fail and the engines that noticed; empty for a survivor.
    pub noticed: Vec<Notice>,
    /// What is known of it.
    pub fate: Fate,
    /// What is known of a survivor, as a sentence; empty for others, and where nothing is known.
    pub reason: String,
}

/// What is known of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// An engine noticed it.
    Caught,
    /// It survives, and z3 proves that it changes nothing.
    Same,
    /// It survives, and no difference was found in a random sample.
    NoDifferenceFound,
    /// It survives, and a difference was found or nothing could be compared: to be looked at.
    Unexplained,
}

impl Fate {
    /// As in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Fate::Caught => "caught",
            Fate::Same => "same",
            Fate::NoDifferenceFound => "no-difference-found",
            Fate::Unexplained => "unexplained",
        }
    }
}

/// A claim that fails.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Notice {
    /// Identifier of the claim.
    pub claim: String,
    /// What settled it.
    pub engine: &'static str,
}

/// A token with its place in the file.
#[derive(Clone, Debug)]
struct Token {
    text: String,
    start: usize,
    end: usize,
    line: usize,
    column: usize,
}

/// Byte offset of the start of each line.
fn line_starts(text: &str) -> Vec<usize> {
    let breaks = text.match_indices('\n').map(|(index, _)| index + 1);
    std::iter::once(0).chain(breaks).collect()
}

/// All tokens but those of attributes and documentation.
fn tokens(text: &str) -> Vec<Token> {
    fn collect(text: &str, lines: &[usize], stream: TokenStream, found: &mut Vec<Token>) {
        let mut skip_attribute = false;
        for tree in stream {
            if let TokenTree::Punct(punct) = &tree
                && punct.as_char() == '#'
            {
                skip_attribute = true;
                continue;
            }
            if skip_attribute {
                let is_bracket =
                    matches!(&tree, TokenTree::Group(g) if g.delimiter() == Delimiter::Bracket);
                skip_attribute = !is_bracket;
                continue;
            }
            let add = |found: &mut Vec<Token>, span: proc_macro2::Span| {
                let offset = |place: proc_macro2::LineColumn| {
                    let line = &text[lines[place.line - 1]..];
                    let bytes = line.char_indices().nth(place.column);
                    lines[place.line - 1] + bytes.map_or(line.len(), |(index, _)| index)
                };
                let (start, end) = (offset(span.start()), offset(span.end()));
                found.push(Token {
                    text: text[start..end].to_owned(),
                    start,
                    end,
                    line: span.start().line,
                    column: span.start().column + 1,
                });
            };
            match tree {
                TokenTree::Group(group) => {
                    add(found, group.span_open());
                    collect(text, lines, group.stream(), found);
                    add(found, group.span_close());
                }
                other => add(found, other.span()),
            }
        }
    }
    let mut found = Vec::new();
    if let Ok(stream) = text.parse::<TokenStream>() {
        collect(text, &line_starts(text), stream, &mut found);
    }
    join_operators(found)
}

/// `>` and `>` that touch are `>>`, and so on.
fn join_operators(tokens: Vec<Token>) -> Vec<Token> {
    let mut joined: Vec<Token> = Vec::new();
    for token in tokens {
        if let Some(last) = joined.last_mut()
            && last.end == token.start
        {
            let both = format!("{}{}", last.text, token.text);
            if [
                "<<", ">>", "<=", ">=", "==", "!=", "&&", "||", "->", "=>", "::",
            ]
            .contains(&both.as_str())
            {
                last.text = both;
                last.end = token.end;
                continue;
            }
        }
        joined.push(token);
    }
    joined
}

/// Every mutant of one file.
pub fn mutants(file: &str, text: &str) -> Vec<Mutant> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    let mut is_use = false;
    let mut is_assertion = false;
    for (index, token) in tokens.iter().enumerate() {
        // Imports and module declarations are names, not code. An assertion about constants
        // computes nothing that runs; the checker derives what it asserts by itself.
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

/// What runs on a mutant: no engine that some users do not have, none that takes minutes.
const SETTINGS: Settings = Settings {
    cases: 3_000,
    seed: 1,
    smt: false,
    kani: false,
    // It reads nothing of the source but the law, and that is compared before.
    closed_loop: false,
    filter_ranges: false,
    filter_length: false,
};

/// The claims that fail: the quick engines first, the slower only if these notice nothing.
pub fn notices(emitted: &Emitted, certificate: &Certificate) -> Vec<Notice> {
    let slower = Settings {
        cases: 1,
        filter_ranges: true,
        ..SETTINGS
    };
    let slowest = Settings {
        filter_length: true,
        ..slower
    };
    for settings in [SETTINGS, slower, slowest] {
        let found = failures(emitted, certificate, &settings);
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

fn failures(emitted: &Emitted, certificate: &Certificate, settings: &Settings) -> Vec<Notice> {
    settle(emitted, certificate, settings)
        .into_iter()
        .filter(|result| matches!(result.outcome, Outcome::Failed(_)))
        .map(|result| Notice {
            claim: result.id,
            engine: result.engine,
        })
        .collect()
}

/// Runs the engines on one mutant.
pub fn judged(emitted: &Emitted, certificate: &Certificate, mutant: Mutant) -> Verdict {
    let mut damaged = emitted.clone();
    if mutant.file == "Cargo.toml" {
        damaged.cargo = applied(&emitted.cargo, &mutant);
    }
    for (path, text) in &mut damaged.sources {
        if *path == mutant.file {
            *text = applied(text, &mutant);
        }
    }
    let noticed = notices(&damaged, certificate);
    let (fate, reason) = if noticed.is_empty() {
        compared(emitted, &damaged, &mutant).unwrap_or_else(|| (Fate::Unexplained, String::new()))
    } else {
        (Fate::Caught, String::new())
    };
    Verdict {
        mutant,
        noticed,
        fate,
        reason,
    }
}

/// Runs of one function before and after the damage.
const COMPARISONS: usize = 20_000;
/// Runs without an overflow before the damage that are enough to say something.
const ENOUGH: usize = 500;

/// How far up from the damaged function its callers are compared.
const MOST_CALLERS_UP: usize = 3;

/// The function with the damage against what it was before, for arguments within its contract:
/// first in runs that favour the places where pieces meet (numbers that stand in the function,
/// their neighbours, powers of two, ends of ranges), then, where these show no difference, by z3
/// for all arguments. Where the function differs, its callers are compared, who may never call it
/// with the arguments that make the difference. `None` where a difference remains, or nothing can be
/// compared.
fn compared(emitted: &Emitted, damaged: &Emitted, mutant: &Mutant) -> Option<(Fate, String)> {
    let (before, after) = (emitted.module().ok()?, damaged.module().ok()?);
    let number = function_at(&before, &mutant.file, mutant.line)?;
    alike(&before, &after, number, MOST_CALLERS_UP)
}

/// The function that stands at a line: the last that begins at or above it.
fn function_at(module: &Module, file: &str, line: usize) -> Option<usize> {
    let functions = &module.declarations().functions;
    (0..functions.len())
        .filter(|&number| {
            let place = &functions[number].place;
            *place.file == *file && place.line <= line
        })
        .max_by_key(|&number| functions[number].place.line)
}

/// The functions in whose text the name of function `number` stands.
fn callers(module: &Module, number: usize) -> Vec<usize> {
    let name = &module.declarations().functions[number].name;
    let name = name.rsplit("::").next().unwrap_or(name);
    let mut found: Vec<usize> = module
        .texts()
        .iter()
        .flat_map(|(file, text)| {
            tokens(text)
                .into_iter()
                .filter(|token| token.text == name)
                .filter_map(|token| function_at(module, file, token.line))
                .collect::<Vec<_>>()
        })
        .filter(|&caller| caller != number)
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

fn alike(before: &Module, after: &Module, number: usize, up: usize) -> Option<(Fate, String)> {
    let function = &before.declarations().functions[number];
    let (old, new) = (before.program(number)?, after.program(number)?);
    let contract = stated(before, number).unwrap_or_default();
    let ranges: Vec<(i128, i128)> = old
        .argument_types
        .iter()
        .enumerate()
        .map(|(word, type_)| {
            let required = contract.requires.iter().filter(|range| range.word == word);
            required.fold(type_.range(), |(low, high), range| {
                (low.max(range.low), high.min(range.high))
            })
        })
        .collect();
    let name = &function.name;
    match runs_alike(old, new, &ranges) {
        Some(_) if smt::is_available() && smt::same(old, new, &ranges) == Answer::Proved => {
            let text = format!("`{name}` returns the same words for all arguments (z3)");
            Some((Fate::Same, text))
        }
        Some(runs) if runs >= ENOUGH => {
            let text = format!("`{name}`: no difference found in {runs} runs aimed at its numbers");
            Some((Fate::NoDifferenceFound, text))
        }
        Some(_) => None,
        None if up == 0 => None,
        None => {
            let callers = callers(before, number);
            let mut all = (Fate::Same, Vec::new());
            for &caller in &callers {
                let (fate, text) = alike(before, after, caller, up - 1)?;
                if fate != Fate::Same {
                    all.0 = fate;
                }
                if !all.1.contains(&text) {
                    all.1.push(text);
                }
            }
            (!callers.is_empty()).then(|| {
                let text = format!(
                    "`{name}` differs for arguments that its callers do not pass: {}",
                    all.1.join("; ")
                );
                (all.0, text)
            })
        }
    }
}

/// In how many random runs two versions of a function return the same words; `None` where one does
/// not.
fn runs_alike(old: &Program, new: &Program, ranges: &[(i128, i128)]) -> Option<usize> {
    let constants = old.initial.iter().zip(&old.is_constant);
    let corners: Vec<i128> = constants
        .filter_map(|(word, is_constant)| is_constant.then_some(*word))
        .collect();
    let mut draw = Draw::new(SETTINGS.seed);
    let (mut old, mut new) = (Machine::new(old), Machine::new(new));
    let mut runs = 0;
    for _ in 0..COMPARISONS {
        let arguments: Vec<i128> = ranges
            .iter()
            .map(|&(low, high)| draw.at_corners(low, high, &corners))
            .collect();
        let Ok(wanted) = old.call(&arguments) else {
            continue;
        };
        if wanted != new.call(&arguments).ok()? {
            return None;
        }
        runs += 1;
    }
    Some(runs)
}

/// Mutants, caught and not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// How many there were.
    pub mutants: usize,
    /// How many were caught.
    pub caught: usize,
    /// How many survived and are proved to change nothing.
    pub same: usize,
    /// How many survived without a difference in a random sample.
    pub no_difference_found: usize,
    /// By the engine that noticed first.
    pub by_engine: BTreeMap<&'static str, usize>,
    /// Caught and all, by kind.
    pub by_kind: BTreeMap<&'static str, (usize, usize)>,
}

/// Adds up verdicts.
pub fn summary(verdicts: &[Verdict]) -> Summary {
    let mut summary = Summary {
        mutants: verdicts.len(),
        caught: 0,
        same: 0,
        no_difference_found: 0,
        by_engine: BTreeMap::new(),
        by_kind: BTreeMap::new(),
    };
    for verdict in verdicts {
        let (caught, all) = summary.by_kind.entry(verdict.mutant.kind).or_default();
        *all += 1;
        if let Some(first) = verdict.noticed.first() {
            *caught += 1;
            summary.caught += 1;
            *summary.by_engine.entry(first.engine).or_default() += 1;
        }
        match verdict.fate {
            Fate::Same => summary.same += 1,
            Fate::NoDifferenceFound => summary.no_difference_found += 1,
            Fate::Caught | Fate::Unexplained => {}
        }
    }
    summary
}
