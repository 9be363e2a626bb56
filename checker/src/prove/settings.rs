//! Which engines run, and how long.

/// Which engines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProofSettings {
    /// Random runs of each kind.
    pub cases: usize,
    /// Seed of the random runs.
    pub seed: u64,
    /// Whether the texts are compared with the audited ones; an audit of new texts leaves this out.
    pub audited_texts: bool,
    /// Whether the crate is compiled and run, if Cargo is installed (takes seconds).
    pub compiled: bool,
    /// Whether z3 is used, if it is installed.
    pub smt: bool,
    /// Whether Kani runs, if it is installed (takes minutes).
    pub kani: bool,
    /// Whether the bounds of the closed loop are computed (takes seconds).
    pub closed_loop: bool,
    /// Whether the second checkers run, if Python is installed (takes about ten seconds).
    pub python: bool,
    /// Whether the ranges of the filter are proved (takes minutes if they cannot be proved).
    pub filter_ranges: bool,
    /// Whether the quaternion's length is bounded (takes seconds); this needs the ranges.
    pub filter_length: bool,
}

impl Default for ProofSettings {
    fn default() -> Self {
        ProofSettings {
            cases: 20_000,
            seed: 1,
            audited_texts: true,
            compiled: true,
            smt: true,
            kani: true,
            closed_loop: true,
            python: true,
            filter_ranges: true,
            filter_length: true,
        }
    }
}
