//! A record in words.

use std::path::Path;

use workbench::RecordReport;
use workbench::numbers::number;

/// The logs that were written, lost frames, and the next command.
pub fn text(bench: &Path, report: &RecordReport) -> String {
    let mut text = String::new();
    for log in &report.logs {
        text.push_str(&format!(
            "{}  ({}, {})\n  {} rows, {} s; ended: {}\n",
            log.name,
            log.kind,
            log.file.display(),
            log.rows,
            number(log.duration_s),
            log.end
        ));
        if log.lost_frames > 0 || log.damaged_frames > 0 {
            text.push_str(&format!(
                "  {} frames lost, {} damaged; the column lost_frames shows before which rows\n",
                log.lost_frames, log.damaged_frames
            ));
        }
        if let Some(from_s) = log.from_s {
            text.push_str(&format!("  used from {} s\n", number(from_s)));
        }
        for note in &log.notes {
            text.push_str(&format!("  {note}\n"));
        }
    }
    text.push_str(&format!("\nWritten: {}\n", report.bench.display()));
    let is_bring_up = report.logs.iter().all(|log| log.kind == "bring-up");
    let next = if is_bring_up { "bring-up" } else { "check" };
    text + &format!("Next: flywheel {next} {}\n", bench.display())
}
