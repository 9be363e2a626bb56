//! CSV files with a header line, streamed: no more of a file is in memory than what its reader
//! keeps. Lines that begin with `#` and blank lines are passed over; cells are separated by commas,
//! or by the semicolons or tabs that the header line uses. Columns that nobody asked for may hold
//! anything.

use std::cell::Cell;
use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::rc::Rc;

use csv::{ErrorKind, StringRecord};

use crate::error::{Error, Names, Place, Problem, shortened};
use crate::files::{Content, Files};
use crate::write::reason;

/// Largest log that is read, in bytes.
pub const MAX_LOG_BYTES: u64 = 1 << 30;
/// Most lines of a log that are read: two hours and three quarters at 1 kHz.
pub const MAX_LOG_ROWS: usize = 10_000_000;
/// What some editors put in front of UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Longest line that is read, in bytes.
const MAX_LINE_BYTES: usize = 1 << 20;

/// A CSV file that was opened: the header is read, the rows are not.
pub(crate) struct OpenTable<'p> {
    source: Source<'p>,
    reader: csv::Reader<Bounded<Content<'p>>>,
    budget: Rc<Cell<usize>>,
    columns: Vec<String>,
    header_line: u64,
}

/// A file and where it is looked for.
#[derive(Clone, Copy)]
struct Source<'p> {
    files: Files<'p>,
    path: &'p Path,
}

impl Source<'_> {
    /// The line on which the record at this position begins. The CSV reader's own position lies before
    /// the blank lines, comments and half line ends that it passes over ahead of a record, so the file
    /// is looked at once more from there; this happens only on the way to an error.
    fn line_of(self, position: Option<&csv::Position>) -> u64 {
        let Some(position) = position else {
            return 1;
        };
        let mut line = position.line();
        let Ok(mut file) = self.files.open(self.path) else {
            return line;
        };
        let mut start = [0; 3];
        let mark = match file.read(&mut start) {
            Ok(3) if start == *BYTE_ORDER_MARK => 3,
            _ => 0,
        };
        if file.seek(SeekFrom::Start(position.byte() + mark)).is_err() {
            return line;
        }
        let mut in_comment = false;
        for byte in io::BufReader::new(file).bytes().map_while(Result::ok) {
            match byte {
                b'\n' => {
                    line += 1;
                    in_comment = false;
                }
                b'\r' => {}
                b'#' => in_comment = true,
                _ if in_comment => {}
                _ => break,
            }
        }
        line
    }
}

/// One row of the columns that were asked for.
pub(crate) struct Row<'r> {
    source: Source<'r>,
    record: &'r StringRecord,
    names: &'r [String],
    indices: &'r [usize],
    /// Rows before this one.
    pub index: usize,
}

impl Row<'_> {
    /// The number in the asked-for column `k`, as it stands.
    pub fn number(&self, k: usize) -> Result<f64, Error> {
        let text = self.record.get(self.indices[k]).unwrap_or("");
        number(text).map_err(|problem| self.error(k, *problem))
    }

    /// A problem with the cell of column `k`.
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

/// Opens a file and reads its header line; `example` is a header that would be right.
pub(crate) fn open<'p>(
    files: Files<'p>,
    path: &'p Path,
    example: &str,
) -> Result<OpenTable<'p>, Error> {
    let source = Source { files, path };
    let file = files.open(path)?;
    let bytes = file
        .length()
        .map_err(|error| Error::in_file(path, Problem::Unreadable(reason(&error))))?;
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
    let budget = Rc::new(Cell::new(MAX_LINE_BYTES));
    let mut bounded = Bounded {
        inner: file.take(MAX_LOG_BYTES),
        budget: budget.clone(),
        ahead: Vec::new(),
    };
    let delimiter = bounded
        .delimiter()
        .map_err(|error| Error::in_file(path, Problem::Unreadable(reason(&error))))?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bounded);

    let mut header = StringRecord::new();
    let found = reader
        .read_record(&mut header)
        .map_err(|error| csv_error(source, reader.position(), error))?;
    if !found {
        return Err(Error::in_file(path, Problem::EmptyLog));
    }
    let line = source.line_of(header.position());
    if header.iter().any(|cell| cell.parse::<f64>().is_ok()) {
        let first = header.iter().collect::<Vec<_>>().join(",");
        return Err(Error::at(
            at_line(path, line, None),
            Problem::NoHeader {
                first: shortened(&first),
                example: example.to_owned(),
            },
        ));
    }
    Ok(OpenTable {
        source,
        reader,
        budget,
        columns: header.iter().map(str::to_string).collect(),
        header_line: line,
    })
}

impl OpenTable<'_> {
    /// The column names.
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The file.
    pub fn path(&self) -> &Path {
        self.source.path
    }

    /// An error at the header line.
    pub fn header_error(&self, column: Option<&str>, problem: Problem) -> Error {
        Error::at(at_line(self.source.path, self.header_line, column), problem)
    }

    /// Gives every row of these columns to `take`, in the order of the file, and returns how many
    /// there were.
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
            // Whoever built the uses took the names from the header.
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

/// A cell as a number.
fn number(cell: &str) -> Result<f64, Box<Problem>> {
    if cell.is_empty() {
        return Err(Box::new(Problem::EmptyCell));
    }
    let value: f64 = cell.parse().map_err(|_| {
        Box::new(Problem::NotANumber {
            cell: shortened(cell),
            hint: if cell.replacen(',', ".", 1).parse::<f64>().is_ok() {
                " (a point, not a comma, before the decimals)"
            } else {
                ""
            },
        })
    })?;
    if !value.is_finite() {
        return Err(Box::new(Problem::NotFinite {
            cell: shortened(cell),
        }));
    }
    Ok(value)
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
    let line = source.line_of(Some(error.position().unwrap_or(reader_at)));
    let place = at_line(path, line, None);
    match error.into_kind() {
        ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => Error::at(
            place,
            Problem::RaggedRow {
                expected: expected_len,
                found: len,
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

/// A line was longer than [`MAX_LINE_BYTES`].
#[derive(Debug)]
struct LineTooLong;

impl fmt::Display for LineTooLong {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line too long")
    }
}

impl std::error::Error for LineTooLong {}

/// A reader that gives out at most `budget` bytes until the budget is filled up again, which
/// happens after each line: a file without line ends does not fill the memory.
struct Bounded<R> {
    inner: io::Take<R>,
    budget: Rc<Cell<usize>>,
    /// Bytes that were looked at to find the delimiter and are still to be given out.
    ahead: Vec<u8>,
}

impl<R: Read> Bounded<R> {
    /// Looks at the first line that is neither blank nor a comment: the separator that occurs most
    /// often in it is the delimiter; a comma where there is none. A byte order mark is swallowed.
    fn delimiter(&mut self) -> io::Result<u8> {
        self.inner
            .by_ref()
            .take(64 << 10)
            .read_to_end(&mut self.ahead)?;
        if self.ahead.starts_with(BYTE_ORDER_MARK) {
            self.ahead.drain(..3);
        }
        let header = self
            .ahead
            .split(|byte| *byte == b'\n')
            .find(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#"))
            .unwrap_or(b"");
        let count = |delimiter: u8| header.iter().filter(|byte| **byte == delimiter).count();
        let delimiter = [b',', b';', b'\t']
            .into_iter()
            .rev()
            .max_by_key(|delimiter| count(*delimiter))
            .unwrap_or(b',');
        self.ahead.reverse();
        Ok(delimiter)
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let allowed = self.budget.get().min(buffer.len());
        if allowed == 0 && !buffer.is_empty() {
            return Err(io::Error::other(LineTooLong));
        }
        let read = if self.ahead.is_empty() {
            self.inner.read(&mut buffer[..allowed])?
        } else {
            let n = allowed.min(self.ahead.len());
            for slot in &mut buffer[..n] {
                *slot = self.ahead.pop().unwrap_or(b'\n');
            }
            n
        };
        self.budget.set(self.budget.get() - read);
        Ok(read)
    }
}
