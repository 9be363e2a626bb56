//! An explanation beside which the logs leave an inertia open.
//!
//! From one spin-up at one current, a friction that falls while the wheel starts cannot be told from the inertia that
//! goes with it. Such an explanation may be right, and no motion can be computed with it.

use identify::{finish, open_inertia};

use crate::bench::SearchBench;
use crate::candidate::{Candidate, names};
use crate::decision::Decision;
use crate::pool::Search;
use crate::verdict::Verdict;

/// The decision without models that leave an inertia open, and a sentence on the explanation that was given up; `None`
/// if the decision stands. Of explanations that tie, one that leaves none open is used. If there is none, the model
/// stays as it was; `left` is what that leaves, in units of noise.
pub fn without_open(
    bench: &SearchBench,
    found: &Search,
    decision: &Decision,
    left: f64,
) -> Option<(Decision, String)> {
    let is_open = |index: usize| {
        let Candidate { model, minimum, .. } = &found.pool[index];
        let free = bench.problem.free(model);
        let fit = finish(&bench.records, model, &free, minimum.clone());
        open_inertia(bench.problem, &fit).is_some()
    };
    let last = decision.last();
    // Where the model leaves it open as it is, the fit itself has failed.
    if last == 0 || !is_open(last) || is_open(0) {
        return None;
    }
    let sentence = format!(
        "{} would explain the logs, but beside it they do not determine an inertia. Record spin-ups at several \
         currents in both directions and a coast-down to standstill, or state what is known in [known].",
        names(&found.pool[last].added)
    );
    let provisional = decision.ties.iter().copied().find(|&tie| !is_open(tie));
    let certain = if is_open(decision.certain) {
        0
    } else {
        decision.certain
    };
    let settled = if provisional.is_some() {
        Decision {
            certain,
            provisional,
            ..decision.clone()
        }
    } else {
        Decision {
            certain: 0,
            provisional: None,
            ties: vec![],
            verdict: if left > bench.thresholds.remains {
                Verdict::Unexplained
            } else {
                Verdict::NothingMissing
            },
            remainder: left,
        }
    };
    Some((settled, sentence))
}
