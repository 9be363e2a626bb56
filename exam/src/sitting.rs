//! An exam over seeds, or over the benches of a folder with their truth.

use std::ops::Range;
use std::path::{Path, PathBuf};

use bench_files::Bench;
use identify::{FitProblem, IdentifyError, Progress};
use parallel::parallel_map;
use plant::EffectId;
use serde::Deserialize;

use crate::answer::{Answer, UnknownEffect};
use crate::draw::draw;
use crate::marking::{MarkError, mark};
use crate::marks::Entry;

/// The reason why a bench of a folder could not be marked.
#[derive(Debug, thiserror::Error)]
pub enum SitError {
    /// A file or folder cannot be read.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    Read(PathBuf, std::io::Error),
    /// A truth.json is not valid; the message ends with line and column.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    Truth(PathBuf, serde_json::Error),
    /// A truth.json names an effect that the library does not have.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    Effect(PathBuf, UnknownEffect),
    /// No bench with a truth.json was found.
    #[error("{}: no folder with a truth.json was found, neither this one nor one below it", .0.display())]
    NoBench(PathBuf),
    /// A bench cannot be read.
    #[error(transparent)]
    Bench(#[from] bench_files::Error),
    /// The logs of a bench cannot be fitted.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    Logs(PathBuf, IdentifyError),
    /// A bench cannot be identified.
    #[error("{file}: {error}", file = .0.display(), error = .1)]
    Mark(PathBuf, MarkError),
}

/// The marked benches of some seeds.
#[derive(Clone, Debug)]
pub struct Sitting {
    /// The benches, in the order of their seeds.
    pub entries: Vec<Entry>,
    /// Seeds without a bench whose hidden term counts.
    pub void: Vec<u64>,
}

/// Draws the bench of a seed and marks the verdict on it. `None` if the seed has no bench whose
/// hidden term counts.
pub fn sit(seed: u64) -> Option<Entry> {
    let bench = draw(seed)?;
    let answer = Answer::of(&bench);
    let paper = mark(
        &bench.problem,
        &answer,
        &bench.suspects,
        &Progress::silent(),
    )
    .ok()?;
    let truth = bench.question.truth();
    Some(Entry {
        sizes: bench.sizes,
        noise: bench.noise.std.to_vec(),
        ..Entry::new(format!("seed {seed}"), truth, answer, &bench.problem, paper)
    })
}

/// Holds the exam for these seeds, several at a time. `done` is called after each one.
pub fn sit_seeds(seeds: Range<u64>, done: &(dyn Fn() + Sync)) -> Sitting {
    let results: Vec<(u64, Option<Entry>)> = parallel_map(seeds, |seed| {
        let entry = sit(seed);
        done();
        (seed, entry)
    });
    let is_void = |(seed, entry): &(u64, Option<Entry>)| entry.is_none().then_some(*seed);
    Sitting {
        void: results.iter().filter_map(is_void).collect(),
        entries: results.into_iter().filter_map(|(_, entry)| entry).collect(),
    }
}

/// The folders with benches in `folder`: the folder itself if it holds a truth.json, otherwise its sub-folders that
/// do, by name.
///
/// # Errors
/// [`SitError::Read`] if it cannot be listed, [`SitError::NoBench`] if there is none.
pub fn benches_in(folder: &Path) -> Result<Vec<PathBuf>, SitError> {
    if folder.join("truth.json").is_file() {
        return Ok(vec![folder.to_owned()]);
    }
    let failed = |error| SitError::Read(folder.to_owned(), error);
    let mut benches = vec![];
    for item in std::fs::read_dir(folder).map_err(failed)? {
        let path = item.map_err(failed)?.path();
        if path.join("truth.json").is_file() {
            benches.push(path);
        }
    }
    if benches.is_empty() {
        return Err(SitError::NoBench(folder.to_owned()));
    }
    benches.sort();
    Ok(benches)
}

/// The content of the truth.json beside the logs of a bench.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TruthFile {
    effects: Vec<String>,
    #[serde(default)]
    parameters: serde_json::Map<String, serde_json::Value>,
}

/// Marks the verdict on the bench of a folder with a truth.json.
///
/// # Errors
/// [`SitError`] if the folder cannot be read or the bench cannot be identified.
pub fn sit_folder(path: &Path) -> Result<Entry, SitError> {
    let file = path.join("truth.json");
    let source =
        std::fs::read_to_string(&file).map_err(|error| SitError::Read(file.clone(), error))?;
    let truth: TruthFile =
        serde_json::from_str(&source).map_err(|error| SitError::Truth(file.clone(), error))?;
    let known =
        |(name, value): (&String, &serde_json::Value)| Some((name.clone(), value.as_f64()?));
    let parameters = truth.parameters.iter().filter_map(known).collect();
    let answer = Answer::from_names(&truth.effects, parameters)
        .map_err(|error| SitError::Effect(file.clone(), error))?;
    let bench = Bench::load(path)?;
    let problem =
        FitProblem::new(&bench).map_err(|error| SitError::Logs(path.to_owned(), error))?;
    let paper = mark(&problem, &answer, EffectId::ALL, &Progress::silent())
        .map_err(|error| SitError::Mark(path.to_owned(), error))?;
    let truth = if truth.effects.is_empty() {
        vec!["nothing".to_owned()]
    } else {
        truth.effects
    };
    Ok(Entry::new(bench.name, truth, answer, &problem, paper))
}
