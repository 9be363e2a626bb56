//! The rows of results.

use std::time::Instant;

use serde::Serialize;

use crate::certificate::claims::{CLAIMS, ClaimStatement, claim};
use crate::claims::outcome::ClaimOutcome;

/// The result of one engine for one claim.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimResult {
    /// Identifier.
    pub id: String,
    /// One sentence.
    pub statement: String,
    /// The engine.
    pub engine: &'static str,
    /// The inputs for which the claim holds.
    pub domain: String,
    /// The assumptions; empty if there are none.
    pub assumptions: String,
    /// The outcome.
    pub outcome: ClaimOutcome,
    /// Time that it took (s).
    pub seconds: f64,
}

/// The row of a [`ClaimResult`] in JSON.
#[derive(Serialize)]
struct Row<'a> {
    id: &'a str,
    statement: &'a str,
    engine: &'a str,
    domain: &'a str,
    assumptions: &'a str,
    result: &'a str,
    why: &'a str,
    cases: Option<usize>,
    seconds: f64,
}

impl Serialize for ClaimResult {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Row {
            id: &self.id,
            statement: &self.statement,
            engine: self.engine,
            domain: &self.domain,
            assumptions: &self.assumptions,
            result: self.outcome.word(),
            why: self.outcome.why(),
            cases: self.outcome.cases(),
            seconds: self.seconds,
        }
        .serialize(serializer)
    }
}

/// The verdict over all rows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProofVerdict {
    /// Every claim that applies to this module is proved or tested by some engine.
    Holds,
    /// No row failed, but no engine decided these claims.
    Unsettled(Vec<String>),
    /// These claims have a row that failed.
    Fails(Vec<String>),
}

/// The verdict over all rows.
pub fn verdict(results: &[ClaimResult]) -> ProofVerdict {
    let with = |is_wanted: &dyn Fn(&ClaimOutcome) -> bool| -> Vec<String> {
        let mut ids: Vec<String> = Vec::new();
        for result in results.iter().filter(|result| is_wanted(&result.outcome)) {
            if !ids.contains(&result.id) {
                ids.push(result.id.clone());
            }
        }
        ids
    };
    let failed = with(&|outcome| matches!(outcome, ClaimOutcome::Failed(_)));
    if !failed.is_empty() {
        return ProofVerdict::Fails(failed);
    }
    let settled = with(&|outcome| !matches!(outcome, ClaimOutcome::NotRun(_)));
    let unsettled: Vec<String> = with(&|_| true)
        .into_iter()
        .filter(|id| !settled.contains(id))
        .collect();
    if unsettled.is_empty() {
        ProofVerdict::Holds
    } else {
        ProofVerdict::Unsettled(unsettled)
    }
}

/// Whether no claim failed.
pub fn passed(results: &[ClaimResult]) -> bool {
    !matches!(verdict(results), ProofVerdict::Fails(_))
}

/// The rows in the order of [`CLAIMS`], with one more for each claim that has none; `why` is the reason why it was
/// not decided.
pub(crate) fn complete(rows: Vec<ClaimResult>, why: &str) -> Vec<ClaimResult> {
    let mut table = Table(rows, None);
    for claim in CLAIMS {
        if table.0.iter().all(|row| row.id != claim.id) {
            let outcome = ClaimOutcome::NotRun(why.to_owned());
            table.row(claim.id, claim.engine, outcome, 0.0);
        }
    }
    let place = |row: &ClaimResult| CLAIMS.iter().position(|claim| claim.id == row.id);
    table
        .0
        .sort_by_key(|row| place(row).unwrap_or(CLAIMS.len()));
    table.0
}

impl ClaimResult {
    /// A row of the claim called `id`.
    pub fn new(id: &str, engine: &'static str, outcome: ClaimOutcome, seconds: f64) -> ClaimResult {
        let known: Option<&ClaimStatement> = claim(id);
        ClaimResult {
            id: id.to_owned(),
            statement: known.map_or("", |claim| claim.statement).to_owned(),
            engine,
            domain: known.map_or("", |claim| claim.domain).to_owned(),
            assumptions: known.map_or("", |claim| claim.assumptions).to_owned(),
            outcome,
            seconds,
        }
    }
}

/// Collects rows, and tells of each as it is settled.
pub(crate) struct Table<'a>(
    pub(crate) Vec<ClaimResult>,
    pub(crate) Option<&'a dyn Fn(&ClaimResult)>,
);

impl Table<'_> {
    pub(crate) fn add(
        &mut self,
        id: &str,
        engine: &'static str,
        settle: impl FnOnce() -> ClaimOutcome,
    ) {
        let start = Instant::now();
        // A source that was read may still have other functions than an emitted crate. Where a claim takes one for granted,
        // that is a failed claim, not the end of the program.
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(settle))
            .unwrap_or_else(|_| {
                ClaimOutcome::Failed(
                    "the functions of the source are not those of an emitted crate: the check broke off"
                        .to_owned(),
                )
            });
        self.row(id, engine, outcome, start.elapsed().as_secs_f64());
    }

    pub(crate) fn row(
        &mut self,
        id: &str,
        engine: &'static str,
        outcome: ClaimOutcome,
        seconds: f64,
    ) {
        let row = ClaimResult::new(id, engine, outcome, seconds);
        if let Some(tell) = self.1 {
            tell(&row);
        }
        self.0.push(row);
    }
}
