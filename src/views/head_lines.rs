//! The first lines of a report on a bench.

use workbench::BenchNote;

/// A number of things: "1 experiment", "8 experiments".
pub fn counted(number: usize, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// The line that names the bench, and the notes on its files.
pub fn head_lines(bench: &str, experiments: usize, samples: usize, notes: &[BenchNote]) -> String {
    let mut text = format!(
        "{bench}: {}, {}\n",
        counted(experiments, "experiment"),
        counted(samples, "sample")
    );
    for BenchNote { experiment, note } in notes {
        match experiment {
            Some(experiment) => text.push_str(&format!("  {experiment}: {note}\n")),
            None => text.push_str(&format!("  {note}\n")),
        }
    }
    text
}
