//! `flywheel prove DIR`

use std::path::PathBuf;

use workbench::{ProofSettings, ProofVerdict, prove};

use crate::arguments::JsonOutput;
use crate::failure::Failure;
use crate::progress::with_progress;
use crate::report::Report;
use crate::views;

/// Arguments of the command.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of an emitted crate: its sources and its certificate.json
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The user's model.toml, whose numbers the crate must have
    #[arg(long, value_name = "MODEL")]
    pub model: Option<PathBuf>,
    /// Number of random runs of each kind
    #[arg(long, value_name = "N", default_value_t = ProofSettings::default().cases)]
    pub cases: usize,
    /// Seed of the random runs
    #[arg(long, value_name = "SEED", default_value_t = ProofSettings::default().seed)]
    pub seed: u64,
    /// Leave out Kani even where it is installed (it takes minutes)
    #[arg(long)]
    pub without_kani: bool,
    /// End with exit code 0 even if no engine settled some claim
    #[arg(long)]
    pub allow_not_run: bool,
    #[command(flatten)]
    pub output: JsonOutput,
}

/// Runs the command: exit code 1 where a claim fails, 3 where none fails and some is unsettled.
pub fn run(arguments: &Arguments) -> Result<Report, Failure> {
    let settings = ProofSettings {
        cases: arguments.cases,
        seed: arguments.seed,
        kani: !arguments.without_kani,
        ..ProofSettings::default()
    };
    let proof = with_progress(|progress| {
        let model = arguments.model.as_deref();
        prove(&arguments.folder, model, &settings, progress)
    })?;
    let verdict = proof.verdict();
    let report = Report::new(views::proof::text(&proof, &verdict), &proof)?;
    Ok(match verdict {
        ProofVerdict::Fails(_) => report.failed(),
        ProofVerdict::Unsettled(_) if !arguments.allow_not_run => report.unsettled(),
        ProofVerdict::Holds | ProofVerdict::Unsettled(_) => report,
    })
}
