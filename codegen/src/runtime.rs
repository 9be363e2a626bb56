//! Copies hand-written helpers into the output.
//!
//! A helper is an ordinary Rust file in `codegen/runtime/`. It is compiled in [`crate::helpers`],
//! so that `codegen/tests/` can test it. Its text is copied with comments and layout unchanged,
//! but without its `#[cfg(test)]` items. To add one, append it to [`HELPERS`], to
//! [`crate::helpers`] and to the list in [`crate::emit::lib_rs`].

use syn::spanned::Spanned;

use crate::emit;
use crate::file::EmittedFile;
use crate::spec::ModuleSpec;

/// A hand-written file and its place in the emitted crate.
#[derive(Debug, Clone, Copy)]
pub struct Helper {
    /// Path inside the emitted crate.
    pub path: &'static str,
    /// Text of the file in `codegen/runtime/`.
    pub source: &'static str,
}

/// The helper in a file of `codegen/runtime/`.
macro_rules! helper {
    ($name:literal) => {
        Helper {
            path: concat!("src/", $name),
            source: include_str!(concat!("../runtime/", $name)),
        }
    };
}

impl Helper {
    /// The file as it is emitted: header, then the text without its tests.
    ///
    /// # Errors
    /// The error of `syn` if the text is not Rust. A test of this crate shows that every helper
    /// parses.
    pub fn file(&self, spec: &ModuleSpec) -> Result<EmittedFile, syn::Error> {
        Ok(EmittedFile {
            path: self.path.to_owned(),
            contents: emit::with_header(spec, &without_tests(self.source)?),
        })
    }
}

/// Every helper of each emitted crate.
pub const HELPERS: [Helper; 15] = [
    helper!("arc_tangent.rs"),
    helper!("attitude.rs"),
    helper!("bias_observer.rs"),
    helper!("calibration.rs"),
    helper!("controller.rs"),
    helper!("drift.rs"),
    helper!("filter.rs"),
    helper!("lever_arm.rs"),
    helper!("line.rs"),
    helper!("madgwick.rs"),
    helper!("pivot_angle.rs"),
    helper!("product.rs"),
    helper!("root.rs"),
    helper!("scaling.rs"),
    helper!("supervisor.rs"),
];

/// The helpers of a crate with a monitor, beside [`HELPERS`].
pub const MONITOR_HELPERS: [Helper; 2] = [helper!("monitor.rs"), helper!("motion.rs")];

/// Helpers as they are emitted.
pub fn emitted(helpers: &[Helper], spec: &ModuleSpec) -> Vec<EmittedFile> {
    helpers
        .iter()
        .map(|helper| {
            helper
                .file(spec)
                .expect("every helper parses; a test of this module says so")
        })
        .collect()
}

/// `source` without its items under `#[cfg(test)]`.
fn without_tests(source: &str) -> Result<String, syn::Error> {
    let file = syn::parse_file(source)?;
    let mut dropped = vec![false; source.lines().count()];
    for item in &file.items {
        if attributes(item).iter().any(is_cfg_test) {
            // Lines count from one; the end line belongs to the item.
            let span = item.span();
            dropped[span.start().line - 1..span.end().line].fill(true);
        }
    }
    let kept = source.lines().zip(dropped).filter(|(_, dropped)| !dropped);
    let mut text = String::with_capacity(source.len());
    for (line, _) in kept {
        text.push_str(line);
        text.push('\n');
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    Ok(text)
}

fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        syn::Item::Const(item) => &item.attrs,
        _ => &[],
    }
}

fn is_cfg_test(attribute: &syn::Attribute) -> bool {
    let mut found = false;
    if attribute.path().is_ident("cfg") {
        // `cfg(not(test))` and the like are not entered, so `found` stays false for them.
        let _ = attribute.parse_nested_meta(|meta| {
            found |= meta.path.is_ident("test");
            Ok(())
        });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "//! Rounding.

use core::cmp::min;

/// Smaller of two.
pub fn smaller(a: i32, b: i32) -> i32 {
    // Why: a comment stays.
    min(a, b)
}

#[cfg(not(test))]
const KEPT: i32 = 1;

#[cfg(test)]
mod tests {
    #[test]
    fn left_behind() {}
}
";

    #[test]
    fn every_helper_parses_and_is_formatted() {
        for helper in HELPERS.into_iter().chain(MONITOR_HELPERS) {
            let carried = without_tests(helper.source).unwrap();
            assert_eq!(carried, helper.source, "{}", helper.path);
        }
    }

    #[test]
    fn comments_stay_and_tests_do_not() {
        let carried = without_tests(SOURCE).unwrap();
        let (expected, _) = SOURCE.split_once("\n#[cfg(test)]").unwrap();
        assert_eq!(carried, expected);
        assert!(without_tests("fn {").is_err());
    }
}
