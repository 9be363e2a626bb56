//! The dialect of a text file with a table: encoding, separator, decimal mark, and which line is the header.
//! It is found from the first 64 KiB: the dialect with which most cells are numbers.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use crate::cell::is_number;
use crate::units_in_text::plain_unit;

/// Number of bytes at the beginning of a file that are examined.
pub(crate) const LOOKED_AT: usize = 64 << 10;
/// Number of lines that are examined.
const LINES: usize = 400;
/// The byte order mark that some editors write before UTF-8 text.
const BYTE_ORDER_MARK: &str = "\u{feff}";
/// Number of consecutive lines that mark the beginning of the samples.
const RUN: usize = 4;
/// Largest length of a cell in a line of units; a longer one is text.
const LONGEST_UNIT: usize = 12;

/// The dialect of a file, from its first bytes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dialect {
    pub encoding: &'static Encoding,
    pub separator: u8,
    /// Whether the decimal mark is a comma.
    pub decimal_comma: bool,
    /// Number of lines before the header line, or before the first sample if there is no header.
    pub lines_before: u64,
    /// The last byte of every line: an old Macintosh ends its lines with a carriage return alone.
    pub line_end: u8,
    pub header: Header,
}

/// The names of the columns.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Header {
    /// They are in the first line that is read; a line of units may follow.
    Line { units: bool },
    /// There are no names, but this many columns.
    None { columns: usize },
}

/// A file that can be read in two ways.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TwoReadings {
    /// Number of the line.
    pub line: u64,
    /// The cell.
    pub cell: String,
    pub first: String,
    pub second: String,
}

/// The encoding of a file with these first bytes. A byte order mark decides. UTF-16 without a mark has a zero in every
/// other byte. Anything that is not UTF-8 is the code page of western Windows, unless it has bytes that no text has.
pub(crate) fn encoding(bytes: &[u8]) -> &'static Encoding {
    if let Some((encoding, _)) = Encoding::for_bom(bytes) {
        return encoding;
    }
    let zeros = |first: usize| {
        let every_other = bytes.iter().skip(first).step_by(2);
        every_other.clone().filter(|byte| **byte == 0).count() * 10 > every_other.count() * 9
    };
    if bytes.len() >= 4 && zeros(1) {
        return UTF_16LE;
    }
    if bytes.len() >= 4 && zeros(0) {
        return UTF_16BE;
    }
    let is_utf_8 = match std::str::from_utf8(bytes) {
        Ok(_) => true,
        // The last character is incomplete.
        Err(error) => error.error_len().is_none(),
    };
    let is_text = |byte: &u8| *byte >= 0x20 || matches!(byte, b'\t' | b'\n' | b'\r');
    if !is_utf_8 && bytes.iter().all(is_text) {
        return WINDOWS_1252;
    }
    UTF_8
}

/// Finds the dialect from the first bytes of a file.
pub(crate) fn dialect(bytes: &[u8]) -> Result<Dialect, Box<TwoReadings>> {
    let encoding = encoding(bytes);
    let (text, _, _) = encoding.decode(bytes);
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
    // The last line may be incomplete.
    let whole = if bytes.len() < LOOKED_AT {
        text
    } else {
        text.rsplit_once(['\n', '\r'])
            .map_or(text, |(whole, _)| whole)
    };
    let mut stated = None;
    let mut lines: Vec<(u64, &str)> = vec![];
    let line_end = if whole.contains('\n') { '\n' } else { '\r' };
    for (index, line) in whole.split(line_end).enumerate().take(LINES) {
        let line = line.trim_end_matches('\r');
        let trimmed = line.trim();
        if lines.is_empty()
            && let Some(separator) = trimmed.strip_prefix("sep=")
        {
            stated = separator.bytes().next().or(Some(b'\t'));
            continue;
        }
        if !trimmed.is_empty() && !trimmed.starts_with('#') {
            lines.push((index as u64, line));
        }
    }
    let usual = Dialect {
        encoding,
        separator: stated
            .unwrap_or_else(|| usual_separator(lines.first().map_or("", |line| line.1))),
        decimal_comma: false,
        lines_before: lines.first().map_or(0, |line| line.0),
        line_end: if line_end == '\n' { b'\n' } else { b'\r' },
        header: Header::Line { units: false },
    };
    let Some((separator, decimal_comma)) = best_style(&lines, stated, usual.separator) else {
        return Ok(usual);
    };
    let usual = Dialect {
        separator,
        decimal_comma,
        ..usual
    };
    if decimal_comma {
        thousands(&lines, separator)?;
    }
    Ok(with_header(&lines, usual))
}

/// The most frequent separator of a line; a comma if there is none.
fn usual_separator(line: &str) -> u8 {
    let count = |separator: u8| line.bytes().filter(|byte| *byte == separator).count();
    [b',', b';', b'\t']
        .into_iter()
        .rev()
        .max_by_key(|separator| count(*separator))
        .unwrap_or(b',')
}

/// The cells of a line. A separator between quotation marks is part of its cell.
fn cells(line: &str, separator: u8) -> Vec<&str> {
    // An odd number of quotation marks are inches.
    let is_in_pairs = line.bytes().filter(|byte| *byte == b'"').count() % 2 == 0;
    let mut is_quoted = false;
    let cells = line.split(move |c: char| {
        is_quoted ^= c == '"' && is_in_pairs;
        c == char::from(separator) && !is_quoted
    });
    cells
        .map(|cell| cell.trim().trim_matches('"').trim())
        .collect()
}

/// The separator and decimal mark with which most cells below the first line are numbers. If several are equal, the
/// separator of the first line and the decimal point are preferred.
fn best_style(lines: &[(u64, &str)], stated: Option<u8>, usual: u8) -> Option<(u8, bool)> {
    let styles: [(u8, bool); 9] = [
        (usual, false),
        (b',', false),
        (b';', false),
        (b'\t', false),
        (b';', true),
        (b'\t', true),
        // Every number with decimals is in quotation marks.
        (b',', true),
        (b'|', false),
        (b' ', false),
    ];
    let below = lines.get(1..)?;
    // The share of numbers, in the lines that contain any.
    let share = |(separator, decimal_comma): (u8, bool)| -> f64 {
        let (mut numbers, mut all, mut has_mark) = (0, 0, false);
        for (_, line) in below {
            let cells = cells(line, separator);
            let good = cells.iter().filter(|cell| is_number(cell, decimal_comma));
            let good = good.inspect(|cell| has_mark |= cell.contains(',')).count();
            // A line with a single cell does not show the separator.
            if cells.len() > 1 && good > 0 {
                numbers += good;
                all += cells.len();
            }
        }
        // Whole numbers alone do not show a decimal comma.
        if decimal_comma && !has_mark {
            return 0.0;
        }
        numbers as f64 / f64::max(all as f64, 1.0)
    };
    let allowed = styles
        .into_iter()
        .filter(|(separator, _)| stated.is_none_or(|stated| stated == *separator));
    let mut best: Option<((u8, bool), f64)> = None;
    for style in allowed {
        let share = share(style);
        // Another style must be clearly better than the previous one.
        if share > 0.0 && best.is_none_or(|(_, before)| share > before + 0.05) {
            best = Some((style, share));
        }
    }
    best.map(|(style, _)| style)
}

/// Refuses numbers like 1,234 if nothing shows whether the comma is a decimal mark or separates thousands. Groups of
/// thousands have three digits and begin with 1 to 9, so one number of another form is enough.
fn thousands(lines: &[(u64, &str)], separator: u8) -> Result<(), Box<TwoReadings>> {
    let mut doubtful = None;
    for (index, line) in lines {
        for cell in cells(line, separator) {
            if !is_number(cell, true) {
                continue;
            }
            let Some((whole, decimals)) = cell.split_once(',') else {
                continue;
            };
            let digits = whole.trim_start_matches(['-', '+']);
            if decimals.len() != 3 || digits.starts_with('0') || !(1..=3).contains(&digits.len()) {
                return Ok(());
            }
            doubtful.get_or_insert((*index, cell));
        }
    }
    let Some((index, cell)) = doubtful else {
        return Ok(());
    };
    Err(Box::new(TwoReadings {
        line: index + 1,
        cell: cell.to_owned(),
        first: cell.replacen(',', ".", 1),
        second: cell.replacen(',', "", 1),
    }))
}

/// Finds the header: the text line directly above the samples with the same number of cells. A line of units may stand
/// between them.
fn with_header(lines: &[(u64, &str)], found: Dialect) -> Dialect {
    let width_of = |line: &str| cells(line, found.separator).len();
    let has_number = |line: &str| {
        let cells = cells(line, found.separator);
        cells
            .iter()
            .any(|cell| is_number(cell, found.decimal_comma))
    };
    let mut counts = std::collections::BTreeMap::new();
    for (_, line) in lines {
        *counts.entry(width_of(line)).or_insert(0_usize) += 1;
    }
    let Some(width) = counts
        .into_iter()
        .max_by_key(|(_, count)| *count)
        .map(|(width, _)| width)
    else {
        return found;
    };
    let is_wide = |index: usize| width_of(lines[index].1) == width;
    let holds_number = |index: usize| has_number(lines[index].1);
    // The samples begin where several consecutive lines have the usual number of cells and contain a number.
    let begins = |index: &usize| {
        let run = *index..lines.len().min(index + RUN);
        run.into_iter()
            .all(|line| is_wide(line) && holds_number(line))
    };
    let Some(first) = (0..lines.len()).find(begins) else {
        return found;
    };
    let is_text = |index: usize| is_wide(index) && !holds_number(index);
    let is_units = |index: usize| {
        let cells = cells(lines[index].1, found.separator);
        cells.iter().all(|cell| is_unit(cell))
    };
    let above = first.checked_sub(1);
    let (index, header) = match above {
        Some(above) if is_text(above) => {
            let over = above.checked_sub(1).filter(|over| is_text(*over));
            match over {
                Some(over) if is_units(above) => (over, Header::Line { units: true }),
                _ => (above, Header::Line { units: false }),
            }
        }
        // A header with another number of cells, directly above the samples: the table is refused as ragged.
        Some(0) if width_of(lines[0].1) > 1 && !holds_number(0) => return found,
        _ => (first, Header::None { columns: width }),
    };
    Dialect {
        lines_before: lines[index].0,
        header,
        ..found
    }
}

fn is_unit(cell: &str) -> bool {
    cell.chars().count() <= LONGEST_UNIT
        && (cell.is_empty()
            || cell == "-"
            || plain_unit(cell).is_some()
            || cell.starts_with(['[', '(']))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Dialect {
        dialect(text.as_bytes()).expect("one reading")
    }

    #[test]
    fn separators_and_decimal_marks() {
        for (text, separator, decimal_comma) in [
            ("t,a\n0.1,0.2\n0.2,0.3\n", b',', false),
            ("t;a\n0.1;0.2\n0.2;0.3\n", b';', false),
            ("t;a\n0,1;0,25\n0,2;0,3\n", b';', true),
            ("t\ta\n0,1\t0,25\n0,2\t0,3\n", b'\t', true),
            ("sep=;\nt;a\n0,1;0,25\n0,2;0,3\n", b';', true),
            ("t;a, b\n1;2\n3;4\n", b';', false),
            ("t,a\n\"0,1\",\"0,25\"\n\"0,2\",\"0,3\"\n", b',', true),
            ("t,a\n0.1,\"1,234.5\"\n0.2,\"1,235.5\"\n", b',', false),
            ("t,a\n0,1\n0.1,x\n", b',', false),
            ("t;a\n0;1\n0.1;x\n", b';', false),
            ("t|a\n1|2\n3|4\n", b'|', false),
            ("t a\n1 2\n3 4\n", b' ', false),
        ] {
            let found = of(text);
            assert_eq!(
                (found.separator, found.decimal_comma),
                (separator, decimal_comma),
                "{text}"
            );
        }
    }

    #[test]
    fn headers_units_and_what_stands_above() {
        let line = |units| Header::Line { units };
        for (text, lines_before, header) in [
            ("t,a\n0.1,0.2\n", 0, line(false)),
            ("# a comment\n\nt,a\n0.1,0.2\n", 2, line(false)),
            (
                "Logger 3\nserial 12\nt,a\n[s],[deg]\n0.1,0.2\n",
                2,
                line(true),
            ),
            ("t;a\ns;°\n0,1;0,25\n", 0, line(true)),
            ("0.1,0.2\n0.2,0.3\n", 0, Header::None { columns: 2 }),
            (
                "Logger 3\n0.1,0.2\n0.2,0.3\n",
                1,
                Header::None { columns: 2 },
            ),
        ] {
            let found = of(text);
            assert_eq!(
                (found.lines_before, &found.header),
                (lines_before, &header),
                "{text}"
            );
        }
    }

    #[test]
    fn decimals_that_could_be_thousands_are_refused() {
        let found = dialect(b"t;a\n1,234;5,678\n2,345;6,789\n").expect_err("two readings");
        assert_eq!(
            (found.first.as_str(), found.second.as_str()),
            ("1.234", "1234")
        );
        assert_eq!(found.line, 2);
        assert!(of("t;a\n1,234;0,678\n2,345;6,789\n").decimal_comma);
    }

    #[test]
    fn encodings() {
        for (bytes, expected) in [
            (b"t,a\n1,2\n".to_vec(), UTF_8),
            (b"\xef\xbb\xbft,a\n1,2\n".to_vec(), UTF_8),
            (b"\xff\xfet\0,\0a\0\n\0".to_vec(), UTF_16LE),
            (b"t\0,\0a\0\n\x001\0,\x002\0\n\0".to_vec(), UTF_16LE),
            (b"t,\xb0\n1,2\n".to_vec(), WINDOWS_1252),
            (b"t,\xb0\x01\n1,2\n".to_vec(), UTF_8),
        ] {
            assert_eq!(encoding(&bytes), expected);
        }
    }
}
