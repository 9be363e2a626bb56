//! The harnesses of the crate `verify`, run by Kani.

use std::path::Path;
use std::process::Command;

use crate::claims::outcome::{ClaimOutcome, KANI};
use crate::prove::results::{ClaimResult, Table};
use crate::prove::settings::ProofSettings;

/// Claims that harnesses of the crate `verify` settle. A harness belongs to the claim with whose name it begins. A
/// harness that begins with no claim's name shows a contract or a range on which other harnesses rest; it counts for
/// `primitives`.
const CLAIMS: [&str; 6] = [
    "control-total",
    "control-accurate",
    "primitives",
    "filter-total",
    "step-total",
    "supervisor",
];

/// The harnesses of the crate `verify` beside `directory`, if Kani is installed.
pub(crate) fn kani(directory: &Path, settings: &ProofSettings) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new(), None);
    match output(directory, settings) {
        Ok(text) => {
            for (id, outcome, seconds) in kani_rows(&text) {
                table.row(id, KANI, outcome, seconds);
            }
        }
        Err(why) => {
            for id in CLAIMS {
                table.row(id, KANI, ClaimOutcome::NotRun(why.clone()), 0.0);
            }
        }
    }
    table.0
}

/// The output of Kani, or the reason why it did not run.
fn output(directory: &Path, settings: &ProofSettings) -> Result<String, String> {
    if !settings.kani {
        return Err("switched off".to_owned());
    }
    // The harnesses call the crate `generated` beside them, and no other.
    let is_theirs = directory
        .canonicalize()
        .is_ok_and(|path| path.file_name().is_some_and(|name| name == "generated"));
    let manifest = directory.join("../verify/Cargo.toml");
    if !is_theirs || !manifest.is_file() {
        return Err("no harnesses (crate verify) belong to this folder".to_owned());
    }
    let is_installed = Command::new("cargo")
        .args(["kani", "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !is_installed {
        return Err("cargo kani is not installed".to_owned());
    }
    let output = Command::new("cargo")
        .arg("kani")
        .arg("--manifest-path")
        .arg(&manifest)
        .output()
        .map_err(|error| format!("cargo kani: {error}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if text.lines().any(|line| line.starts_with(VERDICT)) {
        Ok(text)
    } else {
        let lines = String::from_utf8_lossy(&output.stderr).into_owned();
        let last = lines.lines().rev().find(|line| !line.trim().is_empty());
        Err(format!("cargo kani: {}", last.unwrap_or("no harness ran")))
    }
}

/// The line that ends a harness.
const VERDICT: &str = "VERIFICATION:- ";

/// Kani's results by claim: a claim is proved if all its harnesses succeeded and every cover was
/// reached.
fn kani_rows(text: &str) -> Vec<(&'static str, ClaimOutcome, f64)> {
    let mut failed: [Option<String>; CLAIMS.len()] = Default::default();
    let mut harnesses = [0_usize; CLAIMS.len()];
    let mut seconds = [0.0; CLAIMS.len()];
    let mut at = 0;
    let mut name = "";
    for line in text.lines().map(str::trim) {
        if let Some(rest) = line.strip_prefix("Checking harness ") {
            let harness = rest.trim_end_matches("...");
            name = harness.rsplit("::").next().unwrap_or(harness);
            let claim = name.replace('_', "-");
            let is_of = |id: &str| {
                let rest = claim.strip_prefix(id);
                rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
            };
            let own = CLAIMS.iter().position(|id| is_of(id));
            at = own.unwrap_or(2);
        } else if let Some(verdict) = line.strip_prefix(VERDICT) {
            harnesses[at] += 1;
            if !verdict.starts_with("SUCCESSFUL") {
                failed[at].get_or_insert(format!("{name}: {verdict}"));
            }
        } else if let Some(covers) = line.strip_suffix("cover properties satisfied") {
            // "** 3 of 4": a cover that is not reached means that its region was not tested.
            let counts: Vec<&str> = covers.split_whitespace().collect();
            if let [.., reached, "of", all] = counts.as_slice()
                && reached != all
            {
                failed[at].get_or_insert(format!("{name}: {reached} of {all} covers are reached"));
            }
        } else if let Some(time) = line.strip_prefix("Verification Time: ") {
            seconds[at] += time.trim_end_matches('s').parse().unwrap_or(0.0);
        }
    }
    let rows = CLAIMS.iter().enumerate().map(|(at, id)| {
        let outcome = match (&failed[at], harnesses[at]) {
            (Some(why), _) => ClaimOutcome::Failed(why.clone()),
            (None, 0) => ClaimOutcome::NotRun("none of its harnesses ran".to_owned()),
            (None, count) => ClaimOutcome::Proved(format!("{count} harnesses")),
        };
        (*id, outcome, seconds[at])
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kani_output_is_read() {
        let text = "Checking harness proofs::control_total...\n ** 4 of 4 cover properties satisfied\n\
                    VERIFICATION:- SUCCESSFUL\nVerification Time: 2.25s\n\
                    Checking harness proofs::control_accurate...\n\
                    VERIFICATION:- FAILED\nVerification Time: 20s\n\
                    Checking harness attitude::seed_contract...\nVERIFICATION:- SUCCESSFUL\n\
                    Checking harness attitude::step_total...\n\
                     ** 1 of 2 cover properties satisfied\nVERIFICATION:- SUCCESSFUL\n\
                    Checking harness proofs::supervisor_counts...\nVERIFICATION:- SUCCESSFUL\n";
        let rows = kani_rows(text);
        let words: Vec<_> = rows.iter().map(|(_, outcome, _)| outcome.word()).collect();
        assert_eq!(
            words,
            ["proved", "failed", "proved", "not run", "failed", "proved"]
        );
        assert_eq!((rows[0].0, rows[0].2), ("control-total", 2.25));
        assert!(rows[4].1.why().contains("1 of 2"), "{:?}", rows[4].1);
    }
}
