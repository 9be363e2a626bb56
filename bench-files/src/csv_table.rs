//! CSV files in the usual dialects (see `dialect`), read as a stream: only what the reader keeps is in
//! memory. Lines that begin with `#` and blank lines are skipped. Without a header line, columns are
//! named "1", "2", …. Columns that are not used may contain anything.

use std::cell::Cell;
use std::fmt;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;
use std::rc::Rc;

use csv::{ErrorKind, StringRecord};
use encoding_rs::UTF_8;
use encoding_rs_io::DecodeReaderBytesBuilder;

use crate::cell::{number, with_unit};
use crate::clock::clock;
use crate::dialect::{self, Dialect, Header, LOOKED_AT};
use crate::error::{Error, Names, Place, Problem, shortened};
use crate::files::Files;
use crate::foreign::foreign;
use crate::units_in_text::plain_unit;
use crate::write::reason;

/// Largest size of a log, in bytes.
pub const MAX_LOG_BYTES: u64 = 1 << 30;
/// Largest number of lines of a log: two hours and three quarters at 1 kHz.
pub const MAX_LOG_ROWS: usize = 10_000_000;
/// The byte order mark that some editors write before UTF-8 text.
const UTF_8_MARK: &[u8] = b"\xef\xbb\xbf";
/// Said where a cell is the name of its column.
const HEADER_AGAIN: &str = " (the header line stands here again: if the log was started anew, cut the file in two here; \
                            otherwise leave this line out)";
/// Number of bytes of a line that are looked at where it is at fault.
const SHOWN_BYTES: usize = 1 << 10;
/// Largest length of a line, in bytes.
const MAX_LINE_BYTES: usize = 1 << 20;

/// An open CSV file: its header has been read, its rows have not.
pub(crate) struct OpenTable<'p> {
    source: Source<'p>,
    reader: csv::Reader<Bounded<'p>>,
    budget: Rc<Cell<usize>>,
    columns: Vec<String>,
    units: Vec<Option<&'static str>>,
    header_line: u64,
    has_header: bool,
    decimal_comma: bool,
}

/// A file, and where to open it.
#[derive(Clone, Copy)]
struct Source<'p> {
    files: Files<'p>,
    path: &'p Path,
    /// Lines and bytes that are skipped before the CSV reader starts.
    lines_before: u64,
    bytes_before: u64,
    /// Whether the bytes that the CSV reader counts are those of the file.
    is_utf_8: bool,
}

impl Source<'_> {
    /// The line on which the record at this position begins. The CSV reader's own position is before
    /// the blank lines, comments and line ends that it skips before a record. The file
    /// is therefore read once more from there; this happens only when an error is reported.
    fn line_of(self, position: Option<&csv::Position>) -> u64 {
        self.line_and_text(position).0
    }

    /// The line on which the record at this position begins, and the beginning of its text.
    fn line_and_text(self, position: Option<&csv::Position>) -> (u64, Vec<u8>) {
        let mut text = vec![];
        let Some(position) = position else {
            return (self.lines_before + 1, text);
        };
        let mut line = position.line() + self.lines_before;
        if !self.is_utf_8 {
            return (line, text);
        }
        let Ok(mut file) = self.files.open(self.path) else {
            return (line, text);
        };
        if file
            .seek(SeekFrom::Start(position.byte() + self.bytes_before))
            .is_err()
        {
            return (line, text);
        }
        let mut in_comment = false;
        for byte in BufReader::new(file).bytes().map_while(Result::ok) {
            match byte {
                b'\n' if !text.is_empty() => break,
                b'\n' => {
                    line += 1;
                    in_comment = false;
                }
                b'\r' => {}
                b'#' if text.is_empty() => in_comment = true,
                _ if in_comment => {}
                _ => text.push(byte),
            }
            if text.len() > SHOWN_BYTES {
                break;
            }
        }
        (line, text)
    }
}

/// One row, with the requested columns.
pub(crate) struct Row<'r> {
    source: Source<'r>,
    record: &'r StringRecord,
    names: &'r [String],
    indices: &'r [usize],
    decimal_comma: bool,
    /// Number of rows before this one.
    pub index: usize,
}

impl Row<'_> {
    /// The number in the requested column `k`, not converted.
    pub fn number(&self, k: usize) -> Result<f64, Error> {
        let text = self.record.get(self.indices[k]).unwrap_or("");
        number(text, self.decimal_comma).map_err(|problem| match *problem {
            Problem::NotANumber { cell, .. } if cell == self.names[k] => self.error(
                k,
                Problem::NotANumber {
                    cell,
                    hint: HEADER_AGAIN,
                },
            ),
            problem => self.error(k, problem),
        })
    }

    /// As [`Row::number`], without the place of what is wrong: that costs a second look into the file.
    pub fn plain_number(&self, k: usize) -> Option<f64> {
        number(self.text(k), self.decimal_comma).ok()
    }

    /// The number in the requested column `k`, and the unit that stands behind it in the cell.
    pub fn number_with_unit(&self, k: usize) -> Option<(f64, &'static str)> {
        with_unit(self.text(k), self.decimal_comma)
    }

    /// Whether the cell of column `k` is a time of day.
    pub fn is_clock(&self, k: usize) -> bool {
        clock(self.text(k)).is_some()
    }

    /// An error in the cell of column `k`.
    pub fn error(&self, k: usize, problem: Problem) -> Error {
        let line = self.source.line_of(self.record.position());
        Error::at(
            at_line(self.source.path, line, Some(&self.names[k])),
            problem,
        )
    }

    /// The text in column `k`.
    pub fn text(&self, k: usize) -> &str {
        self.record.get(self.indices[k]).unwrap_or("")
    }
}

/// Opens a file and reads its header line.
pub(crate) fn open<'p>(files: Files<'p>, path: &'p Path) -> Result<OpenTable<'p>, Error> {
    let unreadable = |error: io::Error| Error::in_file(path, Problem::Unreadable(reason(&error)));
    let mut file = files.open(path)?;
    let bytes = file.length().map_err(unreadable)?;
    if bytes > MAX_LOG_BYTES {
        return Err(Error::in_file(
            path,
            Problem::TooLarge {
                bytes,
                limit: MAX_LOG_BYTES,
                advice: "log at a lower rate or cut the log into several files",
            },
        ));
    }
    let mut start = Vec::new();
    let looked_at = file.by_ref().take(LOOKED_AT as u64);
    { looked_at }.read_to_end(&mut start).map_err(unreadable)?;
    let is_utf_8 = dialect::encoding(&start) == UTF_8;
    if let Some(problem) = foreign(&start, is_utf_8) {
        return Err(Error::in_file(path, problem));
    }
    let dialect = dialect::dialect(&start).map_err(|found| {
        let place = at_line(path, found.line, None);
        let (cell, first, second) = (shortened(&found.cell), found.first, found.second);
        Error::at(
            place,
            Problem::TwoReadings {
                cell,
                first,
                second,
            },
        )
    })?;
    let (text, bytes_before) =
        text_of(start, file.take(MAX_LOG_BYTES), &dialect).map_err(unreadable)?;
    let source = Source {
        files,
        path,
        lines_before: dialect.lines_before,
        bytes_before,
        is_utf_8: dialect.encoding == UTF_8,
    };
    let budget = Rc::new(Cell::new(MAX_LINE_BYTES));
    let bounded = Bounded {
        inner: text,
        budget: budget.clone(),
    };
    let reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(dialect.separator)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bounded);
    let mut table = OpenTable {
        source,
        reader,
        budget,
        columns: vec![],
        units: vec![],
        header_line: dialect.lines_before + 1,
        has_header: true,
        decimal_comma: dialect.decimal_comma,
    };
    match dialect.header {
        Header::None { columns } => {
            table.columns = (1..=columns).map(|number| number.to_string()).collect();
            table.has_header = false;
        }
        Header::Line { units } => {
            let Some(header) = table.next_record()? else {
                return Err(Error::in_file(path, Problem::EmptyLog));
            };
            table.header_line = source.line_of(header.position());
            table.columns = header.iter().map(str::to_string).collect();
            if units && let Some(units) = table.next_record()? {
                table.units = units.iter().map(plain_unit).collect();
            }
        }
    }
    Ok(table)
}

/// The text of a file from the first relevant line on, and the number of bytes before it.
fn text_of<'p>(
    mut start: Vec<u8>,
    rest: impl Read + 'p,
    dialect: &Dialect,
) -> io::Result<(Box<dyn Read + 'p>, u64)> {
    let mut bytes_before = 0;
    let is_utf_8 = dialect.encoding == UTF_8;
    if is_utf_8 && start.starts_with(UTF_8_MARK) {
        start.drain(..UTF_8_MARK.len());
        bytes_before += UTF_8_MARK.len() as u64;
    }
    let whole = Cursor::new(start).chain(rest);
    if !is_utf_8 {
        let mut builder = DecodeReaderBytesBuilder::new();
        let decoded = builder.encoding(Some(dialect.encoding)).build(whole);
        let mut lines = BufReader::new(decoded);
        skip_lines(&mut lines, dialect)?;
        return Ok((Box::new(lines), 0));
    }
    let mut lines = BufReader::new(whole);
    bytes_before += skip_lines(&mut lines, dialect)?;
    Ok((Box::new(lines), bytes_before))
}

/// Skips the lines before the table, and returns their number of bytes.
fn skip_lines(lines: &mut impl BufRead, dialect: &Dialect) -> io::Result<u64> {
    let mut bytes = 0;
    for _ in 0..dialect.lines_before {
        bytes += lines.skip_until(dialect.line_end)? as u64;
    }
    Ok(bytes)
}

impl OpenTable<'_> {
    /// The column names.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The unit of this column from the file's own line of units, if it is a known one.
    pub fn unit(&self, column: &str) -> Option<&'static str> {
        let index = self.columns.iter().position(|name| name == column)?;
        self.units.get(index).copied().flatten()
    }

    /// Whether the columns have names.
    pub fn has_header(&self) -> bool {
        self.has_header
    }

    fn next_record(&mut self) -> Result<Option<StringRecord>, Error> {
        let mut record = StringRecord::new();
        self.budget.set(MAX_LINE_BYTES);
        let found = self
            .reader
            .read_record(&mut record)
            .map_err(|error| csv_error(self.source, self.reader.position(), error))?;
        Ok(found.then_some(record))
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.source.path
    }

    /// An error in the header line.
    pub fn header_error(&self, column: Option<&str>, problem: Problem) -> Error {
        Error::at(at_line(self.source.path, self.header_line, column), problem)
    }

    /// Passes every row of these columns to `take`, in the order of the file, and returns their number.
    pub fn read_rows(
        &mut self,
        names: &[String],
        mut take: impl FnMut(&Row) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let indices = names
            .iter()
            .map(|name| self.index_of(name))
            .collect::<Result<Vec<usize>, Error>>()?;
        let mut record = StringRecord::new();
        let mut rows = 0_usize;
        loop {
            self.budget.set(MAX_LINE_BYTES);
            let found = self
                .reader
                .read_record(&mut record)
                .map_err(|error| csv_error(self.source, self.reader.position(), error))?;
            if !found {
                return Ok(rows);
            }
            if rows == MAX_LOG_ROWS {
                return Err(Error::in_file(
                    self.source.path,
                    Problem::TooManySamples {
                        limit: MAX_LOG_ROWS,
                    },
                ));
            }
            take(&Row {
                source: self.source,
                record: &record,
                names,
                indices: &indices,
                decimal_comma: self.decimal_comma,
                index: rows,
            })?;
            rows += 1;
        }
    }

    fn index_of(&self, name: &str) -> Result<usize, Error> {
        let mut places = self
            .columns
            .iter()
            .enumerate()
            .filter(|(_, column)| *column == name);
        match (places.next(), places.count()) {
            (Some((index, _)), 0) => Ok(index),
            (Some(_), more) => {
                Err(self.header_error(Some(name), Problem::DuplicateColumn { times: more + 1 }))
            }
            // The caller took the column names from the header.
            (None, _) => Err(self.header_error(
                Some(name),
                Problem::UnknownName {
                    what: "column".to_string(),
                    name: name.to_string(),
                    names: Names::new(&self.columns),
                },
            )),
        }
    }
}

fn at_line(path: &Path, line: u64, column: Option<&str>) -> Place {
    Place {
        file: path.to_path_buf(),
        line: usize::try_from(line).ok(),
        position: None,
        column: column.map(shortened),
    }
}

fn csv_error(source: Source, reader_at: &csv::Position, error: csv::Error) -> Error {
    let path = source.path;
    let (line, text) = source.line_and_text(Some(error.position().unwrap_or(reader_at)));
    let place = at_line(path, line, None);
    match error.into_kind() {
        ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => Error::at(
            place,
            Problem::RaggedRow {
                expected: expected_len,
                found: len,
                hint: hint(&text),
            },
        ),
        ErrorKind::Utf8 { pos, err } => {
            let start = pos.map_or(0, |pos| pos.byte());
            let byte = start + err.valid_up_to() as u64;
            Error::at(place, Problem::NotUtf8 { byte })
        }
        ErrorKind::Io(error)
            if error
                .get_ref()
                .is_some_and(|inner| inner.is::<LineTooLong>()) =>
        {
            Error::at(
                place,
                Problem::LineTooLong {
                    limit: MAX_LINE_BYTES,
                },
            )
        }
        ErrorKind::Io(error) => Error::in_file(path, Problem::Unreadable(reason(&error))),
        other => Error::in_file(path, Problem::Unreadable(format!("{other:?}"))),
    }
}

/// What a line with the wrong number of cells looks like.
fn hint(line: &[u8]) -> &'static str {
    let begins = |marks: &[&[u8]]| marks.iter().any(|mark| line.starts_with(mark));
    if line.contains(&0) {
        "; it holds zero bytes, as where a logger lost its power while it wrote: cut the file before it"
    } else if line.iter().filter(|byte| **byte == b'"').count() % 2 == 1 {
        "; a quotation mark is opened here and not closed: take it out"
    } else if begins(&[b"//", b"%", b";", b"!", b"*", b"--"]) {
        "; it looks like a comment: only lines that begin with # are left out"
    } else {
        ""
    }
}

/// A line was longer than [`MAX_LINE_BYTES`].
#[derive(Debug)]
struct LineTooLong;

impl fmt::Display for LineTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line too long")
    }
}

impl std::error::Error for LineTooLong {}

/// A reader that returns at most `budget` bytes until the budget is refilled, which
/// happens after each line: a file without line ends cannot fill the memory.
struct Bounded<'p> {
    inner: Box<dyn Read + 'p>,
    budget: Rc<Cell<usize>>,
}

impl Read for Bounded<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let allowed = self.budget.get().min(buffer.len());
        if allowed == 0 && !buffer.is_empty() {
            return Err(io::Error::other(LineTooLong));
        }
        let read = self.inner.read(&mut buffer[..allowed])?;
        self.budget.set(self.budget.get() - read);
        Ok(read)
    }
}
