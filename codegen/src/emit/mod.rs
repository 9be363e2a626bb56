//! From [`crate::ir`] to text: one module for each emitted file.
//!
//! # The language of the emitted code
//! Emitted Rust keeps to the constructs below, so that a checker can read all of it and refuse
//! anything else. Whoever extends the generator extends this list first.
//!
//! - Files: inner attributes `no_std`, `forbid(…)`, `warn(…)`; documentation; `pub mod name;`;
//!   `pub use path::{names};`.
//! - Items: `pub type Name = fixed::types::IxFy;`; `const NAME: T = expression;` with T one of
//!   `i32`, `i64`, `u32` or an alias; `const _: () = { let …; assert!(condition, "message"); };`,
//!   where alone `as i128`, `i64::MAX` and `.abs()` may stand; `pub fn` with typed arguments and
//!   no generics.
//! - Statements: `let name = expression;` and a final expression.
//! - Expressions: integer literals with a leading minus; names; `+`, `-`, `*`, `<<` and `>>` by a
//!   constant; comparison; unary minus; parentheses; `i64::from(x)`; `x.to_bits()` and
//!   `Alias::from_bits(x)` of the `fixed` types; `x.clamp(low, high)` with constant bounds;
//!   `x as i32` of a value clamped to the range of an `i32`.
//!
//! A literal whose type differs from that of the other operand carries its type, as in `1_i64 << SHIFT`, so that a
//! checker needs no type inference. Code is ASCII; names have one spelling.
//!
//! In this language every `i64` operation is meant to be exact: overflow is excluded, not wrapped.
//! Runtime helpers (`codegen/runtime/`) are hand-written and may in addition use:
//!
//! - Files: `use super::module::{names};`, `#[inline]`, `#[derive(…)]` and contracts under
//!   `#[cfg_attr(kani, …)]` (proved by Kani and by the checker) or `#[cfg_attr(any(), …)]` (by the checker
//!   alone), which are not code of the module.
//! - Items: `pub enum` whose variants have no fields and the values 0, 1, … as written; compared and
//!   built by their names.
//! - Items: `pub struct` with named fields or one unnamed field, `impl` with `new`, methods on
//!   `&self` and `&mut self`, `impl Default`; constants of struct type.
//! - Types: `i16`, `u16`, `i32`, `i64`, `u32`, `bool`, arrays of two to four `i32` or `i16`,
//!   the structs, references to them as arguments, `Option<[i16; 3]>` in one field, and a pair as
//!   the result of one function.
//! - Statements: `let` of a name or of a tuple of names, assignment to a field of `self`,
//!   `if condition { return expression; }`, a final expression.
//! - Expressions: `if`/`else` with values; `&&`, `||`, `!`; array and struct literals; tuples;
//!   an index that is a literal; a field; calls of the helpers; widening `as i32`, `as i64`;
//!   narrowing `as i32` and `as u16` of a value that is in range, and `as i32` of the upper word
//!   `(x >> 32)`; `&` with 1; shifts by a constant or by a field of a constant; `match` on the
//!   one option.
//! - No loop, no recursion, no wrapping or saturating arithmetic, no division.

use proc_macro2::TokenStream;
use quote::quote;

use crate::file::MARK;
use crate::spec::ModuleSpec;

mod body_constants_rs;
pub mod cargo_toml;
pub mod certificate;
mod certificate_hardware;
mod constants_parts;
pub mod constants_rs;
pub mod control_rs;
mod example;
mod inertial_constants_rs;
pub mod lib_rs;
pub mod modes_rs;
pub mod monitor_rs;
pub mod readme;

/// The header line of an emitted file, without comment sign.
fn header(spec: &ModuleSpec) -> String {
    format!(
        "{MARK} from the model \"{}\"; do not edit",
        single_line(&spec.model_name)
    )
}

/// Prints an emitted Rust file.
fn print(spec: &ModuleSpec, tokens: TokenStream) -> String {
    let file: syn::File =
        syn::parse2(tokens).expect("the tokens quoted in this crate form a Rust file");
    // prettyplease leaves no empty lines between items, so each is printed alone.
    let mut blocks = vec![syn::File {
        items: Vec::new(),
        ..file.clone()
    }];
    blocks.extend(file.items.into_iter().map(|item| syn::File {
        shebang: None,
        frontmatter: None,
        attrs: Vec::new(),
        items: vec![item],
    }));
    let blocks: Vec<_> = blocks.iter().map(prettyplease::unparse).collect();
    with_header(spec, &blocks.join("\n"))
}

/// `source` under the header line of an emitted Rust file.
pub(crate) fn with_header(spec: &ModuleSpec, source: &str) -> String {
    format!("// {}.\n\n{source}", header(spec))
}

/// `///` lines.
fn outer_docs<T: AsRef<str>>(lines: &[T]) -> TokenStream {
    let lines = lines.iter().map(|line| doc_text(line.as_ref()));
    quote!(#(#[doc = #lines])*)
}

/// `//!` lines.
fn inner_docs<T: AsRef<str>>(lines: &[T]) -> TokenStream {
    let lines = lines.iter().map(|line| doc_text(line.as_ref()));
    quote!(#(#![doc = #lines])*)
}

fn doc_text(line: &str) -> String {
    if line.is_empty() {
        String::new()
    } else {
        format!(" {line}")
    }
}

/// Text from outside on one line and without characters that Markdown or a comment would read.
fn single_line(text: &str) -> String {
    text.chars()
        .map(|c| {
            if c.is_control() || "`\"\\<>[]|".contains(c) {
                ' '
            } else {
                c
            }
        })
        .collect()
}

/// An integer literal with its digits in groups of three.
fn integer(value: i64) -> TokenStream {
    let digits = value.unsigned_abs().to_string();
    let mut grouped = String::with_capacity(digits.len() * 4 / 3 + 1);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push('_');
        }
        grouped.push(digit);
    }
    let literal = syn::LitInt::new(&grouped, proc_macro2::Span::call_site());
    if value < 0 {
        quote!(-#literal)
    } else {
        quote!(#literal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_grouped() {
        let cases = [
            (0, "0"),
            (999, "999"),
            (1_000, "1_000"),
            (-1_073_741_824, "- 1_073_741_824"),
            (i64::MIN, "- 9_223_372_036_854_775_808"),
        ];
        for (value, text) in cases {
            assert_eq!(integer(value).to_string(), text);
        }
    }

    #[test]
    fn foreign_text_cannot_leave_its_line() {
        assert_eq!(single_line("a\n\"b\"\u{7f}`c`"), "a  b   c ");
    }
}
