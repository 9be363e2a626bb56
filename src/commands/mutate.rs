//! `flywheel mutate DIR`

use std::path::PathBuf;

use checker::mutate::{MutantVerdict, Summary};
use workbench::mutate;

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::progress::with_progress;
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
    pub output: JsonOutput,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let folder = &arguments.folder;
    let report = with_progress(|progress| mutate(folder, arguments.most, progress))?;
    if let Some(path) = &arguments.csv {
        bench_files::write_atomically(path, report.table()?.text.as_bytes())?;
    }
    let text = text(&report.summary, &report.verdicts);
    Report::new(format!("{}: {text}", folder.display()), &report)
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
