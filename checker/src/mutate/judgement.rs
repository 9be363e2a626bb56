//! Which engine detects a mutant, and what is known about those that none detects.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::certificate::reader::Certificate;
use crate::claims::outcome::ClaimOutcome;
use crate::language::emitted::Emitted;
use crate::mutate::comparison::{Likeness, compared};
use crate::mutate::mutants::{Mutant, applied};
use crate::prove::settings::ProofSettings;
use crate::prove::settle::settle;

/// What came of a mutant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MutantVerdict {
    /// The mutant.
    pub mutant: Mutant,
    /// Claims that fail and the engines that noticed; empty for a survivor.
    pub noticed: Vec<Notice>,
    /// What is known of it.
    pub fate: Fate,
    /// What is known of a survivor, as a sentence; empty for others, and where nothing is known.
    pub reason: String,
}

/// What is known of a mutant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// An engine noticed it.
    Caught,
    /// It survives, and z3 proves that it changes nothing.
    Same,
    /// It survives, and no difference was found in a random sample.
    NoDifferenceFound,
    /// It survives, and a difference was found or nothing could be compared: to be looked at.
    Unexplained,
}

impl Fate {
    /// As in JSON.
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
    /// What settled it.
    pub engine: &'static str,
}

/// What runs on a mutant: no engine that some users do not have, none that takes minutes.
const SETTINGS: ProofSettings = ProofSettings {
    cases: 3_000,
    seed: 1,
    // A digest notices every mutant; what is measured here is what the engines would notice in a text
    // that is to be audited.
    audited_texts: false,
    compiled: false,
    smt: false,
    kani: false,
    // It reads nothing of the source but the law, and that is compared before.
    closed_loop: false,
    python: false,
    filter_ranges: false,
    filter_length: false,
};

/// The claims that fail: the quick engines first, the slower only if these notice nothing.
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
    let noticed = notices(&damaged, certificate);
    let (fate, reason) = if noticed.is_empty() {
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

/// Mutants, caught and not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Summary {
    /// How many there were.
    pub mutants: usize,
    /// How many were caught.
    pub caught: usize,
    /// How many survived and are proved to change nothing.
    pub same: usize,
    /// How many survived without a difference in a random sample.
    pub no_difference_found: usize,
    /// By the engine that noticed first.
    pub by_engine: BTreeMap<&'static str, usize>,
    /// Caught and all, by kind.
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
