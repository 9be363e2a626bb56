//! The text of a cell as a number: with a decimal point or comma, with groups of thousands, with a unit behind it.

use crate::clock::clock;
use crate::error::{Problem, shortened};
use crate::units_in_text::plain_unit;

/// Characters that separate thousands and are never a decimal mark.
const GROUPING: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];
/// Longest cell that is searched for a unit behind its number.
const LONGEST_WITH_UNIT: usize = 32;

/// A cell as a number.
///
/// # Errors
/// If the cell is empty, is not a number, or is one that can be read in two ways.
pub(crate) fn number(cell: &str, decimal_comma: bool) -> Result<f64, Box<Problem>> {
    // Where two files were joined, the mark of the second stands in the middle.
    let cell = cell.trim_start_matches('\u{feff}');
    if cell.is_empty() {
        return Err(Box::new(Problem::EmptyCell));
    }
    match plain(cell, decimal_comma).or_else(|| grouped(cell, decimal_comma)) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(Box::new(Problem::NotFinite {
            cell: shortened(cell),
        })),
        None => Err(Box::new(not_a_number(cell, decimal_comma))),
    }
}

/// Whether a cell is a number, with or without a unit behind it.
pub(crate) fn is_number(cell: &str, decimal_comma: bool) -> bool {
    plain(cell, decimal_comma)
        .or_else(|| grouped(cell, decimal_comma))
        .is_some()
        || with_unit(cell, decimal_comma).is_some()
}

/// A number without groups. Infinity and NaN are numbers here.
fn plain(cell: &str, decimal_comma: bool) -> Option<f64> {
    if !decimal_comma {
        return cell.parse().ok();
    }
    if cell.contains('.') {
        return None;
    }
    cell.replacen(',', ".", 1).parse().ok()
}

/// A number with groups of thousands: `1'234.5`, `1 234,5`, `1,234.5`. A point or a comma separates groups only where
/// nothing else is possible: beside the other mark, or twice. `1,234` alone has two readings.
fn grouped(cell: &str, decimal_comma: bool) -> Option<f64> {
    let (mark, other) = if decimal_comma {
        (',', '.')
    } else {
        ('.', ',')
    };
    let (sign, digits) = match cell.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", cell.strip_prefix('+').unwrap_or(cell)),
    };
    let (whole, decimals) = match digits.split_once(mark) {
        Some((whole, decimals)) => (whole, Some(decimals)),
        None => (digits, None),
    };
    let separator = whole.chars().find(|c| !c.is_ascii_digit())?;
    if separator != other && !GROUPING.contains(&separator) {
        return None;
    }
    let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let mut groups = whole.split(separator);
    let first = groups.next()?;
    let more: Vec<&str> = groups.collect();
    let is_first = (1..=3).contains(&first.len()) && are_digits(first) && !first.starts_with('0');
    let are_groups = more
        .iter()
        .all(|group| group.len() == 3 && are_digits(group));
    let is_certain = separator != other || more.len() > 1 || decimals.is_some();
    if !is_first || !are_groups || !is_certain || !decimals.is_none_or(are_digits) {
        return None;
    }
    let decimals = decimals.unwrap_or("0");
    format!("{sign}{first}{}.{decimals}", more.concat())
        .parse()
        .ok()
}

/// The number and the unit of a cell like `12.3 mA`. A time of day is a number of seconds.
pub(crate) fn with_unit(cell: &str, decimal_comma: bool) -> Option<(f64, &'static str)> {
    if cell.len() > LONGEST_WITH_UNIT {
        return None;
    }
    if let Some(seconds) = clock(cell) {
        return Some((seconds, "s"));
    }
    // The unit is the longest ending that is one: of "3 1/s" the whole fraction.
    cell.char_indices().skip(1).find_map(|(at, first)| {
        let (text, ending) = cell.split_at(at);
        // A digit belongs to the number, unless a space is between them.
        if first.is_ascii_digit() && !text.ends_with(' ') {
            return None;
        }
        let unit = plain_unit(ending)?;
        Some((number(text.trim_end(), decimal_comma).ok()?, unit))
    })
}

fn not_a_number(cell: &str, decimal_comma: bool) -> Problem {
    if !decimal_comma && let Some((whole, decimals)) = cell.split_once(',') {
        let digits = whole.trim_start_matches(['-', '+']);
        let are_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let is_group = (1..=3).contains(&digits.len()) && !digits.starts_with('0');
        if decimals.len() == 3 && is_group && are_digits(digits) && are_digits(decimals) {
            return Problem::TwoReadings {
                cell: shortened(cell),
                first: cell.replacen(',', ".", 1),
                second: cell.replacen(',', "", 1),
            };
        }
    }
    // As C, spreadsheets and databases write what is no number.
    let lower = cell.to_lowercase();
    let bare = lower.trim_start_matches(['-', '+']);
    let begins = ["nan(", "1.#", "#div", "#n/a", "#num", "#value"];
    if ["", "null", "none", "n/a", "na"].contains(&bare)
        || begins.iter().any(|begin| bare.starts_with(begin))
    {
        return Problem::NotFinite {
            cell: shortened(cell),
        };
    }
    let hint = if !decimal_comma && plain(cell, true).is_some() {
        " (a point, not a comma, before the decimals)"
    } else if decimal_comma && cell.contains('.') {
        " (the other numbers of this file have a comma before the decimals)"
    } else if cell.contains(':') && cell.starts_with(|c: char| c.is_ascii_digit()) {
        " (this is a date or a time of day; the other cells of the column are none: convert it to seconds)"
    } else {
        ""
    };
    Problem::NotANumber {
        cell: shortened(cell),
        hint,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_people_write_them() {
        for (cell, decimal_comma, expected) in [
            ("-0.0125", false, -0.0125),
            ("0,123", true, 0.123),
            ("1'234.5", false, 1234.5),
            ("1,234.5", false, 1234.5),
            ("-1,234,567", false, -1_234_567.0),
            ("1.234,5", true, 1234.5),
            ("1.234.567", true, 1_234_567.0),
            ("1 234,5", true, 1234.5),
            ("1\u{202f}234", false, 1234.0),
        ] {
            assert_eq!(number(cell, decimal_comma), Ok(expected), "{cell}");
        }
        for (cell, decimal_comma) in [
            ("1,234", false),
            ("0,123", false),
            ("1.234", true),
            ("1,23,456", false),
            ("1'23", false),
            ("12:30:05", false),
            ("3 mA", false),
        ] {
            assert!(number(cell, decimal_comma).is_err(), "{cell}");
        }
        let two = number("1,234", false).expect_err("two readings");
        assert!(matches!(*two, Problem::TwoReadings { .. }), "{two}");
    }

    #[test]
    fn units_behind_numbers() {
        for (cell, decimal_comma, expected) in [
            ("12.3 mA", false, (12.3, "mA")),
            ("12,3mA", true, (12.3, "mA")),
            ("-1e-3 rad/s", false, (-1e-3, "rad/s")),
            ("3 1/s", false, (3.0, "rev/s")),
            ("5°", false, (5.0, "deg")),
            ("7 [deg]", false, (7.0, "deg")),
        ] {
            assert_eq!(with_unit(cell, decimal_comma), Some(expected), "{cell}");
        }
        for cell in ["12.3", "mA", "51/s", "12.3 volts", "1e3"] {
            assert_eq!(with_unit(cell, false), None, "{cell}");
        }
    }
}
