//! A diagnosis that is cancelled.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};

use diagnose::{Options, diagnose_with};
use exam::draw;
use identify::{Cancelled, Progress, identify};
use plant::Model;

/// A cancelled diagnosis ends before its next fit. Each of the fits that run in parallel checks once more for
/// cancellation, and no progress is reported after that.
#[test]
fn a_diagnosis_ends_soon_after_it_is_called_off() {
    let bench = draw(5).expect("a bench");
    let (problem, base) = (&bench.problem, Model::base());
    let fitted = identify(problem, &base, None).expect("a fit").fit.minimum;
    let run = |calls: usize| {
        let (asked, late) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let said_late = Cell::new(0);
        let say = |_: &str| {
            if late.load(Ordering::SeqCst) > 0 {
                said_late.set(said_late.get() + 1);
            }
        };
        let cancelled = || {
            let is_off = asked.fetch_add(1, Ordering::SeqCst) >= calls;
            late.fetch_add(usize::from(is_off), Ordering::SeqCst);
            is_off
        };
        let progress = Progress {
            say: &say,
            cancelled: &cancelled,
        };
        let found = diagnose_with(
            problem,
            &base,
            fitted.clone(),
            &Options::default(),
            &progress,
        );
        let late = late.into_inner();
        (
            found.map(|found| found.verdict),
            asked.into_inner(),
            late,
            said_late.get(),
        )
    };
    let (whole, asked, late, _) = run(usize::MAX);
    assert!(whole.is_ok() && late == 0);
    assert!(asked > 10, "{asked}");
    for calls in [0, 1, asked / 2, asked - 1] {
        let (found, _, late, said_late) = run(calls);
        assert_eq!(found, Err(Cancelled), "after {calls} of {asked}");
        assert!(late <= 8, "asked {late} times more after {calls}");
        assert_eq!(said_late, 0);
    }
}
