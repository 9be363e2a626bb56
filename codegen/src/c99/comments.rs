//! Documentation of Rust as comments of C.

use syn::{Attribute, Expr, Lit, Meta};

/// The lines of the documentation.
pub fn lines(attributes: &[Attribute]) -> Vec<String> {
    let mut lines = vec![];
    for attribute in attributes {
        let Meta::NameValue(pair) = &attribute.meta else {
            continue;
        };
        if !pair.path.is_ident("doc") {
            continue;
        }
        if let Expr::Lit(text) = &pair.value
            && let Lit::Str(text) = &text.lit
        {
            for line in text.value().lines() {
                let line = line.strip_prefix(' ').unwrap_or(line);
                lines.push(plain(line));
            }
        }
    }
    lines
}

/// A line of documentation without Rust's links and without characters that would end a C comment.
fn plain(line: &str) -> String {
    line.replace("[`", "`")
        .replace("`]", "`")
        .replace("*/", "* /")
        .replace("super::", "")
        .replace("Controller::", "flywheel_")
}

/// A comment before a declaration; empty if there is no documentation.
pub fn before(lines: &[String], indent: &str) -> String {
    match lines {
        [] => String::new(),
        [one] => format!("{indent}/* {one} */\n"),
        [first, rest @ ..] => {
            let mut text = format!("{indent}/* {first}\n");
            for line in rest {
                text.push_str(format!("{indent} * {line}").trim_end());
                text.push('\n');
            }
            text + &format!("{indent} */\n")
        }
    }
}
