//! Whether a sensor would show what one candidate adds to another.

use identify::{Record, acts};

use crate::bench::SearchBench;
use crate::candidate::Candidate;
use crate::remainder::noise;

/// The fall of every error from `before` to `after` in units of the series' noise: the root of the
/// difference of the mean squares.
fn traces(records: &[&Record], before: &Candidate, after: &Candidate) -> Vec<f64> {
    before
        .rmse()
        .iter()
        .zip(after.rmse())
        .zip(noise(records))
        .map(|((before, after), noise)| (before * before - after * after).max(0.0).sqrt() / noise)
        .collect()
}

/// The largest fall of an error from `before` to `after`, over all series, in units of the series' noise.
pub fn largest_trace(records: &[&Record], before: &Candidate, after: &Candidate) -> f64 {
    traces(records, before, after)
        .into_iter()
        .fold(0.0, f64::max)
}

/// Whether what `larger` adds to `smaller` leaves a trace in any series that a person would see, and
/// that the imperfections of what was added before cannot be. `start` is the model as it was.
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
            // Whether the dry friction was added now or stood in the model before.
            trace >= least && trace >= thresholds.times_imperfection * imperfection()
        })
}
