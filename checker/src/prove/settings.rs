//! Which engines run, and how long.

/// Which engines run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProofSettings {
    /// Random runs of each kind.
    pub cases: usize,
    /// Seed of the random runs.
    pub seed: u64,
    /// Whether the texts are held against the audited ones; an audit of new texts leaves this out.
    pub audited_texts: bool,
    /// Whether the crate is compiled and run, where Cargo is installed (seconds).
    pub compiled: bool,
    /// Whether z3 is asked, where there is one.
    pub smt: bool,
    /// Whether Kani runs, where it is installed (minutes).
    pub kani: bool,
    /// Whether the bounds of the closed loop are computed (a fraction of a second).
    pub closed_loop: bool,
    /// Whether the second checker runs, where Python is installed (a second).
    pub python: bool,
    /// Whether the ranges of the filter are shown (minutes where they cannot be).
    pub filter_ranges: bool,
    /// Whether the quaternion's length is bounded (seconds); it needs the ranges.
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
