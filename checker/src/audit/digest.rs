//! Digests of token streams: what rustc compiles, without comments, documentation, contracts and layout.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use sha2::{Digest, Sha256};

/// Files that contain the numbers of a bench.
const WITH_NUMBERS: [&str; 4] = [
    "src/constants.rs",
    "src/control.rs",
    "src/monitor_words.rs",
    "verify/src/modes.rs",
];

/// SHA-256 of the tokens of a file, in hexadecimal; `None` if the text does not consist of Rust tokens.
///
/// Documentation and contracts are left out. In the files with numbers, every integer that is a whole value
/// (`= 5;`, `[5, -6]`, `field: 5`) is replaced by the same symbol, together with its minus sign, and so is every
/// format `IxFy`.
pub fn of_file(path: &str, text: &str) -> Option<String> {
    let mut tokens = Vec::new();
    collect(text.parse().ok()?, &mut tokens);
    if WITH_NUMBERS.contains(&path) {
        tokens = without_numbers(tokens);
    }
    let mut hash = Sha256::new();
    for token in &tokens {
        hash.update(token.as_bytes());
        hash.update(b"\n");
    }
    let bytes = hash.finalize();
    Some(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Every token but those of documentation and contracts, groups opened and closed.
fn collect(stream: TokenStream, tokens: &mut Vec<String>) {
    let mut trees = stream.into_iter().peekable();
    while let Some(tree) = trees.next() {
        match tree {
            TokenTree::Punct(mark) if mark.as_char() == '#' => {
                let is_inner =
                    matches!(trees.peek(), Some(TokenTree::Punct(mark)) if mark.as_char() == '!');
                if is_inner {
                    trees.next();
                }
                if trees.peek().is_some_and(is_no_code) {
                    trees.next();
                } else {
                    tokens.push(if is_inner { "#!" } else { "#" }.to_owned());
                }
            }
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::None => ("", ""),
                };
                tokens.push(open.to_owned());
                collect(group.stream(), tokens);
                tokens.push(close.to_owned());
            }
            other => tokens.push(other.to_string()),
        }
    }
}

/// `[doc = "…"]`, the form of `/// …`, or a contract for Kani. rustc compiles neither, and contracts are proved again in
/// every run.
fn is_no_code(tree: &TokenTree) -> bool {
    let TokenTree::Group(group) = tree else {
        return false;
    };
    let parts: Vec<TokenTree> = group.stream().into_iter().collect();
    group.delimiter() == Delimiter::Bracket
        && match parts.as_slice() {
            [
                TokenTree::Ident(name),
                TokenTree::Punct(_),
                TokenTree::Literal(_),
            ] => name == "doc",
            [TokenTree::Ident(name), TokenTree::Group(list)] => {
                name == "cfg_attr" && is_contract(list.stream())
            }
            _ => false,
        }
}

/// `kani, kani::requires(…)`, with `any()` in place of the first word and `ensures` in place of the last, and nothing else:
/// any other attribute could take the item away, from a harness as well.
fn is_contract(list: TokenStream) -> bool {
    let words: Vec<String> = list.into_iter().map(|tree| tree.to_string()).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let rest = match words.as_slice() {
        ["kani", rest @ ..] | ["any", "()", rest @ ..] => rest,
        _ => return false,
    };
    match rest {
        [",", "kani", ":", ":", "requires" | "ensures", condition]
        | [
            ",",
            "kani",
            ":",
            ":",
            "requires" | "ensures",
            condition,
            ",",
        ] => condition.starts_with('('),
        _ => false,
    }
}

/// The tokens, with `0` for each integer that is a whole value, and `IxFy` for each format.
fn without_numbers(tokens: Vec<String>) -> Vec<String> {
    let is_integer = |token: &str| token.starts_with(|c: char| c.is_ascii_digit());
    let begins = |token: &str| ["=", "(", "[", ",", ":"].contains(&token);
    let ends = |token: &str| [";", ")", "]", ","].contains(&token);
    let mut kept: Vec<String> = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        let next = tokens.get(index + 1).map_or("", String::as_str);
        if is_integer(token) && ends(next) {
            let is_negative = kept.last().is_some_and(|last| last == "-");
            let before = kept.len().checked_sub(if is_negative { 2 } else { 1 });
            if before.is_some_and(|at| begins(&kept[at])) {
                if is_negative {
                    kept.pop();
                }
                kept.push("0".to_owned());
                continue;
            }
        }
        kept.push(if is_format(token) {
            "IxFy".to_owned()
        } else {
            token.clone()
        });
    }
    kept
}

/// `I3F29`
fn is_format(token: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
    token
        .strip_prefix('I')
        .and_then(|rest| rest.split_once('F'))
        .is_some_and(|(integer, fraction)| digits(integer) && digits(fraction))
}

#[cfg(test)]
mod tests {
    use super::of_file;

    /// Layout and documents do not count; every other token does; numbers only in the files of code.
    #[test]
    fn what_counts() {
        let text = "/// One.\npub fn f(a: i32) -> i32 { (a + 5) >> 1 }\n";
        let digest = |path: &str, text: &str| of_file(path, text).unwrap();
        let own = digest("src/root.rs", text);
        let other_layout = text
            .replace("{ ", "{\n    // Why.\n    ")
            .replace("One", "Two");
        assert_eq!(own, digest("src/root.rs", &other_layout));
        for (from, to) in [
            ("5", "6"),
            ("pub ", ""),
            ("+", "-"),
            (">> 1", ">> 1i32"),
            ("pub fn", "#[inline] pub fn"),
            ("a: i32", "a: i64"),
        ] {
            assert_ne!(own, digest("src/root.rs", &text.replace(from, to)), "{to}");
        }
        let contract = |attribute: &str| format!("{attribute}\n{text}");
        for no_code in [
            "#[cfg_attr(kani, kani::requires(a > 0))]",
            "#[cfg_attr(any(), kani::ensures(|r| *r > 0))]",
        ] {
            assert_eq!(own, digest("src/root.rs", &contract(no_code)), "{no_code}");
        }
        // What takes a harness away, or an item, is code.
        for code in [
            "#[cfg_attr(all(), cfg(any()))]",
            "#[cfg_attr(kani, cfg(not(kani)))]",
            "#![cfg_attr(kani, cfg(not(kani)))]",
            "#[cfg_attr(kani, kani::requires(true), cfg(any()))]",
            "#[cfg_attr(not(kani), kani::requires(true))]",
            "#[cfg_attr(any(x), kani::requires(true))]",
        ] {
            for path in ["src/root.rs", "verify/src/proofs.rs"] {
                assert_ne!(own, digest(path, &contract(code)), "{code}");
            }
        }
        let numbers = "pub const A: Line = Line { low: -5, ends: [1, 2] };\npub type T = fixed::types::I3F29;\nconst H: i64 = 1_i64 << (S - 1);\n";
        let own = digest("src/constants.rs", numbers);
        for (from, to) in [("-5", "7"), ("[1, 2]", "[-8, 9]"), ("I3F29", "I7F25")] {
            let other = numbers.replace(from, to);
            assert_eq!(own, digest("src/constants.rs", &other), "{to}");
        }
        for (from, to) in [
            ("S - 1", "S - 2"),
            ("[1, 2]", "[1, 2, 3]"),
            ("1_i64", "2_i64"),
            ("-5", "5 - 5"),
        ] {
            let other = numbers.replace(from, to);
            assert_ne!(own, digest("src/constants.rs", &other), "{to}");
        }
    }
}
