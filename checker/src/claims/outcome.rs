//! The result of a claim, and the means by which it was decided.

/// The outcome of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClaimOutcome {
    /// Proved for the whole domain; with the finding.
    Proved(String),
    /// Held in this number of cases; with a remark, if any.
    Tested(usize, String),
    /// Not examined, with the reason.
    NotRun(String),
    /// Does not apply to this module, with the reason.
    NotApplicable(String),
    /// Does not hold, or could not be proved.
    Failed(String),
}

impl ClaimOutcome {
    /// The outcome of a proof: its finding, or the reason of its failure.
    pub fn proved(result: Result<String, String>) -> ClaimOutcome {
        match result {
            Ok(text) => ClaimOutcome::Proved(text),
            Err(why) => ClaimOutcome::Failed(why),
        }
    }

    /// The outcome of runs: their number, or the first failure.
    pub fn tested(result: Result<usize, String>) -> ClaimOutcome {
        match result {
            Ok(cases) => ClaimOutcome::Tested(cases, String::new()),
            Err(why) => ClaimOutcome::Failed(why),
        }
    }

    /// The name: `proved`, `tested`, `not run`, `not applicable`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            ClaimOutcome::Proved(_) => "proved",
            ClaimOutcome::Tested(..) => "tested",
            ClaimOutcome::NotRun(_) => "not run",
            ClaimOutcome::NotApplicable(_) => "not applicable",
            ClaimOutcome::Failed(_) => "failed",
        }
    }

    /// The text beside the name: the finding, or the reason.
    pub fn why(&self) -> &str {
        match self {
            ClaimOutcome::Proved(text)
            | ClaimOutcome::Tested(_, text)
            | ClaimOutcome::NotRun(text)
            | ClaimOutcome::NotApplicable(text)
            | ClaimOutcome::Failed(text) => text,
        }
    }

    /// The number of tested cases.
    pub fn cases(&self) -> Option<usize> {
        match self {
            ClaimOutcome::Tested(cases, _) => Some(*cases),
            _ => None,
        }
    }

    /// Number of cases and text, in one line.
    pub fn detail(&self) -> String {
        match self.cases() {
            Some(cases) if self.why().is_empty() => format!("{cases} cases"),
            Some(cases) => format!("{cases} cases; {}", self.why()),
            None => self.why().to_owned(),
        }
    }
}

/// Interval and affine analysis of the source.
pub const INTERVALS: &str = "intervals of the source";
/// Rational arithmetic on the certificate.
pub const EXACT: &str = "exact arithmetic";
/// The interpreter on random inputs.
pub const RANDOM: &str = "random runs of the source";
/// z3.
pub const SMT: &str = "z3";
/// Kani.
pub const KANI: &str = "Kani";
/// The crate, compiled and run.
pub const COMPILED: &str = "the compiled crate";
/// A small program in Python.
pub const PYTHON: &str = "second checker (Python)";
/// Reading the source.
pub const READER: &str = "reader of the source";
