//! Which engine detects a mutant, and a judgement of the mutants that no engine detects.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::certificate::reader::Certificate;
use crate::claims::compiled_agrees;
use crate::claims::outcome::{COMPILED, ClaimOutcome};
use crate::language::emitted::Emitted;
use crate::mutate::comparison::{Likeness, compared, same_everywhere};
use crate::mutate::mutants::{Mutant, applied};
use crate::prove::settings::ProofSettings;
use crate::prove::settle::settle;

/// The verdict on a mutant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MutantVerdict {
    /// The mutant.
    pub mutant: Mutant,
    /// Claims that fail, and the engines that detected it; empty for a survivor.
    pub noticed: Vec<Notice>,
    /// The classification.
    pub fate: Fate,
    /// The reason for the classification of a survivor, as a sentence; otherwise empty.
    pub reason: String,
}

/// The classification of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// An engine detected it.
    Caught,
    /// It survives, and z3 or the rules of the language prove that it changes nothing.
    Same,
    /// It survives, and no difference was found in a random sample.
    NoDifferenceFound,
    /// It survives, and a difference was found or nothing could be compared: it must be examined.
    Unexplained,
}

impl Fate {
    /// The name in JSON.
    pub fn as_str(self) -> &'static str {
        match self {
            Fate::Caught => "caught",
            Fate::Same => "same",
            Fate::NoDifferenceFound => "no-difference-found",
            Fate::Unexplained => "unexplained",
        }
    }
}

/// A claim that fails.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Notice {
    /// Identifier of the claim.
    pub claim: String,
    /// The engine.
    pub engine: &'static str,
}

/// The settings for a mutant: only engines that every user has, and none that takes minutes.
const SETTINGS: ProofSettings = ProofSettings {
    cases: 3_000,
    seed: 1,
    // A digest detects every mutant. The purpose here is to measure what the other engines would detect in a text
    // that is not audited yet.
    audited_texts: false,
    compiled: false,
    smt: false,
    kani: false,
    // This engine reads only the law from the source, and the law has been compared before.
    closed_loop: false,
    python: false,
    filter_ranges: false,
    filter_length: false,
};

/// Random words for each function of a compiled mutant.
const COMPILED_CASES: usize = 100;

/// The claims that fail: the quick engines run first, the slower ones only if these detect nothing.
pub fn notices(emitted: &Emitted, certificate: &Certificate) -> Vec<Notice> {
    let slower = ProofSettings {
        cases: 1,
        filter_ranges: true,
        ..SETTINGS
    };
    let slowest = ProofSettings {
        filter_length: true,
        ..slower
    };
    for settings in [SETTINGS, slower, slowest] {
        let found = failures(emitted, certificate, &settings);
        if !found.is_empty() {
            return found;
        }
    }
    Vec::new()
}

fn failures(emitted: &Emitted, certificate: &Certificate, settings: &ProofSettings) -> Vec<Notice> {
    settle(emitted, certificate, settings)
        .into_iter()
        .filter(|result| matches!(result.outcome, ClaimOutcome::Failed(_)))
        .map(|result| Notice {
            claim: result.id,
            engine: result.engine,
        })
        .collect()
}

/// The damaged crate, compiled, beside the reader of the undamaged one.
fn compiled(emitted: &Emitted, damaged: &Emitted) -> Option<ClaimOutcome> {
    let module = emitted.module().ok()?;
    let outcome = compiled_agrees::by_running(damaged, &module, COMPILED_CASES, SETTINGS.seed);
    Some(outcome)
}

/// Runs the engines on one mutant.
pub fn judged(emitted: &Emitted, certificate: &Certificate, mutant: Mutant) -> MutantVerdict {
    let mut damaged = emitted.clone();
    if mutant.file == "Cargo.toml" {
        damaged.cargo = applied(&emitted.cargo, &mutant);
    }
    for (path, text) in &mut damaged.sources {
        if *path == mutant.file {
            *text = applied(text, &mutant);
        }
    }
    let mut noticed = notices(&damaged, certificate);
    let mut is_the_same = None;
    // The reader takes no type for granted, and none that rustc would refuse; what it reads as the same words may be
    // refused, or be others, when it is compiled. A build takes seconds, so it comes last.
    if noticed.is_empty() && mutant.kind == "type" {
        match compiled(emitted, &damaged) {
            Some(ClaimOutcome::Failed(_)) => noticed.push(Notice {
                claim: "compiled-agrees".to_owned(),
                engine: COMPILED,
            }),
            Some(ClaimOutcome::Tested(runs, _)) => is_the_same = Some(runs),
            _ => {}
        }
    }
    let (fate, reason) = if let Some(runs) = is_the_same {
        match same_everywhere(emitted, &damaged) {
            Some(why) => (Fate::Same, why),
            None => {
                let why = format!("compiled, it computes the undamaged words in {runs} runs");
                (Fate::NoDifferenceFound, why)
            }
        }
    } else if noticed.is_empty() {
        match compared(emitted, &damaged, &mutant) {
            Some((Likeness::Proved, why)) => (Fate::Same, why),
            Some((Likeness::Sampled, why)) => (Fate::NoDifferenceFound, why),
            None => (Fate::Unexplained, String::new()),
        }
    } else {
        (Fate::Caught, String::new())
    };
    MutantVerdict {
        mutant,
        noticed,
        fate,
        reason,
    }
}

/// Numbers of mutants, detected and undetected.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// Number of mutants.
    pub mutants: usize,
    /// Number of detected mutants.
    pub caught: usize,
    /// Number of survivors that are proved to change nothing.
    pub same: usize,
    /// Number of survivors without a difference in a random sample.
    pub no_difference_found: usize,
    /// By the engine that detected the mutant first.
    pub by_engine: BTreeMap<&'static str, usize>,
    /// Detected and all mutants, by kind.
    pub by_kind: BTreeMap<&'static str, (usize, usize)>,
}

/// Adds up verdicts.
pub fn summary(verdicts: &[MutantVerdict]) -> Summary {
    let mut summary = Summary {
        mutants: verdicts.len(),
        caught: 0,
        same: 0,
        no_difference_found: 0,
        by_engine: BTreeMap::new(),
        by_kind: BTreeMap::new(),
    };
    for verdict in verdicts {
        let (caught, all) = summary.by_kind.entry(verdict.mutant.kind).or_default();
        *all += 1;
        if let Some(first) = verdict.noticed.first() {
            *caught += 1;
            summary.caught += 1;
            *summary.by_engine.entry(first.engine).or_default() += 1;
        }
        match verdict.fate {
            Fate::Same => summary.same += 1,
            Fate::NoDifferenceFound => summary.no_difference_found += 1,
            Fate::Caught | Fate::Unexplained => {}
        }
    }
    summary
}
