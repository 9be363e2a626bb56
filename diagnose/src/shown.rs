//! Whether the measurements would show what one candidate adds to another.

use identify::{Record, acts};

use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::remainder::noise;

/// How far the error of every series falls from `before` to `after`, in units of the series' noise: the root of the
/// difference of the mean squared errors; 0 where the error grows.
fn traces(records: &[&Record], before: &Candidate, after: &Candidate) -> Vec<f64> {
    before
        .rmse()
        .iter()
        .zip(after.rmse())
        .zip(noise(records))
        .map(|((before, after), noise)| (before * before - after * after).max(0.0).sqrt() / noise)
        .collect()
}

/// The largest such fall over all series, in units of the series' noise.
pub fn largest_trace(records: &[&Record], before: &Candidate, after: &Candidate) -> f64 {
    traces(records, before, after)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether the addition that turns `smaller` into `larger` lowers the error of any series visibly, and by more than
/// imperfections of the effects that were added before could. `start` is the starting model of the search.
pub fn shows(
    bench: &SearchBench,
    start: &Candidate,
    smaller: &Candidate,
    larger: &Candidate,
) -> bool {
    let (records, thresholds) = (&bench.records, bench.thresholds);
    let is_refinement = smaller.added.len() == larger.added.len();
    let share = thresholds.least_share_of_trace * largest_trace(records, start, smaller);
    let kinds = records
        .iter()
        .flat_map(|record| record.channels.iter().map(|_| record.kind));
    traces(records, smaller, larger)
        .into_iter()
        .zip(kinds)
        .enumerate()
        .any(|(series, (trace, kind))| {
            let is_touched = smaller.added.iter().any(|&effect| acts(effect, kind));
            let least = match (is_touched, is_refinement) {
                (false, _) => thresholds.least_trace,
                (true, true) => thresholds.least_trace_of_refinement,
                (true, false) => thresholds.least_trace_beside.max(share),
            };
            let imperfection = || bench.imperfection(smaller).rms_over_noise[series];
            // It does not matter whether the dry friction was added now or was in the model before.
            trace >= least && trace >= thresholds.times_imperfection * imperfection()
        })
}
