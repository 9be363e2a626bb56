//! What an emitted crate promises, checked from its files alone; and whether damage would be noticed.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use checker::certificate::Certificate;
use checker::mutate::{Mutant, MutantVerdict, Summary, chosen, judged, notices, summary};
use checker::prove::Emitted;
use checker::{ClaimOutcome, ClaimResult, ProveError};
use identify::Progress;
use rayon::prelude::*;
use serde::Serialize;

use crate::bench_hardware::Preset;
use crate::control_design::ControlDesign;
use crate::controller::GeneratedController;
use crate::error::Error;
use crate::output_file::OutputFile;

pub use checker::ProofSettings;
pub use checker::certificate::claims::{CLAIMS, ClaimStatement};
pub use checker::prove::ProofVerdict;

/// Every claim of a certificate, each by every engine that can settle it.
#[derive(Clone, Debug, Serialize)]
pub struct Proof {
    /// The emitted crate; empty for one in memory.
    pub folder: PathBuf,
    /// Seed of the random runs.
    pub seed: u64,
    /// The claims.
    pub claims: Vec<ClaimResult>,
}

/// Settles every claim about the emitted crate in a folder: nothing else of the project has to be
/// there, and the generator is not trusted. Where the user's `model` is given, the crate is held against
/// it, and sensors and drive against what the generator makes of it. Takes seconds.
///
/// # Errors
/// [`Error::Prove`] where the folder holds no emitted crate; what does not hold is no error but a
/// failed claim. [`Error::Cancelled`] if the work was called off before it began; any error of reading
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

/// Whether the folder holds what the generator makes of the model, with the preset that the crate says
/// it was generated with.
fn generated_again(folder: &Path, model: &Path) -> Result<ClaimResult, Error> {
    let start = Instant::now();
    let certificate = Certificate::read(folder).map_err(ProveError::from)?;
    let preset = (!certificate.assumed.is_empty()).then_some(Preset::ThesisBench);
    let outcome = match ControlDesign::read(model)?.generate(preset) {
        Err(error) => ClaimOutcome::Failed(error.to_string()),
        Ok(controller) => match controller.differing(folder)?.first() {
            None => ClaimOutcome::Proved("every byte of every file".to_owned()),
            Some(path) => ClaimOutcome::Failed(format!(
                "{} is not what the generator makes of {}",
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
    /// As [`prove`], of a controller that was not written yet. Kani, which needs a folder, does not
    /// run.
    ///
    /// # Errors
    /// As for [`prove`].
    pub fn prove(&self, settings: &ProofSettings, progress: &Progress) -> Result<Proof, Error> {
        self.prove_telling(settings, progress, &|_| ())
    }

    /// As [`GeneratedController::prove`]; `tell` is told every row as soon as it is settled.
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
                .files()
                .filter(|(path, _)| path.ends_with(".rs"))
                .map(|(path, text)| (path.to_owned(), text.to_owned()))
                .collect(),
            cargo: text("Cargo.toml"),
            certificate: text("certificate.json"),
            strays: Vec::new(),
        };
        let certificate = Certificate::parse(&emitted.certificate).map_err(ProveError::from)?;
        Ok(Proof {
            folder: PathBuf::new(),
            seed: settings.seed,
            claims: checker::prove::settle_telling(
                &emitted,
                &certificate,
                None,
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
    /// What all claims together say.
    pub fn verdict(&self) -> ProofVerdict {
        checker::prove::verdict(&self.claims)
    }

    /// Whether no claim fails.
    pub fn passed(&self) -> bool {
        checker::prove::passed(&self.claims)
    }
}

/// What becomes of an emitted crate that is damaged in many small ways.
#[derive(Clone, Debug, Serialize)]
pub struct MutationReport {
    /// The emitted crate; nothing in it is changed.
    pub folder: PathBuf,
    /// How many were caught, and by what.
    pub summary: Summary,
    /// Mutant by mutant.
    pub verdicts: Vec<MutantVerdict>,
}

/// Mutants that are judged between two looks at the caller's wish to stop.
const MUTANTS_AT_A_TIME: usize = 64;

/// Damages an emitted crate in every small way, or in at most `most` of each file, and says which
/// engine of the proof notices.
///
/// # Errors
/// [`Error::Prove`] where the folder holds no emitted crate; [`Error::FailsUndamaged`];
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
        verdicts.par_extend(some.into_par_iter().map(|mutant| {
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
