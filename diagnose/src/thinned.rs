//! Logs that are read more sparsely than they were recorded, and back.

use identify::{Effort, FitProblem, Minimum, Window, joined, refit};

use crate::candidate::Candidate;

/// Whether any log is read more sparsely than it was recorded.
pub fn is_thinned(thinning: &[usize]) -> bool {
    thinning.iter().any(|&step| step > 1)
}

/// The windows of logs that are read at another step: `place` says where a sample stands there.
pub fn windows_at(
    windows: &[Vec<Window>],
    thinning: &[usize],
    place: impl Fn(usize, usize) -> usize,
) -> Vec<Vec<Window>> {
    let moved = |window: &Window, step: usize| Window {
        samples: place(window.samples.start, step)..place(window.samples.end, step),
        nuisances: window.nuisances.clone(),
    };
    windows
        .iter()
        .zip(thinning)
        .map(|(windows, &step)| windows.iter().map(|window| moved(window, step)).collect())
        .collect()
}

/// The fit of a candidate to all samples of the bench.
pub fn whole_fit(
    problem: &FitProblem,
    thinning: &[usize],
    candidate: &Candidate,
    effort: Effort,
) -> Minimum {
    let records = problem.all_records();
    let whole = |start: usize, step: usize| start * step;
    let before = windows_at(&candidate.minimum.windows, thinning, whole);
    let windows = joined(&records, &candidate.minimum.values, &before);
    refit(
        &records,
        &candidate.model,
        candidate.minimum.values.clone(),
        windows,
        &problem.free(&candidate.model),
        effort,
    )
}
