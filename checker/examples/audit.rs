//! The audit of the texts that emitted crates are made of: `cargo run --release -p checker --example
//! audit [DIR…]`, minutes. It writes `checker/audited.json`. With `--digests` it prints digests only.
//!
//! Every engine runs on the crates in the folders (by default the committed one) whose texts are new, with many more cases
//! than `flywheel prove` takes; the functions of one word are run, compiled, on every input. If
//! nothing fails, the digests of the texts are written down. Texts that were audited before and are
//! not in these folders are kept.

use std::error::Error;
use std::path::{Path, PathBuf};

use checker::audit::{AuditedText, audited, digest};
use checker::certificate::reader::Certificate;
use checker::claims::filter_exact::every_input::{ONE_WORD, OneWord};
use checker::claims::texts_audited;
use checker::prove::{Emitted, ProofVerdict, settle_saying, verdict};
use checker::{Module, ProofSettings};
use generated::{arc_tangent, pivot_angle, root};

/// Random runs of each kind.
const CASES: usize = 200_000;

fn main() -> Result<(), Box<dyn Error>> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let committed = home.join("../generated");
    let mut folders: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    if folders == [PathBuf::from("--digests")] {
        for (path, text) in &Emitted::read(&committed)?.sources {
            println!("{path} {}", digest::of_file(path, text).unwrap_or_default());
        }
        return Ok(());
    }
    if folders.is_empty() {
        folders.push(committed.clone());
    }
    let compiled = Emitted::read(&committed)?;
    let mut texts: Vec<AuditedText> = audited().to_vec();
    for folder in &folders {
        eprintln!("{}", folder.display());
        let emitted = Emitted::read(folder)?;
        let module = emitted.module()?;
        // Texts of which an audit is on record are not run again: such a folder brings harnesses alone.
        if texts_audited::texts(&emitted).is_err() {
            run_engines(&emitted)?;
        }
        for (path, text) in &emitted.sources {
            let digest = digest::of_file(path, text).ok_or("no tokens")?;
            if texts
                .iter()
                .any(|known| known.file == *path && known.digest == digest)
            {
                continue;
            }
            // Only what is compiled into this program is run on every input.
            let is_compiled = compiled.sources.iter().any(|(own, other)| {
                own == path && digest::of_file(own, other).as_ref() == Some(&digest)
            });
            let mut every_input = Vec::new();
            for function in ONE_WORD.iter().filter(|function| function.file == path) {
                if is_compiled {
                    eprintln!("  {path}: {} on every input", function.name);
                    run_all(function)?;
                    every_input.push(function.name.to_owned());
                }
            }
            texts.push(AuditedText {
                file: path.clone(),
                digest,
                in_cases: others(&module, path, &every_input),
                every_input,
                cases: CASES / 10,
            });
        }
    }
    for folder in &folders {
        // No engine runs a harness but Kani; its audit is that somebody read it.
        for (path, text) in Emitted::read(folder)?.harnesses {
            let digest = digest::of_file(&path, &text).ok_or("no tokens")?;
            let is_new = |known: &AuditedText| known.file != path || known.digest != digest;
            if texts.iter().all(is_new) {
                texts.push(AuditedText {
                    file: path,
                    digest,
                    every_input: Vec::new(),
                    in_cases: Vec::new(),
                    cases: 0,
                });
            }
        }
    }
    texts.sort_by(|a, b| (&a.file, &a.digest).cmp(&(&b.file, &b.digest)));
    let path = home.join("audited.json");
    std::fs::write(&path, serde_json::to_string_pretty(&texts)? + "\n")?;
    eprintln!("{} texts in {}", texts.len(), path.display());
    Ok(())
}

/// Every engine but Kani; nothing may fail.
fn run_engines(emitted: &Emitted) -> Result<(), Box<dyn Error>> {
    let settings = ProofSettings {
        cases: CASES,
        audited_texts: false,
        kani: false,
        ..ProofSettings::default()
    };
    let certificate = Certificate::parse(&emitted.certificate)?;
    let rows = settle_saying(emitted, &certificate, None, &settings, &|what| {
        eprintln!("  {what}")
    });
    for row in &rows {
        eprintln!(
            "  {}, {}: {} {}",
            row.id,
            row.engine,
            row.outcome.word(),
            row.outcome.detail()
        );
    }
    match verdict(&rows) {
        ProofVerdict::Fails(claims) => Err(format!("fails: {}", claims.join(", ")).into()),
        ProofVerdict::Holds | ProofVerdict::Unsettled(_) => Ok(()),
    }
}

/// The compiled function on every input against the checker's own statement of it.
fn run_all(function: &OneWord) -> Result<(), Box<dyn Error>> {
    let found: fn(i32) -> i32 = match function.name {
        "seed" => root::seed,
        "inverse_root_q30" => root::inverse_root_q30,
        "coarse_inverse_root_q30" => root::coarse_inverse_root_q30,
        "inverse_length" => root::inverse_length,
        "coarse_inverse_length" => root::coarse_inverse_length,
        "reciprocal_q29" => arc_tangent::reciprocal_q29,
        "arc_tangent_q31" => arc_tangent::arc_tangent_q31,
        "wrapped" => pivot_angle::wrapped,
        other => return Err(format!("{other} is not compiled into this program").into()),
    };
    let (low, high) = function.domain;
    let ends = [function.clamped.0, function.clamped.1].map(|end| (function.wanted)(end.into()));
    let differs = |word: i32| {
        let wanted = if word < function.clamped.0 {
            ends[0]
        } else if word > function.clamped.1 {
            ends[1]
        } else {
            (function.wanted)(word.into())
        };
        i128::from(found(word)) != wanted
    };
    let middle = i32::try_from((i64::from(low) + i64::from(high)) / 2)?;
    let first = std::thread::scope(|scope| {
        let lower = scope.spawn(|| (low..=middle).find(|word| differs(*word)));
        let upper = (middle + 1..=high).find(|word| differs(*word));
        lower.join().map(|lower| lower.or(upper))
    });
    match first.map_err(|_| "a thread panicked")? {
        Some(word) => Err(format!("{} of {word} is {}", function.name, found(word)).into()),
        None => Ok(()),
    }
}

/// The functions of a file that are not among `every_input`.
fn others(module: &Module, path: &str, every_input: &[String]) -> Vec<String> {
    let declarations = module.declarations();
    let own = declarations.functions.iter();
    own.filter(|function| *declarations.files[function.module].path == *path)
        .map(|function| function.name.clone())
        .filter(|name| !every_input.contains(name))
        .collect()
}
