//! The harnesses of the crate `verify`, run by Kani.

use std::path::Path;
use std::process::Command;

use crate::claims::outcome::{ClaimOutcome, KANI};
use crate::prove::results::{ClaimResult, Table};
use crate::prove::settings::ProofSettings;

/// The harnesses of the crate `verify` beside `directory`, where Kani is installed.
pub(crate) fn kani(directory: &Path, settings: &ProofSettings) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new());
    let not_run = |table: &mut Table, why: &str| {
        for id in [
            "control-total",
            "control-accurate",
            "filter-total",
            "step-total",
        ] {
            table.row(id, KANI, ClaimOutcome::NotRun(why.to_owned()), 0.0);
        }
    };
    if !settings.kani {
        not_run(&mut table, "switched off");
        return table.0;
    }
    let is_installed = Command::new("cargo")
        .args(["kani", "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !is_installed {
        not_run(&mut table, "cargo kani is not installed");
        return table.0;
    }
    let manifest = directory.join("../verify/Cargo.toml");
    if !manifest.is_file() {
        not_run(
            &mut table,
            "the harnesses (crate verify) are not beside the folder",
        );
        return table.0;
    }
    let output = Command::new("cargo")
        .arg("kani")
        .arg("--manifest-path")
        .arg(&manifest)
        .output();
    match output {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            let rows = kani_rows(&text);
            if rows.is_empty() {
                let lines = String::from_utf8_lossy(&output.stderr).into_owned();
                let last = lines.lines().last().unwrap_or("no harness ran");
                not_run(&mut table, &format!("cargo kani: {last}"));
            }
            for (id, outcome, seconds) in rows {
                table.row(&id, KANI, outcome, seconds);
            }
        }
        Err(error) => not_run(&mut table, &format!("cargo kani: {error}")),
    }
    table.0
}

/// Harness by harness what Kani printed.
fn kani_rows(text: &str) -> Vec<(String, ClaimOutcome, f64)> {
    let mut rows = Vec::new();
    let mut name = String::new();
    let mut outcome = None;
    for line in text.lines() {
        if let Some(rest) = line.strip_prefix("Checking harness ") {
            let harness = rest.trim_end_matches("...");
            name = harness
                .rsplit("::")
                .next()
                .unwrap_or(harness)
                .replace('_', "-");
        } else if let Some(verdict) = line.strip_prefix("VERIFICATION:- ") {
            outcome = Some(if verdict.starts_with("SUCCESSFUL") {
                ClaimOutcome::Proved("every check of the harness".to_owned())
            } else {
                ClaimOutcome::Failed(format!("Kani: {verdict}"))
            });
        } else if let Some(time) = line.strip_prefix("Verification Time: ")
            && let Some(outcome) = outcome.take()
        {
            let seconds = time.trim_end_matches('s').parse().unwrap_or(0.0);
            rows.push((name.clone(), outcome, seconds));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kani_output_is_read() {
        let text = "Checking harness proofs::control_total...\nVERIFICATION:- SUCCESSFUL\n\
                    Verification Time: 2.25s\nChecking harness proofs::control_accurate...\n\
                    VERIFICATION:- FAILED\nVerification Time: 20s\n";
        let rows = kani_rows(text);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].0, "control-total");
        assert!(matches!(rows[0].1, ClaimOutcome::Proved(_)) && rows[0].2 == 2.25);
        assert!(matches!(rows[1].1, ClaimOutcome::Failed(_)));
    }
}
