//! `flywheel exam`

use std::path::{Path, PathBuf};
use std::str::FromStr;

use ::diagnose::exam::{Answer, Entry, Marks, Rate, answer_from, joined, mark, sit};
use ::identify::Setup;
use bench_files::{Bench, write_atomically};
use figures::{Confusion, Reliability, ReliabilityBin};
use indicatif::{ProgressBar, ProgressStyle};
use plant::EffectId;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::cli::Output;
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
    pub output: Output,
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

/// The truth of a bench (contract).
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TruthJson {
    effects: Vec<String>,
    #[serde(default)]
    parameters: serde_json::Map<String, serde_json::Value>,
}

#[derive(Serialize)]
struct RateJson {
    count: usize,
    of: usize,
    share: f64,
    interval_95: [f64; 2],
}

impl From<Rate> for RateJson {
    fn from(rate: Rate) -> RateJson {
        let (low, high) = rate.interval();
        RateJson {
            count: rate.count,
            of: rate.of,
            share: rate.share(),
            interval_95: [low, high],
        }
    }
}

#[derive(Serialize)]
struct BenchJson {
    bench: String,
    truth: Vec<String>,
    sizes: Vec<f64>,
    noise: Vec<f64>,
    verdict: &'static str,
    named: Vec<&'static str>,
    suspects: Vec<(&'static str, f64)>,
    mark: &'static str,
    seconds: f64,
}

#[derive(Serialize)]
struct CalibrationJson {
    stated: f64,
    came_true: RateJson,
}

#[derive(Serialize)]
struct ExamJson {
    benches: usize,
    void: Vec<u64>,
    right_effect_first: RateJson,
    right_effect_among_first_two: RateJson,
    both_of_two: RateJson,
    outsiders_unexplained: RateJson,
    false_alarms: RateJson,
    wrong_confident: RateJson,
    ties_called_ambiguous: RateJson,
    interval_coverage: RateJson,
    calibration: Vec<CalibrationJson>,
    by_effect: Vec<(String, RateJson)>,
    by_size: Vec<(String, RateJson)>,
    by_noise: Vec<(String, RateJson)>,
    verdicts: Vec<BenchJson>,
    files: Vec<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let (entries, void) = match &arguments.folder {
        Some(folder) => (from_folder(folder)?, vec![]),
        None => drawn(arguments.seeds),
    };
    if entries.is_empty() {
        return Err(Failure::new("none of these seeds has a bench that counts"));
    }
    let marks = Marks::of(&entries);
    let files = write_files(&arguments.out, &entries, &marks)?;
    let by_effect = Marks::by(&entries, |entry| entry.truth.clone());
    let by_size = Marks::by(&entries, |entry| entry.size_class());
    let by_noise = Marks::by(&entries, |entry| entry.noise_class());
    let text = text(
        &entries,
        &void,
        &marks,
        &[
            ("hidden", &by_effect),
            ("size of the trace in units of noise", &by_size),
            ("noise of the angle", &by_noise),
        ],
        &files,
    );
    let rates = |rows: Vec<(String, Rate)>| -> Vec<(String, RateJson)> {
        rows.into_iter()
            .map(|(name, rate)| (name, rate.into()))
            .collect()
    };
    let json = ExamJson {
        benches: entries.len(),
        void,
        right_effect_first: marks.first.into(),
        right_effect_among_first_two: marks.first_two.into(),
        both_of_two: marks.both.into(),
        outsiders_unexplained: marks.outsiders.into(),
        false_alarms: marks.false_alarms.into(),
        wrong_confident: marks.wrong.into(),
        ties_called_ambiguous: marks.ties.into(),
        interval_coverage: marks.coverage.into(),
        calibration: marks
            .calibration
            .iter()
            .map(|bin| CalibrationJson {
                stated: bin.stated,
                came_true: bin.came_true.into(),
            })
            .collect(),
        by_effect: rates(by_effect),
        by_size: rates(by_size),
        by_noise: rates(by_noise),
        verdicts: entries.iter().map(bench_json).collect(),
        files,
    };
    Report::new(text, &json)
}

fn names(effects: &[EffectId]) -> Vec<&'static str> {
    effects.iter().map(|effect| effect.name()).collect()
}

fn bench_json(entry: &Entry) -> BenchJson {
    BenchJson {
        bench: entry.label.clone(),
        truth: entry.truth.clone(),
        sizes: entry.sizes.clone(),
        noise: entry.noise.clone(),
        verdict: entry.paper.verdict.name(),
        named: names(&entry.paper.named),
        suspects: entry
            .paper
            .suspects
            .iter()
            .map(|(effect, probability)| (effect.name(), *probability))
            .collect(),
        mark: entry.paper.mark.name(),
        seconds: entry.paper.seconds,
    }
}

fn bar(length: u64) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let template = "{bar:40} {pos}/{len} benches, {eta} left";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// The benches of these seeds, in their order, and the seeds that have none.
fn drawn(seeds: Seeds) -> (Vec<Entry>, Vec<u64>) {
    let bar = bar(seeds.to - seeds.from);
    let results: Vec<(u64, Option<Entry>)> = (seeds.from..seeds.to)
        .into_par_iter()
        .map(|seed| {
            let entry = sit(seed);
            bar.inc(1);
            (seed, entry)
        })
        .collect();
    bar.finish_and_clear();
    let void = results
        .iter()
        .filter(|(_, entry)| entry.is_none())
        .map(|(seed, _)| *seed)
        .collect();
    (
        results.into_iter().filter_map(|(_, entry)| entry).collect(),
        void,
    )
}

/// The benches in a folder: itself if it holds a truth.json, else its sub-folders that do.
fn from_folder(folder: &Path) -> Result<Vec<Entry>, Failure> {
    let mut benches = vec![];
    if folder.join("truth.json").is_file() {
        benches.push(folder.to_owned());
    } else {
        let listing = std::fs::read_dir(folder).map_err(|error| Failure::in_file(folder, error))?;
        for item in listing {
            let path = item
                .map_err(|error| Failure::in_file(folder, error))?
                .path();
            if path.join("truth.json").is_file() {
                benches.push(path);
            }
        }
        benches.sort();
    }
    if benches.is_empty() {
        return Err(Failure::in_file(
            folder,
            "there is no bench with a truth.json: neither here nor one folder below",
        ));
    }
    let bar = bar(benches.len() as u64);
    let entries = benches
        .par_iter()
        .map(|path| {
            let entry = marked_bench(path);
            bar.inc(1);
            entry
        })
        .collect();
    bar.finish_and_clear();
    entries
}

fn marked_bench(path: &Path) -> Result<Entry, Failure> {
    let file = path.join("truth.json");
    let source = std::fs::read_to_string(&file).map_err(|error| Failure::in_file(&file, error))?;
    // The message of serde_json ends with line and column.
    let truth: TruthJson =
        serde_json::from_str(&source).map_err(|error| Failure::in_file(&file, error))?;
    let parameters = truth
        .parameters
        .iter()
        .filter_map(|(name, value)| Some((name.clone(), value.as_f64()?)))
        .collect();
    let answer: Answer = answer_from(&truth.effects, parameters)
        .map_err(|message| Failure::in_file(&file, message))?;
    let bench = Bench::load(path)?;
    let setup = Setup::new(&bench).map_err(|error| Failure::in_file(path, error))?;
    let paper =
        mark(&setup, &answer, EffectId::ALL).map_err(|message| Failure::in_file(path, message))?;
    let truth = if truth.effects.is_empty() {
        vec!["nothing".to_owned()]
    } else {
        truth.effects
    };
    Ok(Entry {
        label: bench.name,
        truth,
        hidden: answer.effects,
        outside: answer.outside,
        sizes: vec![],
        noise: vec![],
        experiments: setup
            .records
            .iter()
            .map(|record| record.name.clone())
            .collect(),
        observations: setup
            .records
            .iter()
            .map(|record| record.observations())
            .sum(),
        paper,
    })
}

fn write_files(out: &Path, entries: &[Entry], marks: &Marks) -> Result<Vec<PathBuf>, Failure> {
    std::fs::create_dir_all(out).map_err(|error| Failure::in_file(out, error))?;
    let table = out.join("exam.csv");
    write_atomically(
        &table,
        &csv_of(entries).map_err(|error| Failure::in_file(&table, error))?,
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

fn finished(writer: csv::Writer<Vec<u8>>) -> Result<Vec<u8>, csv::Error> {
    writer
        .into_inner()
        .map_err(|error| csv::Error::from(std::io::Error::other(error.to_string())))
}

fn csv_of(entries: &[Entry]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "bench",
        "hidden",
        "size_over_noise",
        "trace_beside_others_over_noise",
        "noise_angle_rad",
        "noise_rate_rad_s",
        "noise_wheel_speed_rad_s",
        "experiments",
        "observations",
        "verdict",
        "named",
        "first_suspect",
        "probability",
        "second_suspect",
        "remainder_over_noise",
        "ties",
        "mark",
        "seconds",
    ])?;
    let list = |values: &[f64]| {
        let texts: Vec<String> = values.iter().map(|value| format!("{value:.3}")).collect();
        texts.join(" ")
    };
    for entry in entries {
        let paper = &entry.paper;
        let suspect = |index: usize| paper.suspects.get(index);
        let noise = |index: usize| {
            entry
                .noise
                .get(index)
                .map_or(String::new(), |noise| format!("{noise:.3e}"))
        };
        let ties: Vec<String> = paper.ties.iter().map(|(set, _)| joined(set)).collect();
        writer.write_record([
            entry.label.clone(),
            entry.truth.join(" + "),
            list(&entry.sizes),
            list(&paper.shown),
            noise(0),
            noise(1),
            noise(2),
            entry.experiments.join("; "),
            entry.observations.to_string(),
            paper.verdict.name().to_owned(),
            joined(&paper.named),
            suspect(0).map_or(String::new(), |(effect, _)| effect.name().to_owned()),
            suspect(0).map_or(String::new(), |(_, probability)| {
                format!("{probability:.4}")
            }),
            suspect(1).map_or(String::new(), |(effect, _)| effect.name().to_owned()),
            format!("{:.3}", paper.remainder),
            ties.join("; "),
            paper.mark.name().to_owned(),
            format!("{:.2}", paper.seconds),
        ])?;
    }
    finished(writer)
}

fn intervals_csv(entries: &[Entry]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "bench",
        "parameter",
        "true_si",
        "value_si",
        "std_si",
        "inside_95",
    ])?;
    for entry in entries {
        for interval in &entry.paper.intervals {
            writer.write_record([
                entry.label.clone(),
                interval.name.to_owned(),
                format!("{:.6e}", interval.truth),
                format!("{:.6e}", interval.value),
                format!("{:.3e}", interval.std),
                interval.covers().to_string(),
            ])?;
        }
    }
    finished(writer)
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

fn text(
    entries: &[Entry],
    void: &[u64],
    marks: &Marks,
    classes: &[(&str, &Vec<(String, Rate)>)],
    files: &[PathBuf],
) -> String {
    let mut text = format!("Exam of {} benches", entries.len());
    if !void.is_empty() {
        text.push_str(&format!(
            " ({} seeds have none: their hidden term does not count)",
            void.len()
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
            marks.first,
            "95 %",
        ),
        ("right effect among the first two", marks.first_two, "99 %"),
        (
            "both of two effects (each 3 times the noise or more)",
            marks.both,
            "85 %",
        ),
        ("outsiders called unexplained", marks.outsiders, "90 %"),
        (
            "false alarms where nothing is hidden",
            marks.false_alarms,
            "at most 2 %",
        ),
        ("wrong confident verdicts", marks.wrong, "at most 1 %"),
        ("ties called ambiguous", marks.ties, ""),
        (
            "95 % intervals that hold the truth",
            marks.coverage,
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
    for (heading, rows) in classes {
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
    for bin in &marks.calibration {
        table.row([
            format!("{:.1} %", 100.0 * bin.stated),
            percent(bin.came_true),
            bin.came_true.of.to_string(),
        ]);
    }
    text.push('\n');
    text.push_str(&table.text());
    text.push_str("\nWritten\n");
    for file in files {
        text.push_str(&format!("  {}\n", file.display()));
    }
    text
}
