//! The harnesses that were emitted with the crate, run by Kani.

use std::fs;
use std::io;
use std::path::Path;

use crate::certificate::reader::Certificate;
use crate::claims::closed_loop_agreement::NO_MODES;
use crate::claims::outcome::{ClaimOutcome, KANI};
use crate::claims::texts_audited;
use crate::compiled::surroundings::{cargo, in_the_way};
use crate::language::emitted::Emitted;
use crate::language::manifest;
use crate::prove::results::{ClaimResult, Table};
use crate::prove::settings::ProofSettings;

/// Claims that the emitted harnesses settle. A harness belongs to the claim with whose name it begins. A
/// harness that begins with no claim's name shows a contract or a range on which other harnesses rest; it counts for
/// `primitives`.
const CLAIMS: [&str; 7] = [
    "control-total",
    "control-accurate",
    "primitives",
    "filter-total",
    "step-total",
    "supervisor",
    "closed-loop-agreement",
];

/// The harnesses that were emitted with the crate, if Kani is installed.
pub(crate) fn kani(
    emitted: &Emitted,
    certificate: &Certificate,
    settings: &ProofSettings,
) -> Vec<ClaimResult> {
    let mut table = Table(Vec::new(), None);
    match output(emitted, settings) {
        Ok(text) => {
            for (id, outcome, seconds) in kani_rows(&text) {
                // Without modes all numbers of the harness are zero, and it proves nothing.
                let is_empty = id == "closed-loop-agreement" && certificate.modes.is_none();
                let outcome = if is_empty {
                    ClaimOutcome::NotRun(NO_MODES.to_owned())
                } else {
                    outcome
                };
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
fn output(emitted: &Emitted, settings: &ProofSettings) -> Result<String, String> {
    if !settings.kani {
        return Err("switched off".to_owned());
    }
    if emitted.harnesses.is_empty() {
        return Err("the folder has no harnesses (verify/): generate it again".to_owned());
    }
    if settings.audited_texts {
        texts_audited::of_files(&emitted.harnesses)?;
    }
    let fixed_version = manifest::read(&emitted.cargo)?.fixed_version;
    let io = |error: std::io::Error| format!("a temporary folder: {error}");
    let folder = tempfile::tempdir().map_err(io)?;
    let root = folder.path();
    if let Some(path) = in_the_way(root) {
        return Err(format!(
            "{path} would count for a build in {}",
            root.display()
        ));
    }
    let is_installed = cargo(root)
        .args(["kani", "--version"])
        .output()
        .is_ok_and(|output| output.status.success());
    if !is_installed {
        return Err("cargo kani is not installed".to_owned());
    }
    write_crates(root, emitted, &fixed_version).map_err(io)?;
    let output = cargo(&root.join("verify"))
        .arg("kani")
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

/// Writes the emitted crate into `root`, and its harness crate into `root/verify`, under manifests of the checker: what
/// Kani builds is what was read, and nothing else.
///
/// # Errors
/// What the system says if a file cannot be written.
pub fn write_crates(root: &Path, emitted: &Emitted, fixed_version: &str) -> io::Result<()> {
    let package = |name: &str| {
        format!(
            "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\npublish = false\n\
             build = false\n\n[lib]\npath = \"src/lib.rs\"\n\n[lints.rust]\n\
             unexpected_cfgs = {{ level = \"warn\", check-cfg = ['cfg(kani)'] }}\n\n"
        )
    };
    let own = format!(
        "{}[dependencies]\nfixed = {{ version = \"{fixed_version}\", default-features = false }}\n",
        package("generated")
    );
    let harness = format!(
        "{}[package.metadata.kani.unstable]\nfunction-contracts = true\nstubbing = true\n\n\
         [workspace]\n\n[dependencies]\ngenerated = {{ path = \"..\" }}\n",
        package("verify")
    );
    let manifests = [("Cargo.toml", &own), ("verify/Cargo.toml", &harness)];
    let sources = emitted.sources.iter().chain(&emitted.harnesses);
    let files = manifests
        .into_iter()
        .chain(sources.map(|(path, text)| (path.as_str(), text)));
    for (path, text) in files {
        let path = root.join(path);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(path, text)?;
    }
    Ok(())
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
            [
                "proved", "failed", "proved", "not run", "failed", "proved", "not run"
            ]
        );
        assert_eq!((rows[0].0, rows[0].2), ("control-total", 2.25));
        assert!(rows[4].1.why().contains("1 of 2"), "{:?}", rows[4].1);
    }
}
