//! Figures and tables as files that a caller may write, show or send.

use crate::error::Error;

/// A figure (SVG) or a table (CSV) that was made from a result, with the name of its file.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct OutputFile {
    /// A safe file name with its extension, such as `compare-free-swing-20-deg.svg`.
    pub name: String,
    /// The whole text of the file.
    pub text: String,
}

impl OutputFile {
    /// A figure.
    pub(crate) fn svg(name: &str, text: String) -> OutputFile {
        OutputFile {
            name: format!("{name}.svg"),
            text,
        }
    }

    /// A table of columns with their names; it has as many rows as the shortest column.
    pub(crate) fn csv<N: AsRef<str>>(name: &str, columns: &[(N, &[f64])]) -> OutputFile {
        let mut text = columns
            .iter()
            .map(|(name, _)| name.as_ref())
            .collect::<Vec<_>>()
            .join(",");
        text.push('\n');
        let rows = columns.iter().map(|(_, values)| values.len()).min();
        for row in 0..rows.unwrap_or(0) {
            let cells: Vec<String> = columns
                .iter()
                .map(|(_, values)| values[row].to_string())
                .collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        OutputFile {
            name: format!("{name}.csv"),
            text,
        }
    }

    /// A table of texts.
    pub(crate) fn of_records<const COLUMNS: usize>(
        name: &str,
        head: &[&str; COLUMNS],
        rows: impl Iterator<Item = [String; COLUMNS]>,
    ) -> Result<OutputFile, Error> {
        let broken = |source: csv::Error| Error::Table {
            name: name.to_owned(),
            source,
        };
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(head).map_err(broken)?;
        for row in rows {
            writer.write_record(row).map_err(broken)?;
        }
        let bytes = writer
            .into_inner()
            .map_err(|error| broken(csv::Error::from(error.into_error())))?;
        Ok(OutputFile {
            name: format!("{name}.csv"),
            text: String::from_utf8_lossy(&bytes).into_owned(),
        })
    }

    /// The files under names that differ on every file system. Names of experiments may differ only in characters that a
    /// file name cannot contain, or in upper and lower case.
    pub(crate) fn distinct(mut files: Vec<OutputFile>) -> Vec<OutputFile> {
        let mut used = std::collections::BTreeSet::new();
        for file in &mut files {
            let (stem, ending) = match file.name.rsplit_once('.') {
                Some((stem, ending)) => (stem.to_owned(), ending.to_owned()),
                None => (file.name.clone(), String::new()),
            };
            let mut count = 1;
            while !used.insert(file.name.to_lowercase()) {
                count += 1;
                file.name = format!("{stem}-{count}.{ending}");
            }
        }
        files
    }

    /// Whether it is a figure.
    pub fn is_figure(&self) -> bool {
        self.name.ends_with(".svg")
    }
}

/// A file name made from a user's name: letters and digits, the rest as hyphens. The sign
/// of a number becomes a word, so that 0.6 and −0.6 differ.
pub(crate) fn file_name(name: &str) -> String {
    let lower = name.to_lowercase();
    let mut text = String::new();
    let mut before = ' ';
    let mut characters = lower.chars().peekable();
    while let Some(c) = characters.next() {
        let is_sign = matches!(c, '-' | '−')
            && !before.is_alphanumeric()
            && characters.peek().is_some_and(char::is_ascii_digit);
        if is_sign {
            text.push_str("minus-");
        } else if c.is_alphanumeric() || c == '.' {
            text.push(c);
        } else if !text.ends_with('-') {
            text.push('-');
        }
        before = c;
    }
    let short: String = text.chars().take(80).collect();
    match short.trim_matches(['-', '.']) {
        "" => "unnamed".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_file_takes_the_place_of_another() {
        let file = |name: &str| OutputFile::svg(name, String::new());
        let files = OutputFile::distinct(vec![
            file("swing"),
            file("Swing"),
            file("swing-2"),
            file("swing"),
        ]);
        let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(
            names,
            ["swing.svg", "Swing-2.svg", "swing-2-2.svg", "swing-3.svg"]
        );
    }

    #[test]
    fn file_names_are_harmless() {
        for (name, expected) in [
            ("free swing 20 deg", "free-swing-20-deg"),
            ("spin-up 0.6 A", "spin-up-0.6-a"),
            ("spin-up -0.6 A", "spin-up-minus-0.6-a"),
            ("../../etc/passwd", "etc-passwd"),
            ("  ", "unnamed"),
            ("Schwung α/β", "schwung-α-β"),
        ] {
            assert_eq!(file_name(name), expected);
        }
    }
}
