//! Files that are no table of numbers as text, by their first bytes: what they are, and how a table is made of them.

use crate::error::Problem;

/// Number of bytes at the beginning, and the share of control characters in them, above which they are no text. A damaged
/// line may hold some zero bytes; every second byte of a number in binary form is one.
const HEAD: usize = 512;
const CONTROL: f64 = 0.1;
/// Number of lines that are looked at.
const LINES: usize = 4;

const SHEET: &str = "open it and save the sheet as CSV";

/// First bytes, what begins with them, and what to do with it.
const MAGIC: [(&[u8], &str, &str); 21] = [
    (
        b"\xd0\xcf\x11\xe0",
        "an old Excel or Office file (.xls)",
        SHEET,
    ),
    (b"\x1f\x8b", "packed with gzip", "unpack it first (gunzip)"),
    (b"BZh", "packed with bzip2", "unpack it first (bunzip2)"),
    (b"\xfd7zXZ", "packed with xz", "unpack it first (unxz)"),
    (
        b"\x28\xb5\x2f\xfd",
        "packed with zstd",
        "unpack it first (unzstd)",
    ),
    (b"7z\xbc\xaf", "a 7z archive", "unpack it first"),
    (
        b"MATLAB 5.0 MAT-file",
        "a MATLAB file (.mat)",
        "in MATLAB: load it and writetable(table(t, angle), 'log.csv'); in Python: scipy.io.loadmat and numpy.savetxt",
    ),
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (.h5, or .mat of version 7.3)",
        "in MATLAB: load it and writetable(table(t, angle), 'log.csv'); in Python: h5py and numpy.savetxt",
    ),
    (
        b"PAR1",
        "a Parquet file",
        "in Python: pandas.read_parquet(file).to_csv('log.csv', index=False)",
    ),
    (
        b"ARROW1",
        "a Feather file",
        "in Python: pandas.read_feather(file).to_csv('log.csv', index=False)",
    ),
    (
        b"\x93NUMPY",
        "a NumPy array (.npy)",
        "in Python: numpy.savetxt('log.csv', numpy.load(file), delimiter=',')",
    ),
    (
        b"SQLite format 3",
        "an SQLite database",
        "export the table as CSV",
    ),
    (
        b"#ROSBAG",
        "a ROS bag",
        "export the topic as CSV (rostopic echo -b file -p /topic > log.csv)",
    ),
    (
        b"\x89MCAP",
        "a ROS 2 recording (MCAP)",
        "export the topic as CSV",
    ),
    (
        b"%PDF",
        "a PDF document",
        "take the numbers from where it was made",
    ),
    (
        b"\x89PNG",
        "a picture",
        "save the numbers, not the plot of them",
    ),
    (
        b"\xff\xd8\xff",
        "a picture",
        "save the numbers, not the plot of them",
    ),
    (
        b"{\\rtf",
        "a text with formats (RTF), as TextEdit and WordPad save it",
        "save it as plain text",
    ),
    (
        b"\x80\x03",
        "a Python pickle",
        "load it in Python and save it with to_csv or numpy.savetxt",
    ),
    (
        b"\x80\x04",
        "a Python pickle",
        "load it in Python and save it with to_csv or numpy.savetxt",
    ),
    (
        b"\x80\x05",
        "a Python pickle",
        "load it in Python and save it with to_csv or numpy.savetxt",
    ),
];

/// Why the bytes at the beginning of a file are no table, if that can be said. `is_utf_8`: whether its encoding has no zero
/// bytes.
pub(crate) fn foreign(start: &[u8], is_utf_8: bool) -> Option<Problem> {
    let found = |what: &'static str, advice: &'static str| Some(Problem::NoTable { what, advice });
    if start.starts_with(b"PK\x03\x04") {
        let contains = |part: &[u8]| start.windows(part.len()).any(|window| window == part);
        return if contains(b"xl/") || contains(b"opendocument") || contains(b"[Content_Types]") {
            found("a spreadsheet (.xlsx or .ods)", SHEET)
        } else {
            found(
                "a zip archive, or a spreadsheet (.xlsx)",
                "unpack it first, or save the sheet as CSV",
            )
        };
    }
    let magic = MAGIC.iter().find(|(magic, _, _)| start.starts_with(magic));
    if let Some((_, what, advice)) = magic {
        return found(what, advice);
    }
    let head = &start[..start.len().min(HEAD)];
    let control = head
        .iter()
        .filter(|byte| **byte < b'\t' || (b'\x0e'..b' ').contains(byte));
    if is_utf_8 && control.count() as f64 > CONTROL * head.len() as f64 {
        return found(
            "a binary file",
            "export its samples as text, one a line (CSV)",
        );
    }
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']);
    if text.starts_with("<?xml") {
        return found("an XML file", "export its samples as CSV");
    }
    if text.starts_with('<') {
        return found(
            "a web page (HTML)",
            "save the file that the page shows (\"raw\" or \"download\"), and not the page",
        );
    }
    let begins_json = ["{\"", "{ \"", "{\n", "{\r", "[{", "[[", "[\n", "[\r"];
    if begins_json.iter().any(|begin| text.starts_with(begin)) {
        return found(
            "JSON",
            "write one line a sample, and a first line with the names (in Python: pandas.read_json and to_csv)",
        );
    }
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let first: Vec<&str> = lines.by_ref().take(LINES).collect();
    if first.len() > 1 && first.iter().all(|line| has_monitor_time(line)) {
        return found(
            "the text of a serial monitor with its times (\"12:34:56.789 -> \")",
            "switch those times off or delete them to the arrow, and let the board print its own, micros(), in the first \
             column: those of the monitor are when the text came",
        );
    }
    if first.len() > 1 && first.iter().all(|line| has_labels(line)) {
        return found(
            "a list with a name before each number (\"angle:45.8\")",
            "print the names once, in the first line, and numbers alone below, with commas between them",
        );
    }
    None
}

/// Whether a line begins as in Arduino's serial monitor.
fn has_monitor_time(line: &str) -> bool {
    line.split_once(" -> ")
        .is_some_and(|(time, _)| crate::clock::clock(time).is_some())
}

/// Whether every cell is a name, a colon or an equals sign, and a number.
fn has_labels(line: &str) -> bool {
    let is_labelled = |cell: &str| {
        cell.split_once([':', '=']).is_some_and(|(name, number)| {
            name.starts_with(|c: char| c.is_alphabetic()) && number.trim().parse::<f64>().is_ok()
        })
    };
    line.split([',', ';', '\t'])
        .all(|cell| cell.trim().is_empty() || is_labelled(cell.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_no_table_are_named() {
        for (start, part) in [
            (&b"PK\x03\x04\x14\0\x06\0xl/worksheets"[..], "spreadsheet"),
            (b"PK\x03\x04\x14\0\x06\0run1.csv", "zip"),
            (b"\x1f\x8b\x08\0abc", "gzip"),
            (b"MATLAB 5.0 MAT-file, Platform", "MATLAB"),
            (b"PAR1\x15\0", "Parquet"),
            (b"\x7fELF\0\0\0", "binary"),
            (b"<!DOCTYPE html><html>", "HTML"),
            (b"{\\rtf1\\ansi t,a\n", "RTF"),
            (b"{\"t\":0.1,\"a\":2}\n", "JSON"),
            (b"12:34:56.789 -> 1.0\n12:34:56.794 -> 1.1\n", "monitor"),
            (b"a:1.0,b:2\na:1.1,b:3\n", "name before each number"),
        ] {
            let found = foreign(start, true).unwrap_or_else(|| panic!("{part}"));
            assert!(found.to_string().contains(part), "{found}");
        }
        for start in [
            &b"t,a\n0.1,0.2\n"[..],
            b"[s],[deg]\n0.1,0.2\n",
            b"# exported: 3\nt;a\n",
            b"12:34:56.789,1.0\n12:34:56.794,1.1\n",
            b"",
        ] {
            assert_eq!(foreign(start, true), None);
        }
        assert_eq!(foreign(b"t\0,\0a\0\n\0", false), None);
    }
}
