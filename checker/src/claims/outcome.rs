//! The result of a claim, and the means by which it was decided.

/// What came of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClaimOutcome {
    /// Shown for the whole domain; with what was found.
    Proved(String),
    /// Held in so many cases; with what else is to be said, if anything.
    Tested(usize, String),
    /// Not looked at, and why.
    NotRun(String),
    /// Says nothing of this module, and why.
    NotApplicable(String),
    /// Does not hold, or could not be shown.
    Failed(String),
}

impl ClaimOutcome {
    /// Of a proof: what was found, or why not.
    pub fn proved(result: Result<String, String>) -> ClaimOutcome {
        match result {
            Ok(text) => ClaimOutcome::Proved(text),
            Err(why) => ClaimOutcome::Failed(why),
        }
    }

    /// Of runs: how many, or the first that failed.
    pub fn tested(result: Result<usize, String>) -> ClaimOutcome {
        match result {
            Ok(cases) => ClaimOutcome::Tested(cases, String::new()),
            Err(why) => ClaimOutcome::Failed(why),
        }
    }

    /// The word for it: `proved`, `tested`, `not run`, `not applicable`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            ClaimOutcome::Proved(_) => "proved",
            ClaimOutcome::Tested(..) => "tested",
            ClaimOutcome::NotRun(_) => "not run",
            ClaimOutcome::NotApplicable(_) => "not applicable",
            ClaimOutcome::Failed(_) => "failed",
        }
    }

    /// What is said beside the word: what was found, or why not.
    pub fn why(&self) -> &str {
        match self {
            ClaimOutcome::Proved(text)
            | ClaimOutcome::Tested(_, text)
            | ClaimOutcome::NotRun(text)
            | ClaimOutcome::NotApplicable(text)
            | ClaimOutcome::Failed(text) => text,
        }
    }

    /// In how many cases it was tested.
    pub fn cases(&self) -> Option<usize> {
        match self {
            ClaimOutcome::Tested(cases, _) => Some(*cases),
            _ => None,
        }
    }

    /// Cases and what is said beside the word, in one line.
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
