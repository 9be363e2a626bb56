//! The marks of an exam.

use exam::{ExamReport, Rate};

use crate::report::table::{Align, Table};

/// A share with the interval in which it lies.
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

/// The whole text.
pub fn text(report: &ExamReport) -> String {
    let mut text = match report.benches {
        1 => "Exam of 1 bench".to_owned(),
        benches => format!("Exam of {benches} benches"),
    };
    if !report.void.is_empty() {
        text.push_str(&format!(
            " ({} further seeds give no bench, because their hidden term is too small to count)",
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
