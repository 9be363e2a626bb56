//! A whole file as numbers.

use std::path::Path;

use crate::csv_table::open;
use crate::error::{Error, Problem};
use crate::files::Files;

/// A whole CSV file as numbers, for finding out what its columns are.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the columns; "1", "2", … where the file has no header line.
    pub names: Vec<String>,
    /// Units from the file's line of units or from its cells, as `units` in bench.toml writes them.
    pub units: Vec<Option<&'static str>>,
    /// Whether the names are the file's own.
    pub has_header: bool,
    /// The samples of each column; NaN for a cell that is not a number.
    pub columns: Vec<Vec<f64>>,
}

impl Table {
    /// Reads the first `most_rows` rows of a file.
    ///
    /// # Errors
    /// If the file cannot be read or is not a table, two columns have the same name, or no cell is a number.
    pub fn read(path: &Path, most_rows: usize) -> Result<Table, Error> {
        let mut table = open(Files::Disk, path)?;
        let names = table.columns().to_vec();
        let mut units: Vec<_> = names.iter().map(|name| table.unit(name)).collect();
        let mut columns = vec![vec![]; names.len()];
        table.read_rows(&names, |row| {
            if row.index < most_rows {
                for (k, column) in columns.iter_mut().enumerate() {
                    let number = row.plain_number(k).or_else(|| {
                        // The unit of the first cell is that of the column.
                        let (number, unit) = row.number_with_unit(k)?;
                        (*units[k].get_or_insert(unit) == unit).then_some(number)
                    });
                    column.push(number.unwrap_or(f64::NAN));
                }
            }
            Ok(())
        })?;
        let rows = columns.iter().flatten();
        if rows.clone().next().is_some() && rows.clone().all(|cell| cell.is_nan()) {
            return Err(Error::in_file(path, Problem::NoNumbers));
        }
        Ok(Table {
            has_header: table.has_header(),
            names,
            units,
            columns,
        })
    }
}
