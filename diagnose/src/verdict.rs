//! The verdict that follows from the findings of a search.

use crate::thresholds::Thresholds;

/// The verdict of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The model explains the measurements down to the noise of the sensors.
    NothingMissing,
    /// The model with the added effects explains them down to the noise of the sensors.
    Explained,
    /// Several sets of effects explain the measurements equally well.
    Ambiguous,
    /// A remainder is left that no effect of the library explains.
    Unexplained,
}

impl Verdict {
    /// The name of the verdict in reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::NothingMissing => "nothing-missing",
            Verdict::Explained => "explained",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
    }
}

/// The findings on which a verdict rests.
#[derive(Clone, Copy, Debug)]
pub struct Findings {
    /// Number of added effects in the candidate with everything that is certain.
    pub added: usize,
    /// The largest structured remainder of that candidate, in units of noise.
    pub remainder: f64,
    /// Number of candidates that tie.
    pub ties: usize,
    /// The largest structured remainder of the best of those, in units of noise.
    pub left_by_ties: f64,
}

/// Derives the verdict from the findings.
pub fn verdict(findings: &Findings, thresholds: &Thresholds) -> Verdict {
    let remains = findings.remainder > thresholds.remains;
    // If the effects that the ties share leave less than the noise, the answer is complete: the further effects,
    // on which the ties disagree, only absorb imperfections of the shared terms.
    let is_shared = findings.added > 0 && !remains;
    // Explanations that tie but leave a large remainder explain nothing.
    let explain = findings.ties > 1 && findings.left_by_ties <= thresholds.left_by_ties;
    if explain && !is_shared {
        Verdict::Ambiguous
    } else if remains {
        Verdict::Unexplained
    } else if findings.added == 0 {
        Verdict::NothingMissing
    } else {
        Verdict::Explained
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(added: usize, remainder: f64, ties: usize, left_by_ties: f64) -> Verdict {
        let findings = Findings {
            added,
            remainder,
            ties,
            left_by_ties,
        };
        verdict(&findings, &Thresholds::default())
    }

    #[test]
    fn what_remains_and_what_ties_decide() {
        let none = f64::INFINITY;
        let cases = [
            (of(0, 0.0, 0, none), Verdict::NothingMissing),
            (of(0, 1.0, 0, none), Verdict::NothingMissing),
            (of(0, 1.1, 0, none), Verdict::Unexplained),
            (of(1, 0.3, 0, none), Verdict::Explained),
            (of(2, 4.0, 0, none), Verdict::Unexplained),
            // Nothing is common to the ties, or what is leaves something.
            (of(0, 6.0, 2, 0.0), Verdict::Ambiguous),
            (of(1, 2.0, 3, 1.5), Verdict::Ambiguous),
            // What they share is all that there is.
            (of(1, 0.5, 2, 0.0), Verdict::Explained),
            // None of them explains.
            (of(0, 9.0, 2, 5.0), Verdict::Unexplained),
        ];
        for (found, expected) in cases {
            assert_eq!(found, expected);
        }
    }
}
