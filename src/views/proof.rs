//! The claims of an emitted crate, with the results of their proofs.

use workbench::numbers::significant;
use workbench::{Proof, ProofVerdict};

use crate::report::table::{Align, Table};

/// "31 rows proved, 12 tested, 3 not run, 3 not applicable".
fn counts(proof: &Proof) -> String {
    let words = ["proved", "tested", "not run", "not applicable"];
    let count = |word: &str| {
        let rows = proof.claims.iter();
        rows.filter(|claim| claim.outcome.word() == word).count()
    };
    let counts: Vec<String> = words
        .into_iter()
        .map(|word| (count(word), word))
        .filter(|(count, _)| *count > 0)
        .map(|(count, word)| format!("{count} {word}"))
        .collect();
    format!("of {} rows {}", proof.claims.len(), counts.join(", "))
}

/// The claims, a row for each engine, and the verdict in a sentence.
pub fn text(proof: &Proof, verdict: &ProofVerdict) -> String {
    let mut table = Table::new(&[
        ("claim", Align::Left),
        ("engine", Align::Left),
        ("result", Align::Left),
        ("seconds", Align::Right),
        ("detail", Align::Left),
    ]);
    let mut statements = String::new();
    let mut last = "";
    for claim in &proof.claims {
        table.row([
            claim.id.clone(),
            claim.engine.to_owned(),
            claim.outcome.word().to_owned(),
            significant(claim.seconds, 3),
            claim.outcome.detail(),
        ]);
        if claim.id != last {
            last = &claim.id;
            statements.push_str(&format!("  {}: {}\n", claim.id, claim.statement));
            statements.push_str(&format!("    holds for: {}\n", claim.domain));
            if !claim.assumptions.is_empty() {
                statements.push_str(&format!("    assumes: {}\n", claim.assumptions));
            }
        }
    }
    let said = match verdict {
        ProofVerdict::Holds => {
            format!(
                "No claim fails, and every claim that applies to this module is proved or tested: {}.",
                counts(proof)
            )
        }
        ProofVerdict::Unsettled(claims) => format!(
            "No claim fails, but no engine settled {}: the rows `not run` give the reasons (exit code 3; 0 with --allow-not-run).",
            claims.join(", ")
        ),
        ProofVerdict::Fails(claims) => format!("Claims that FAIL: {}.", claims.join(", ")),
    };
    format!(
        "{}: what the emitted files promise, checked from these files alone (seed {})\n{statements}\n{}\n{said}\n",
        proof.folder.display(),
        proof.seed,
        table.text(),
    )
}
