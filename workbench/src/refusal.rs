//! The message for data that are refused.

use std::path::Path;

use ::data_check::Finding;

/// The message of [`Error::Data`]: the first refusal with its remedy, and the places of the others.
pub(crate) fn refusal_text(file: &Path, line: Option<usize>, refusals: &[Finding]) -> String {
    let mut text = file.display().to_string();
    if let Some(line) = line {
        text.push_str(&format!(":{line}"));
    }
    let Some(first) = refusals.first() else {
        return text;
    };
    let place = match first.place() {
        none if none.is_empty() => String::new(),
        place => format!("{place}: "),
    };
    text.push_str(&format!(": {place}{}", first.sentence));
    if !first.fix.is_empty() {
        text.push_str(&format!("; to mend it: {}", first.fix));
    }
    if first.experiment.is_some() {
        let accept = format!("accept = [\"{}\"]", first.finding.name());
        text.push_str(&format!("; if the data are right: {accept}"));
    }
    match refusals.len() {
        1 => {}
        2 => text.push_str("; one more finding refuses the bench"),
        more => text.push_str(&format!("; {} more findings refuse the bench", more - 1)),
    }
    text
}
