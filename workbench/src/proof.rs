//! The proof of an emitted crate's claims, from its files alone; and the test whether damage to it is detected.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use checker::certificate::Certificate;
use checker::mutate::{Mutant, MutantVerdict, Summary, chosen, judged, notices, summary};
use checker::prove::Emitted;
use checker::{ClaimOutcome, ClaimResult, ProveError};
use identify::Progress;
use parallel::parallel_map;
use serde::Serialize;

use crate::bench_hardware::Preset;
use crate::control_design::ControlDesign;
use crate::controller::{ControllerOptions, GeneratedController};
use crate::error::Error;
use crate::output_file::OutputFile;

pub use checker::ProofSettings;
pub use checker::certificate::claims::{CLAIMS, ClaimStatement};
pub use checker::prove::ProofVerdict;

/// The results for all claims of a certificate, each by every engine that can decide it.
#[derive(Clone, Debug, Serialize)]
pub struct Proof {
    /// The emitted crate; empty for one in memory.
    pub folder: PathBuf,
    /// Seed of the random runs.
    pub seed: u64,
    /// The claims.
    pub claims: Vec<ClaimResult>,
}

/// Decides every claim about the emitted crate in a folder. No other part of the project has to
/// exist, and the generator is not trusted. If the user's `model` is given, the crate is compared with
/// it, and sensors and drive with the generator's output for it. Takes seconds.
///
/// # Errors
/// [`Error::Prove`] if the folder does not contain an emitted crate; a claim that does not hold is not an error but a
/// failed claim. [`Error::Cancelled`] if the work was cancelled before it began; any error in reading
/// the model.
pub fn prove(
    folder: &Path,
    model: Option<&Path>,
    settings: &ProofSettings,
    progress: &Progress,
) -> Result<Proof, Error> {
    progress.check()?;
    (progress.say)("checking the claims of the certificate");
    let say = |what: &str| (progress.say)(what);
    let mut claims = checker::prove::prove(folder, model, settings, &say)?;
    if let Some(model) = model {
        let row = generated_again(folder, model)?;
        let after = claims.iter().rposition(|claim| claim.id == row.id);
        claims.insert(after.map_or(0, |after| after + 1), row);
    }
    Ok(Proof {
        folder: folder.to_path_buf(),
        seed: settings.seed,
        claims,
    })
}

/// Compares the folder with the generator's output for the model, with the preset that the crate says
/// it was generated with.
fn generated_again(folder: &Path, model: &Path) -> Result<ClaimResult, Error> {
    let start = Instant::now();
    let certificate = Certificate::read(folder).map_err(ProveError::from)?;
    // A crate without a plain name has failed another claim already.
    let name = Emitted::read(folder)
        .map_err(ProveError::from)?
        .name()
        .and_then(|name| name.parse().ok())
        .unwrap_or_default();
    let options = ControllerOptions {
        preset: (!certificate.assumed.is_empty()).then_some(Preset::ThesisBench),
        name,
        has_monitor: certificate.monitor.is_some(),
    };
    let outcome = match ControlDesign::read(model)?.generate_with(&options) {
        Err(error) => ClaimOutcome::Failed(error.to_string()),
        Ok(controller) => match controller.differing(folder)?.first() {
            None => ClaimOutcome::Proved("every byte of every file".to_owned()),
            Some(path) => ClaimOutcome::Failed(format!(
                "{} differs from the generator's output for {}",
                path.display(),
                model.display()
            )),
        },
    };
    let seconds = start.elapsed().as_secs_f64();
    Ok(ClaimResult::new(
        "model-matches",
        "the generator",
        outcome,
        seconds,
    ))
}

impl GeneratedController {
    /// Decides every claim about a controller that has not been written, like [`prove`]. The controller is compared with
    /// the model from which it was emitted, but not with the generator's output, since it is that output. Kani needs a
    /// folder and is not run.
    ///
    /// # Errors
    /// As for [`prove`].
    pub fn prove(&self, settings: &ProofSettings, progress: &Progress) -> Result<Proof, Error> {
        self.prove_telling(settings, progress, &|_| ())
    }

    /// Decides every claim like [`GeneratedController::prove`], and calls `tell` with each row as soon as it is
    /// decided.
    ///
    /// # Errors
    /// As for [`prove`].
    pub fn prove_telling(
        &self,
        settings: &ProofSettings,
        progress: &Progress,
        tell: &dyn Fn(&ClaimResult),
    ) -> Result<Proof, Error> {
        progress.check()?;
        (progress.say)("checking the claims of the certificate");
        let text = |name: &str| {
            let mut files = self.files();
            let found = files.find(|(path, _)| *path == name);
            found.map_or(String::new(), |(_, text)| text.to_owned())
        };
        let emitted = Emitted {
            sources: self
                .sources()
                .map(|(path, text)| (path.to_owned(), text.to_owned()))
                .collect(),
            cargo: text("Cargo.toml"),
            certificate: text("certificate.json"),
            harnesses: self
                .files()
                .filter(|(path, _)| path.starts_with("verify/") && path.ends_with(".rs"))
                .map(|(path, text)| (path.to_owned(), text.to_owned()))
                .collect(),
            harness_cargo: Some(text("verify/Cargo.toml")).filter(|text| !text.is_empty()),
            strays: Vec::new(),
        };
        // Kani needs minutes, and files on the disk.
        let settings = &ProofSettings {
            kani: false,
            ..*settings
        };
        let certificate = Certificate::parse(&emitted.certificate).map_err(ProveError::from)?;
        Ok(Proof {
            folder: PathBuf::new(),
            seed: settings.seed,
            claims: checker::prove::settle_telling(
                &emitted,
                &certificate,
                Some(self.model_text.as_str()).filter(|text| !text.is_empty()),
                settings,
                &|what| {
                    (progress.say)(what);
                },
                tell,
            ),
        })
    }
}

impl Proof {
    /// The verdict over all claims.
    pub fn verdict(&self) -> ProofVerdict {
        checker::prove::verdict(&self.claims)
    }

    /// Whether no claim fails.
    pub fn passed(&self) -> bool {
        checker::prove::passed(&self.claims)
    }
}

/// The result of damaging an emitted crate in many small ways.
#[derive(Clone, Debug, Serialize)]
pub struct MutationReport {
    /// The emitted crate; it is not changed.
    pub folder: PathBuf,
    /// The numbers of mutants that were detected, by engine.
    pub summary: Summary,
    /// The verdict on each mutant.
    pub verdicts: Vec<MutantVerdict>,
}

/// Number of mutants between two checks for cancellation.
const MUTANTS_AT_A_TIME: usize = 64;

/// Makes every mutant of an emitted crate, each with one small damage (at most `most` per file if it is given), and
/// reports which engine of the proof detects each.
///
/// # Errors
/// [`Error::Prove`] if the folder does not contain an emitted crate; [`Error::FailsUndamaged`];
/// [`Error::Cancelled`].
pub fn mutate(
    folder: &Path,
    most: Option<usize>,
    progress: &Progress,
) -> Result<MutationReport, Error> {
    let emitted = Emitted::read(folder).map_err(ProveError::from)?;
    let certificate = Certificate::parse(&emitted.certificate).map_err(ProveError::from)?;
    if let Some(notice) = notices(&emitted, &certificate).first() {
        return Err(Error::FailsUndamaged {
            folder: folder.to_path_buf(),
            claim: notice.claim.clone(),
        });
    }
    let mutants: Vec<Mutant> = chosen(&emitted, most);
    let (count, done) = (mutants.len(), AtomicUsize::new(0));
    let mut verdicts: Vec<MutantVerdict> = Vec::with_capacity(count);
    let mut waiting = mutants.into_iter();
    loop {
        let some: Vec<Mutant> = waiting.by_ref().take(MUTANTS_AT_A_TIME).collect();
        if some.is_empty() {
            break;
        }
        progress.check()?;
        (progress.say)(&format!(
            "{} of {count} mutants",
            done.load(Ordering::Relaxed)
        ));
        verdicts.extend(parallel_map(some, |mutant| {
            let verdict = judged(&emitted, &certificate, mutant);
            done.fetch_add(1, Ordering::Relaxed);
            verdict
        }));
    }
    Ok(MutationReport {
        folder: folder.to_path_buf(),
        summary: summary(&verdicts),
        verdicts,
    })
}

impl MutationReport {
    /// One line for each mutant.
    ///
    /// # Errors
    /// [`Error::Table`].
    pub fn table(&self) -> Result<OutputFile, Error> {
        let head = [
            "file", "line", "column", "kind", "before", "after", "fate", "claim", "engine",
            "reason",
        ];
        let rows = self.verdicts.iter().map(|verdict| {
            let mutant = &verdict.mutant;
            let (claim, engine) = verdict
                .noticed
                .first()
                .map_or(("", ""), |notice| (notice.claim.as_str(), notice.engine));
            [
                mutant.file.as_str(),
                &mutant.line.to_string(),
                &mutant.column.to_string(),
                mutant.kind,
                &mutant.before,
                &mutant.after,
                verdict.fate.as_str(),
                claim,
                engine,
                &verdict.reason,
            ]
            .map(str::to_owned)
        });
        OutputFile::of_records("mutants", &head, rows)
    }
}
