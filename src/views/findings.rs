//! The findings of the data check, in words.

use workbench::{DataReport, Finding, Severity};

use super::head_lines::{counted, head_lines};

/// The output of `check`.
pub fn report(found: &DataReport) -> String {
    let mut text = head_lines(&found.bench, found.experiments, found.samples, &found.notes);
    if found.findings.is_empty() {
        text.push_str(
            "Nothing is wrong with these data, as far as they show it without a model.\n",
        );
        return text;
    }
    let is_refusal = |finding: &&Finding| finding.severity == Severity::Refuse;
    let refusals = found.findings.iter().filter(is_refusal).count();
    let warnings = found.findings.len() - refusals;
    text.push_str(&list(&found.findings));
    text.push_str(&format!(
        "\n{}, {}\n",
        counted(refusals, "refusal"),
        counted(warnings, "warning")
    ));
    if refusals > 0 {
        text.push_str(
            "No command uses refused data; accept = [\"finding\"] at the experiment lifts a refusal.\n",
        );
    }
    text
}

/// The findings as a section at the top of a report; empty if there are none.
pub fn list(findings: &[Finding]) -> String {
    if findings.is_empty() {
        return String::new();
    }
    let mut text = "\nThe data\n".to_owned();
    for finding in findings {
        let severity = match finding.severity {
            Severity::Refuse => "REFUSED",
            Severity::Warn => "warning",
        };
        let place = match finding.place() {
            none if none.is_empty() => "bench".to_owned(),
            place => place,
        };
        text.push_str(&format!(
            "  {severity}  {place}  ({})\n",
            finding.finding.name()
        ));
        text.push_str(&format!("    {}\n", finding.sentence));
        if !finding.fix.is_empty() {
            text.push_str(&format!("    to mend it: {}\n", finding.fix));
        }
    }
    text
}
