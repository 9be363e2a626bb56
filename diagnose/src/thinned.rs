//! Thinned logs (every n-th sample is read), and the way back to all samples.

use identify::{Effort, FitProblem, Minimum, Window, joined, refit};

use crate::candidate::Candidate;

/// Whether any log is thinned: a step is larger than 1.
pub fn is_thinned(thinning: &[usize]) -> bool {
    thinning.iter().any(|&step| step > 1)
}

/// Converts windows between thinned and full logs. `place(index, step)` converts one sample index.
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

/// Fits a candidate to all samples of the bench, starting from its fit to the thinned ones.
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
