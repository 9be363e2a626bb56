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

/// What documentation names, as Rust and as C call it.
const NAMES: [(&str, &str); 6] = [
    ("`status()`", "`flywheel_status`"),
    ("`Running`", "`FLYWHEEL_RUNNING`"),
    ("`CURRENT_LIMIT`", "`FLYWHEEL_CURRENT_LIMIT`"),
    ("`madgwick::COMPONENT_MAX`", "`MADGWICK_COMPONENT_MAX`"),
    ("`COMPONENT_MAX`", "`MADGWICK_COMPONENT_MAX`"),
    ("`FIRST_UNIT`", "`SUPERVISOR_FIRST_UNIT`"),
];

/// A line of documentation with C's names, without Rust's links and without characters that would end a C comment.
fn plain(line: &str) -> String {
    let plain = line
        .replace("[`", "`")
        .replace("`]", "`")
        .replace("*/", "* /")
        .replace("super::", "")
        .replace("Controller::", "flywheel_");
    NAMES
        .iter()
        .fold(plain, |line, (rust, c)| line.replace(rust, c))
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

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn what_c_calls_otherwise_has_its_name_of_c() {
        assert_eq!(
            plain(
                "[`Controller::step`] while `status()` is not `Running`, within ±`CURRENT_LIMIT`"
            ),
            "`flywheel_step` while `flywheel_status` is not `FLYWHEEL_RUNNING`, within ±`FLYWHEEL_CURRENT_LIMIT`"
        );
        assert_eq!(
            plain("`madgwick::COMPONENT_MAX` and `FIRST_UNIT`"),
            "`MADGWICK_COMPONENT_MAX` and `SUPERVISOR_FIRST_UNIT`"
        );
    }
}
