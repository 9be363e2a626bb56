//! What came of a claim, and by what means.

/// What came of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClaimOutcome {
    /// Shown for the whole domain; with what was found.
    Proved(String),
    /// Held in so many cases.
    Tested(usize),
    /// Not looked at, and why.
    NotRun(String),
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
            Ok(cases) => ClaimOutcome::Tested(cases),
            Err(why) => ClaimOutcome::Failed(why),
        }
    }

    /// The word of the contract: `proved`, `tested`, `not run`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            ClaimOutcome::Proved(_) => "proved",
            ClaimOutcome::Tested(_) => "tested",
            ClaimOutcome::NotRun(_) => "not run",
            ClaimOutcome::Failed(_) => "failed",
        }
    }

    /// What is said beside the word.
    pub fn detail(&self) -> String {
        match self {
            ClaimOutcome::Proved(text)
            | ClaimOutcome::NotRun(text)
            | ClaimOutcome::Failed(text) => text.clone(),
            ClaimOutcome::Tested(cases) => format!("{cases} cases"),
        }
    }
}

/// IntegerInterval and affine analysis of the source.
pub const INTERVALS: &str = "intervals of the source";
/// Rational arithmetic on the certificate.
pub const EXACT: &str = "exact arithmetic";
/// The interpreter on random inputs.
pub const RANDOM: &str = "random runs of the source";
/// z3.
pub const SMT: &str = "z3";
/// Kani.
pub const KANI: &str = "Kani";
/// Reading the source.
pub const READER: &str = "reader of the source";
