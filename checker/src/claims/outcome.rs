//! What came of a claim, and by what means.

/// What came of a claim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Shown for the whole domain; with what was found.
    Proved(String),
    /// Held in so many cases.
    Tested(usize),
    /// Not looked at, and why.
    NotRun(String),
    /// Does not hold, or could not be shown.
    Failed(String),
}

impl Outcome {
    /// Of a proof: what was found, or why not.
    pub fn proved(result: Result<String, String>) -> Outcome {
        match result {
            Ok(text) => Outcome::Proved(text),
            Err(why) => Outcome::Failed(why),
        }
    }

    /// Of runs: how many, or the first that failed.
    pub fn tested(result: Result<usize, String>) -> Outcome {
        match result {
            Ok(cases) => Outcome::Tested(cases),
            Err(why) => Outcome::Failed(why),
        }
    }

    /// The word of the contract: `proved`, `tested`, `not run`, `failed`.
    pub fn word(&self) -> &'static str {
        match self {
            Outcome::Proved(_) => "proved",
            Outcome::Tested(_) => "tested",
            Outcome::NotRun(_) => "not run",
            Outcome::Failed(_) => "failed",
        }
    }

    /// What is said beside the word.
    pub fn detail(&self) -> String {
        match self {
            Outcome::Proved(text) | Outcome::NotRun(text) | Outcome::Failed(text) => text.clone(),
            Outcome::Tested(cases) => format!("{cases} cases"),
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
/// Reading the source.
pub const READER: &str = "reader of the source";
