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
    Ok(match ending(&verdict, arguments.allow_not_run) {
        Ending::Failed => report.failed(),
        Ending::Unsettled => report.unsettled(),
        Ending::Good => report,
    })
}

/// The outcome of the command, with its exit code.
#[derive(Debug, PartialEq, Eq)]
enum Ending {
    /// Exit code 0.
    Good,
    /// Exit code 1.
    Failed,
    /// Exit code 3.
    Unsettled,
}

fn ending(verdict: &ProofVerdict, allow_not_run: bool) -> Ending {
    match verdict {
        ProofVerdict::Fails(_) => Ending::Failed,
        ProofVerdict::Unsettled(_) if !allow_not_run => Ending::Unsettled,
        ProofVerdict::Holds | ProofVerdict::Unsettled(_) => Ending::Good,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_run_may_be_allowed_and_what_failed_may_not() {
        let some = || vec!["closed-loop-for-all-time".to_owned()];
        let unsettled = ProofVerdict::Unsettled(some());
        assert_eq!(ending(&unsettled, false), Ending::Unsettled);
        assert_eq!(ending(&unsettled, true), Ending::Good);
        assert_eq!(ending(&ProofVerdict::Fails(some()), true), Ending::Failed);
        assert_eq!(ending(&ProofVerdict::Holds, false), Ending::Good);
    }
}
