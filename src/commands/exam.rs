//! `flywheel exam`

use std::path::{Path, PathBuf};
use std::str::FromStr;

use ::exam::{
    Entry, ExamReport, Marks, Rate, SitError, Sitting, benches_csv, benches_in, intervals_csv,
    sit_folder, sit_seeds,
};
use bench_files::write_atomically;
use figures::{Confusion, Reliability, ReliabilityBin};
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::report::Report;
use crate::report::table::{Align, Table};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Seeds of the benches that are drawn: the first, and the one after the last
    #[arg(long, value_name = "FROM..TO", default_value = "0..40")]
    pub seeds: Seeds,
    /// Mark the benches that lie in DIR instead, each a folder with bench.toml and truth.json
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
        return Err(Failure::new("none of these seeds has a bench that counts"));
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
    let entries: Result<Vec<Entry>, SitError> = benches
        .par_iter()
        .map(|path| {
            let entry = sit_folder(path);
            bar.inc(1);
            entry
        })
        .collect();
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
    let truths: Vec<&str> = marks.truths.iter().map(String::as_str).collect();
    let answers: Vec<&str> = marks.answers.iter().map(String::as_str).collect();
    let confusion = out.join("exam-confusion.svg");
    let subtitle = format!("{} benches", entries.len());
    let figure = figures::confusion(&Confusion {
        title: "What was hidden, and what was answered",
        subtitle: &subtitle,
        truths: &truths,
        answers: &answers,
        counts: &marks.confusion,
    })
    .map_err(workbench::Error::from)?;
    write_atomically(&confusion, figure.as_bytes())?;
    let bins: Vec<ReliabilityBin> = marks
        .calibration
        .iter()
        .map(|bin| {
            let (low, high) = bin.came_true.interval();
            ReliabilityBin {
                stated: bin.stated,
                frequency: bin.came_true.share(),
                low,
                high,
                count: bin.came_true.of,
            }
        })
        .collect();
    let reliability = out.join("exam-reliability.svg");
    let figure = figures::reliability(&Reliability {
        title: "Stated probabilities, and how often they came true",
        subtitle: &subtitle,
        bins: &bins,
        tolerance: 0.05,
    });
    write_atomically(&reliability, figure.as_bytes())?;
    Ok(vec![table, intervals, confusion, reliability])
}

fn percent(rate: Rate) -> String {
    if rate.of == 0 {
        return "–".to_owned();
    }
    let (low, high) = rate.interval();
    format!(
        "{:.1} % ({:.0} to {:.0})",
        100.0 * rate.share(),
        100.0 * low,
        100.0 * high
    )
}

fn text(report: &ExamReport) -> String {
    let mut text = match report.benches {
        1 => "Exam of 1 bench".to_owned(),
        benches => format!("Exam of {benches} benches"),
    };
    if !report.void.is_empty() {
        text.push_str(&format!(
            " ({} seeds have none: their hidden term does not count)",
            report.void.len()
        ));
    }
    text.push_str("\n\n");
    let mut table = Table::new(&[
        ("mark", Align::Left),
        ("reached", Align::Left),
        ("benches", Align::Right),
        ("asked", Align::Left),
    ]);
    for (name, rate, asked) in [
        (
            "right effect first (trace 3 times the noise or more)",
            report.right_effect_first,
            "95 %",
        ),
        (
            "right effect among the first two",
            report.right_effect_among_first_two,
            "99 %",
        ),
        (
            "both of two effects (each 3 times the noise or more)",
            report.both_of_two,
            "85 %",
        ),
        (
            "outsiders called unexplained",
            report.outsiders_unexplained,
            "90 %",
        ),
        (
            "false alarms where nothing is hidden",
            report.false_alarms,
            "at most 2 %",
        ),
        (
            "wrong confident verdicts",
            report.wrong_confident,
            "at most 1 %",
        ),
        ("ties called ambiguous", report.ties_called_ambiguous, ""),
        (
            "95 % intervals that hold the truth",
            report.interval_coverage,
            "92 to 98 %",
        ),
    ] {
        table.row([
            name.to_owned(),
            percent(rate),
            rate.of.to_string(),
            asked.to_owned(),
        ]);
    }
    text.push_str(&table.text());
    for (heading, rows) in [
        ("hidden", &report.by_effect),
        ("size of the trace in units of noise", &report.by_size),
        ("noise of the angle", &report.by_noise),
    ] {
        let mut table = Table::new(&[
            (heading, Align::Left),
            ("marked right", Align::Left),
            ("benches", Align::Right),
        ]);
        for (name, rate) in rows.iter() {
            table.row([name.clone(), percent(*rate), rate.of.to_string()]);
        }
        text.push('\n');
        text.push_str(&table.text());
    }
    let mut table = Table::new(&[
        ("stated probability", Align::Right),
        ("came true", Align::Left),
        ("statements", Align::Right),
    ]);
    for bin in &report.calibration {
        table.row([
            format!("{:.1} %", 100.0 * bin.stated),
            percent(bin.came_true),
            bin.came_true.of.to_string(),
        ]);
    }
    text.push('\n');
    text.push_str(&table.text());
    text.push_str("\nWritten\n");
    for file in &report.files {
        text.push_str(&format!("  {}\n", file.display()));
    }
    text
}
