//! A bench.toml without its logs, and entries added to it: for a bench whose logs are still being
//! recorded. The existing content of the file keeps its comments and its order.

use std::path::{Path, PathBuf};

use plant::Kind;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use crate::bench::{SECTIONS, bench_file, folder_of};
use crate::error::Error;
use crate::files::Files;
use crate::hardware::Hardware;
use crate::toml_source::TomlSource;
use crate::toml_writing::{number, table_in};
use crate::write::write_atomically;

/// The content of a bench.toml apart from its logs, whose files need not exist yet.
#[derive(Clone, Debug)]
pub struct BenchOutline {
    /// The bench.toml.
    pub file: PathBuf,
    /// The folder that holds it.
    pub folder: PathBuf,
    /// Its sensors and its drive, where they are stated.
    pub hardware: Option<Hardware>,
    /// The names of its experiments.
    pub experiments: Vec<String>,
    document: DocumentMut,
}

/// An experiment that was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct NewExperiment {
    /// Its name; [`BenchOutline::free_name`] gives one that is not taken.
    pub name: String,
    /// What was held still.
    pub kind: Kind,
    /// The log, relative to the bench's folder.
    pub file: String,
    /// The first time of the log to use, s.
    pub from_s: Option<f64>,
    /// A comment above the entry, one line or several.
    pub comment: String,
}

impl BenchOutline {
    /// Reads the bench.toml of a bench that is named by its folder or that file.
    ///
    /// # Errors
    /// The first thing that is wrong in the file, or that there is no such file.
    pub fn read(path: &Path) -> Result<BenchOutline, Error> {
        let file = bench_file(path)?;
        let source = TomlSource::read(Files::Disk, &file)?;
        let document = source.parse()?;
        let root = source.root(&document);
        root.allow_only(&SECTIONS)?;
        let hardware = Hardware::read(&source, &root)?;
        let experiments = root
            .sections("experiment")?
            .iter()
            .map(|section| Ok(section.text("name")?.map(|name| name.value)))
            .collect::<Result<Vec<_>, Error>>()?;
        Ok(BenchOutline {
            folder: folder_of(&file),
            file,
            hardware,
            experiments: experiments.into_iter().flatten().collect(),
            document: document.into_mut(),
        })
    }

    /// `wished`, with a number behind it if an experiment or a file in the folder already has that name.
    pub fn free_name(&self, wished: &str) -> String {
        let is_free = |name: &str| {
            !self.experiments.iter().any(|other| other == name)
                && std::fs::symlink_metadata(self.folder.join(file_name(name))).is_err()
        };
        let numbered = (2..).map(|number| format!("{wished} {number}"));
        std::iter::once(wished.to_owned())
            .chain(numbered)
            .find(|name| is_free(name))
            .unwrap_or_else(|| wished.to_owned())
    }

    /// Adds an entry `[[experiment]]` and writes the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add_experiment(&mut self, new: &NewExperiment) -> Result<(), Error> {
        let key = "experiment";
        let list = self
            .document
            .entry(key)
            .or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        match list {
            Item::ArrayOfTables(tables) => {
                let mut table = Table::new();
                fill(&mut table, new);
                let comment: String = new
                    .comment
                    .lines()
                    .map(|line| format!("# {line}\n"))
                    .collect();
                table.decor_mut().set_prefix(format!("\n{comment}"));
                tables.push(table);
            }
            Item::Value(Value::Array(array)) => push_inline(array, new),
            // Reading would have refused it.
            _ => {}
        }
        self.experiments.push(new.name.clone());
        self.save()
    }

    /// Adds the entries `[[experiment]]` of another bench.toml, with their comments. No file is written: the result is
    /// the whole text.
    ///
    /// # Errors
    /// A sentence: the other text is no TOML, or this bench lists its experiments in square brackets, where an entry
    /// cannot keep its comments.
    pub fn with_experiments_of(&self, other: &str) -> Result<String, String> {
        let other: DocumentMut = other
            .parse()
            .map_err(|error: toml_edit::TomlError| error.message().to_owned())?;
        let mut document = self.document.clone();
        let list = document
            .entry("experiment")
            .or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
        let Some(list) = list.as_array_of_tables_mut() else {
            return Err(format!(
                "{}: write its experiments as [[experiment]] sections first",
                self.file.display()
            ));
        };
        let added = other.get("experiment").and_then(Item::as_array_of_tables);
        for table in added.into_iter().flatten() {
            let mut table = table.clone();
            // Where it stood in the other file says nothing here: it follows the last one.
            table.set_position(None);
            list.push(table);
        }
        Ok(document.to_string())
    }

    /// Enters a recording under `[bring_up]`, in place of an older one, and writes the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn set_bring_up(&mut self, key: &str, file: &str) -> Result<(), Error> {
        let section = table_in(self.document.as_table_mut(), "bring_up", false);
        crate::toml_writing::set(section, key, Value::from(file));
        self.save()
    }

    fn save(&self) -> Result<(), Error> {
        write_atomically(&self.file, self.document.to_string().as_bytes())
    }
}

/// The file name for a log with this name. Characters that a path or a shell would interpret are left out.
pub fn file_name(name: &str) -> String {
    let plain: String = name
        .chars()
        .map(|c| match c {
            c if c.is_alphanumeric() || matches!(c, '-' | '+' | '.' | '_') => c,
            _ => '-',
        })
        .collect();
    format!("{}.csv", plain.trim_start_matches('.'))
}

fn fill(table: &mut dyn TableLike, new: &NewExperiment) {
    let mut put = |key: &str, value: Value| table.insert(key, Item::Value(value));
    put("name", Value::from(new.name.as_str()));
    put("kind", Value::from(new.kind.name()));
    put("file", Value::from(new.file.as_str()));
    if let Some(from_s) = new.from_s {
        put("from", number(from_s));
    }
}

fn push_inline(array: &mut Array, new: &NewExperiment) {
    let mut table = InlineTable::new();
    fill(&mut table, new);
    array.push(Value::InlineTable(table));
}
