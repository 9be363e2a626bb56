//! CLAIMS.md: what is promised, by what it is settled, and where each constant comes from.

use crate::certificate::Certificate;
use crate::claims::CLAIMS;
use crate::prove::ClaimResult;

/// The text of CLAIMS.md for one emitted crate. `results` tells which engines settle a claim; times
/// and outcomes, which differ from machine to machine, are not in the text.
pub fn claims(certificate: &Certificate, results: &[ClaimResult]) -> String {
    let mut text = String::from(
        "# Claims\n\n\
         Written by the checker from the table that `flywheel prove` uses. A test holds this file\n\
         against that table.\n\n\
         | claim | statement | domain | assumptions | engines |\n|---|---|---|---|---|\n",
    );
    for claim in &CLAIMS {
        let engines: Vec<&str> = results
            .iter()
            .filter(|result| result.id == claim.id)
            .map(|result| result.engine)
            .collect();
        let assumptions = if claim.assumptions.is_empty() {
            "none"
        } else {
            claim.assumptions
        };
        text.push_str(&format!(
            "| `{}` | {} | {} | {assumptions} | {} |\n",
            claim.id,
            claim.statement,
            claim.domain,
            engines.join(", ")
        ));
    }
    text.push_str(&format!(
        "\n# Where the constants of the control law come from\n\n\
         Parameters ({}) and weights give K; each constant is an entry of −K or the limit, rounded\n\
         to its format.\n\n\
         | constant | from | real | word | format | line | claims |\n|---|---|---|---|---|---|---|\n",
        certificate
            .parameters
            .iter()
            .map(|parameter| format!("`{}`", parameter.name))
            .collect::<Vec<_>>()
            .join(", ")
    ));
    for constant in &certificate.constants {
        text.push_str(&format!(
            "| `{}` | `{}` | {} {} | {} | / 2^{} | {}:{} | {} |\n",
            constant.name,
            constant.from,
            constant.real,
            constant.unit,
            constant.raw,
            constant.fraction_bits,
            constant.file,
            constant.line,
            constant.claims.join(", ")
        ));
    }
    text
}
