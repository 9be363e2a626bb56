//! The verdict that the findings of a search come to.

use crate::thresholds::Thresholds;

/// What the diagnosis says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The model explains the measurements down to the noise of the sensors.
    NothingMissing,
    /// With the added effects it does.
    Explained,
    /// Several sets of effects explain the measurements equally well.
    Ambiguous,
    /// Something remains that no effect of the library accounts for.
    Unexplained,
}

impl Verdict {
    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::NothingMissing => "nothing-missing",
            Verdict::Explained => "explained",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
    }
}

/// What a verdict rests on.
#[derive(Clone, Copy, Debug)]
pub struct Findings {
    /// Number of effects of the candidate with what could be added for certain.
    pub added: usize,
    /// What that candidate leaves, the largest structured remainder in units of noise.
    pub remainder: f64,
    /// Number of candidates that tie.
    pub ties: usize,
    /// What the best of them leaves, likewise.
    pub left_by_ties: f64,
}

/// The verdict.
pub fn verdict(findings: &Findings, thresholds: &Thresholds) -> Verdict {
    let remains = findings.remainder > thresholds.remains;
    // What ties share may be all that there is: where it leaves less than the noise, additions that
    // disagree with each other are the imperfections of its terms and no effects.
    let is_shared = findings.added > 0 && !remains;
    // Explanations that tie but leave most of it unexplained explain nothing.
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
