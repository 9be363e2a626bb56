//! What a report is made from.

use workbench::{ComparisonReport, DiagnosisReport, Proof, Session};

/// The data for a report.
pub struct Findings<'a> {
    /// The session, with the model that the report is about.
    pub session: &'a Session,
    /// That model compared with the measurements.
    pub comparison: &'a ComparisonReport,
    /// Its diagnosis, if one was made.
    pub diagnosis: Option<&'a DiagnosisReport>,
    /// The proof of its controller, or the reason why there is none.
    pub proof: Result<&'a Proof, &'a str>,
}
