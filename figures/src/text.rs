//! The estimated width of a text, and shortening and wrapping to a width.
//!
//! The font is known only where the figure is read, so widths are estimates
//! with the advances of DejaVu Sans, the widest of the fonts asked for: a text
//! that fits by this estimate fits with the narrower ones too.

/// Estimated width of `text` in pixels at the font size `size`.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    text.chars().map(advance).sum::<f64>() * size
}

fn advance(c: char) -> f64 {
    match c {
        'i' | 'l' | 'j' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' => 0.33,
        'I' | 'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '-' | '/' | '"' | '·' => 0.40,
        'm' | 'M' | 'w' | 'W' | '@' | '%' | '…' | 'Q' => 0.98,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '⁻' => 0.42,
        'A'..='Z' => 0.72,
        '+' | '×' | '±' | '=' | '<' | '>' | '≤' | '−' => 0.84,
        '\u{300}'..='\u{36f}' => 0.0,
        c if c < '\u{2E80}' => 0.63,
        _ => 1.0,
    }
}

/// `text` if it fits into `max_width` pixels, otherwise its beginning and "…".
pub(crate) fn shorten(text: &str, size: f64, max_width: f64) -> String {
    if width(text, size) <= max_width {
        return text.to_owned();
    }
    let mut used = advance('…') * size;
    let mut short = String::new();
    for c in text.chars() {
        used += advance(c) * size;
        if used > max_width {
            break;
        }
        short.push(c);
    }
    short.truncate(short.trim_end().len());
    short.push('…');
    short
}

/// Like [`shorten`], but leaves out the middle: names often differ in their
/// ends.
pub(crate) fn shorten_middle(text: &str, size: f64, max_width: f64) -> String {
    if width(text, size) <= max_width {
        return text.to_owned();
    }
    let head = shorten(text, size, max_width * 0.55);
    let mut room = max_width - width(&head, size);
    let mut start = text.len();
    for (index, c) in text.char_indices().rev() {
        room -= advance(c) * size;
        if room < 0.0 {
            break;
        }
        start = index;
    }
    head + &text[start..]
}

/// [`shorten_middle`] for several names, each with its own room. Where two names would become one, the beginning that all
/// have in common is left out first: what they differ in must stay.
pub(crate) fn shorten_apart(names: &[&str], size: f64, rooms: &[f64]) -> Vec<String> {
    let shortened = |names: &[String]| -> Vec<String> {
        let pairs = names.iter().zip(rooms);
        pairs
            .map(|(name, room)| shorten_middle(name, size, *room))
            .collect()
    };
    let plain = shortened(
        &names
            .iter()
            .map(|name| (*name).to_owned())
            .collect::<Vec<_>>(),
    );
    let collide = (0..names.len())
        .any(|k| (0..k).any(|other| plain[k] == plain[other] && names[k] != names[other]));
    if !collide {
        return plain;
    }
    let first = names.first().copied().unwrap_or_default();
    let common = names.iter().fold(first, |common, name| {
        let same = common.char_indices().zip(name.chars());
        let end = same
            .take_while(|((_, a), b)| a == b)
            .last()
            .map_or(0, |((index, c), _)| index + c.len_utf8());
        &common[..end]
    });
    // Whole words, so that a number keeps all its digits.
    let common = &common[..common.rfind([' ', '-', '_', '/']).map_or(0, |at| at + 1)];
    let rest = names
        .iter()
        .map(|name| format!("…{}", &name[common.len()..]));
    shortened(&rest.collect::<Vec<String>>())
}

/// `text` in lines of at most `max_width` pixels and at most `max_lines`
/// lines; breaks at spaces and after hyphens, and shortens what is too long.
pub(crate) fn wrap(text: &str, size: f64, max_width: f64, max_lines: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        if lines.len() + 1 >= max_lines {
            lines.push(shorten(rest, size, max_width));
            break;
        }
        let end = line_end(rest, size, max_width);
        lines.push(rest[..end].trim_end().to_owned());
        rest = rest[end..].trim_start();
    }
    lines
}

/// Byte index at which the first line of `text` ends.
fn line_end(text: &str, size: f64, max_width: f64) -> usize {
    let mut used = 0.0;
    let mut last_break = None;
    for (index, c) in text.char_indices() {
        used += advance(c) * size;
        if used > max_width && index > 0 {
            return last_break.unwrap_or(index);
        }
        let after = index + c.len_utf8();
        if c == ' ' || (c == '-' && index > 0 && !text[..index].ends_with(' ')) {
            last_break = Some(after);
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_that_differ_in_their_middle_stay_apart() {
        let names = [
            "swing number 01 of thirty/angle",
            "swing number 02 of thirty/angle",
        ];
        let short = shorten_apart(&names, 10.0, &[120.0, 120.0]);
        assert!(
            short[0].contains("01") && short[1].contains("02"),
            "{short:?}"
        );
        assert!(short.iter().all(|name| width(name, 10.0) <= 120.0 + 1e-9));
        // Names that stay apart keep their beginnings; equal names have nothing to differ in.
        let names = ["a long name of a swing", "another name of a coast-down"];
        let short = shorten_apart(&names, 10.0, &[80.0, 80.0]);
        assert!(
            short[0].starts_with("a lo") && short[1].starts_with("ano"),
            "{short:?}"
        );
        let same = shorten_apart(&[names[0], names[0]], 10.0, &[80.0, 80.0]);
        assert!(
            same[0] == same[1] && same[0].starts_with("a lo"),
            "{same:?}"
        );
    }

    proptest! {
        #[test]
        fn wrapped_lines_fit_and_lose_nothing(text in "[a-z é-]{0,80}", columns in 8usize..40) {
            let max_width = columns as f64 * 7.0;
            let lines = wrap(&text, 10.0, max_width, usize::MAX);
            for line in &lines {
                prop_assert!(width(line, 10.0) <= max_width + 1e-9);
            }
            let squeeze = |s: &str| s.split_whitespace().collect::<String>();
            prop_assert_eq!(squeeze(&lines.concat()), squeeze(&text));
        }

        #[test]
        fn shortened_text_fits(text in "\\PC{0,60}", max_width in 20.0..300.0f64) {
            for short in [shorten(&text, 10.0, max_width), shorten_middle(&text, 10.0, max_width)] {
                prop_assert!(width(&short, 10.0) <= max_width + 1e-9, "{}", short);
            }
        }
    }
}
