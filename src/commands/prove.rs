//! `flywheel prove DIR`

use std::path::PathBuf;

use workbench::{ProofSettings, prove};

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;
use crate::report::table::{Align, Table};

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of an emitted crate: its sources and its certificate.json
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Number of random runs of each kind
    #[arg(long, value_name = "N", default_value_t = ProofSettings::default().cases)]
    pub cases: usize,
    /// Seed of the random runs
    #[arg(long, value_name = "SEED", default_value_t = ProofSettings::default().seed)]
    pub seed: u64,
    /// Leave out Kani even where it is installed (it takes minutes)
    #[arg(long)]
    pub without_kani: bool,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command: exit code 1 where a claim fails.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let settings = ProofSettings {
        cases: arguments.cases,
        seed: arguments.seed,
        kani: !arguments.without_kani,
        ..ProofSettings::default()
    };
    let proof = with_progress(|progress| prove(&arguments.folder, &settings, progress))?;
    let all_hold = proof.passed();
    let mut table = Table::new(&[
        ("claim", Align::Left),
        ("engine", Align::Left),
        ("result", Align::Left),
        ("seconds", Align::Right),
        ("detail", Align::Left),
    ]);
    let mut statements = String::new();
    let mut last = "";
    for claim in &proof.claims {
        table.row([
            claim.id.clone(),
            claim.engine.to_owned(),
            claim.outcome.word().to_owned(),
            format!("{:.2}", claim.seconds),
            claim.outcome.detail(),
        ]);
        if claim.id != last {
            last = &claim.id;
            statements.push_str(&format!("  {}: {}\n", claim.id, claim.statement));
            statements.push_str(&format!("    for {}\n", claim.domain));
            if !claim.assumptions.is_empty() {
                statements.push_str(&format!("    assuming {}\n", claim.assumptions));
            }
        }
    }
    let verdict = if all_hold {
        "No claim fails."
    } else {
        "At least one claim FAILS."
    };
    let text = format!(
        "{}: what the emitted files promise, checked from these files alone (seed {})\n{}\n{}\n{verdict}\n",
        arguments.folder.display(),
        arguments.seed,
        statements,
        table.text(),
    );
    let report = Report::new(text, &proof)?;
    Ok(if all_hold { report } else { report.failed() })
}
