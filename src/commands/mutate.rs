//! `flywheel mutate DIR`

use std::path::PathBuf;

use bench_files::write_atomically;
use checker::certificate::Certificate;
use checker::mutate::{MutantVerdict, Summary, chosen, judged, notices, summary};
use checker::prove::Emitted;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;

use crate::cli::Output;
use crate::failure::Failure;
use crate::report::Report;
use crate::report::table::{Align, Table};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of an emitted crate; nothing in it is changed
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// At most N mutants of each file, evenly spread [default: all]
    #[arg(long, value_name = "N")]
    pub most: Option<usize>,
    /// Write one line for each mutant to FILE
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Serialize)]
struct Mutation {
    folder: PathBuf,
    summary: Summary,
    verdicts: Vec<MutantVerdict>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = &arguments.folder;
    let read = |error: String| Failure::new(error);
    let emitted = Emitted::read(folder).map_err(|error| read(error.to_string()))?;
    let certificate =
        Certificate::parse(&emitted.certificate).map_err(|error| read(error.to_string()))?;
    if let Some(notice) = notices(&emitted, &certificate).first() {
        return Err(Failure::new(format!(
            "{}: the claim {} fails without any damage; see flywheel prove",
            folder.display(),
            notice.claim
        )));
    }
    let mutants = chosen(&emitted, arguments.most);
    let progress = ProgressBar::new(mutants.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} mutants ({eta} left)") {
        progress.set_style(style);
    }
    let verdicts: Vec<MutantVerdict> = mutants
        .into_par_iter()
        .map(|mutant| {
            let verdict = judged(&emitted, &certificate, mutant);
            progress.inc(1);
            verdict
        })
        .collect();
    progress.finish_and_clear();
    if let Some(path) = &arguments.csv {
        let table = csv_of(&verdicts).map_err(|error| Failure::in_file(path, error))?;
        write_atomically(path, &table)?;
    }
    let summary = summary(&verdicts);
    let text = format!("{}: {}", folder.display(), text(&summary, &verdicts));
    Report::new(
        text,
        &Mutation {
            folder: folder.clone(),
            summary,
            verdicts,
        },
    )
}

fn text(summary: &Summary, verdicts: &[MutantVerdict]) -> String {
    let mut kinds = Table::new(&[
        ("kind", Align::Left),
        ("caught", Align::Right),
        ("of", Align::Right),
    ]);
    for (kind, (caught, all)) in &summary.by_kind {
        kinds.row([(*kind).to_owned(), caught.to_string(), all.to_string()]);
    }
    let mut engines = Table::new(&[("noticed first by", Align::Left), ("mutants", Align::Right)]);
    for (engine, count) in &summary.by_engine {
        engines.row([(*engine).to_owned(), count.to_string()]);
    }
    let mut list = Table::without_head(&[Align::Left; 4]);
    for verdict in verdicts.iter().filter(|verdict| verdict.noticed.is_empty()) {
        let mutant = &verdict.mutant;
        let reason = match verdict.reason.as_str() {
            "" => "no reason known",
            reason => reason,
        };
        list.row([
            format!("{}:{}:{}", mutant.file, mutant.line, mutant.column),
            mutant.kind.to_owned(),
            format!("`{}` -> `{}`", mutant.before, mutant.after),
            reason.to_owned(),
        ]);
    }
    let survivors = summary.mutants - summary.caught;
    let listed = if list.is_empty() {
        String::new()
    } else {
        format!("\nSurvivors\n{}", list.text())
    };
    format!(
        "{} of {} mutants caught; of the {} others {} proved to change nothing, {} without a \
         difference in random runs, {} unexplained\n\n{}\n{}{listed}",
        summary.caught,
        summary.mutants,
        survivors,
        summary.same,
        summary.no_difference_found,
        survivors - summary.same - summary.no_difference_found,
        kinds.text(),
        engines.text(),
    )
}

fn csv_of(verdicts: &[MutantVerdict]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(vec![]);
    writer.write_record([
        "file", "line", "column", "kind", "before", "after", "fate", "claim", "engine", "reason",
    ])?;
    for verdict in verdicts {
        let mutant = &verdict.mutant;
        let (claim, engine) = verdict
            .noticed
            .first()
            .map_or(("", ""), |notice| (notice.claim.as_str(), notice.engine));
        writer.write_record([
            mutant.file.as_str(),
            &mutant.line.to_string(),
            &mutant.column.to_string(),
            mutant.kind,
            &mutant.before,
            &mutant.after,
            verdict.fate.as_str(),
            claim,
            engine,
            &verdict.reason,
        ])?;
    }
    writer
        .into_inner()
        .map_err(|error| csv::Error::from(std::io::Error::other(error.to_string())))
}
