//! `flywheel exam`

use std::path::{Path, PathBuf};
use std::str::FromStr;

use ::exam::{
    Entry, ExamReport, Marks, SitError, Sitting, benches_csv, benches_in, intervals_csv,
    sit_folder, sit_seeds,
};
use bench_files::write_atomically;
use indicatif::{ProgressBar, ProgressStyle};
use parallel::parallel_map;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;
use crate::views::exam::text;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Seeds of the benches: the first, and the one after the last
    #[arg(long, value_name = "FROM..TO", default_value = "0..40")]
    pub seeds: Seeds,
    /// Mark the benches in DIR instead, each a folder with bench.toml and truth.json
    #[arg(long, value_name = "DIR", conflicts_with = "seeds")]
    pub folder: Option<PathBuf>,
    /// Folder for the marks of every bench (CSV) and the figures
    #[arg(long, value_name = "DIR", default_value = "out/exam")]
    pub out: PathBuf,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// A range of seeds.
#[derive(Clone, Copy)]
pub struct Seeds {
    from: u64,
    to: u64,
}

impl FromStr for Seeds {
    type Err = String;

    fn from_str(text: &str) -> Result<Seeds, String> {
        let numbers = text
            .split_once("..")
            .and_then(|(from, to)| Some((from.parse().ok()?, to.parse().ok()?)));
        match numbers {
            Some((from, to)) if from < to => Ok(Seeds { from, to }),
            _ => Err("two whole numbers are needed, the smaller one first, such as 0..40".into()),
        }
    }
}

impl From<SitError> for Failure {
    fn from(error: SitError) -> Failure {
        match error {
            SitError::Bench(error) => error.into(),
            other => Failure::new(other.to_string()),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let Sitting { entries, void } = match &arguments.folder {
        Some(folder) => from_folder(folder)?,
        None => drawn(arguments.seeds),
    };
    if entries.is_empty() {
        return Err(Failure::new(
            "none of these seeds gives a bench that can be marked, because their hidden effects are too small to show; \
             choose other seeds",
        ));
    }
    let marks = Marks::of(&entries);
    let mut report = ExamReport::new(&entries, void, &marks);
    report.files = write_files(&arguments.out, &entries, &marks)?;
    Report::new(text(&report), &report)
}

fn bar(length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let template = "{bar:40} {pos}/{len} benches, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// The benches of these seeds.
fn drawn(seeds: Seeds) -> Sitting {
    let bar = bar(seeds.to - seeds.from);
    let sitting = sit_seeds(seeds.from..seeds.to, &|| bar.inc(1));
    bar.finish_and_clear();
    sitting
}

/// The benches of a folder.
fn from_folder(folder: &Path) -> Result<Sitting, Failure> {
    let benches = benches_in(folder)?;
    let bar = bar(benches.len() as u64);
    let entries = parallel_map(&benches, |path| {
        let entry = sit_folder(path);
        bar.inc(1);
        entry
    });
    let entries: Result<Vec<Entry>, SitError> = entries.into_iter().collect();
    bar.finish_and_clear();
    Ok(Sitting {
        entries: entries?,
        void: vec![],
    })
}

fn write_files(out: &Path, entries: &[Entry], marks: &Marks) -> Result<Vec<PathBuf>, Failure> {
    std::fs::create_dir_all(out).map_err(|error| Failure::in_file(out, error))?;
    let table = out.join("exam.csv");
    write_atomically(
        &table,
        &benches_csv(entries).map_err(|error| Failure::in_file(&table, error))?,
    )?;
    let intervals = out.join("exam-intervals.csv");
    write_atomically(
        &intervals,
        &intervals_csv(entries).map_err(|error| Failure::in_file(&intervals, error))?,
    )?;
    let mut files = vec![table, intervals];
    let drawings = marks
        .drawings(entries.len())
        .map_err(workbench::Error::from)?;
    for (name, figure) in drawings {
        let file = out.join(name);
        write_atomically(&file, figure.as_bytes())?;
        files.push(file);
    }
    Ok(files)
}
