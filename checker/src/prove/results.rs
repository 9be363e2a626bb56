//! Rows of what was settled.

use std::time::Instant;

use serde::Serialize;

use crate::certificate::claims::{ClaimStatement, claim};
use crate::claims::outcome::ClaimOutcome;

/// One claim, settled by one engine.
#[derive(Clone, Debug, PartialEq)]
pub struct ClaimResult {
    /// Identifier.
    pub id: String,
    /// One sentence.
    pub statement: String,
    /// By what means.
    pub engine: &'static str,
    /// For which inputs.
    pub domain: String,
    /// What is assumed; empty if nothing.
    pub assumptions: String,
    /// What came of it.
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
    detail: String,
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
            detail: self.outcome.detail(),
            seconds: self.seconds,
        }
        .serialize(serializer)
    }
}

/// Whether no claim failed.
pub fn passed(results: &[ClaimResult]) -> bool {
    results
        .iter()
        .all(|result| !matches!(result.outcome, ClaimOutcome::Failed(_)))
}

/// Collects rows.
pub(crate) struct Table(pub(crate) Vec<ClaimResult>);

impl Table {
    pub(crate) fn add(
        &mut self,
        id: &str,
        engine: &'static str,
        settle: impl FnOnce() -> ClaimOutcome,
    ) {
        let start = Instant::now();
        let outcome = settle();
        self.row(id, engine, outcome, start.elapsed().as_secs_f64());
    }

    pub(crate) fn row(
        &mut self,
        id: &str,
        engine: &'static str,
        outcome: ClaimOutcome,
        seconds: f64,
    ) {
        let known: Option<&ClaimStatement> = claim(id);
        self.0.push(ClaimResult {
            id: id.to_owned(),
            statement: known.map_or("", |claim| claim.statement).to_owned(),
            engine,
            domain: known.map_or("", |claim| claim.domain).to_owned(),
            assumptions: known.map_or("", |claim| claim.assumptions).to_owned(),
            outcome,
            seconds,
        });
    }
}
