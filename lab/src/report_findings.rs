//! The results from which a report is made.

use workbench::{ComparisonReport, DiagnosisReport, Proof, Session};

/// The data for a report.
pub struct ReportFindings<'a> {
    /// The session, with the model that the report is about.
    pub session: &'a Session,
    /// The comparison of that model with the measurements.
    pub comparison: &'a ComparisonReport,
    /// The diagnosis of that model, if there is one.
    pub diagnosis: Option<&'a DiagnosisReport>,
    /// The proof of the controller for that model, or the reason why there is none.
    pub proof: Result<&'a Proof, &'a str>,
}
