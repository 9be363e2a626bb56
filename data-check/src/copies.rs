//! Two experiments with the same samples. A held-out prediction of one by the other proves nothing, and
//! the standard errors count the same noise twice.

use bench_files::Channel;

use crate::finding::{Finding, FindingId};
use crate::thresholds::copies::{IN_A_ROW, ROUNDED};
use crate::view::{View, range};

pub(crate) fn check(views: &[View], out: &mut Vec<Finding>) {
    for (index, second) in views.iter().enumerate() {
        for first in &views[..index] {
            if shared(first, second) {
                out.push(
                    Finding::warning(
                        FindingId::SameData,
                        format!(
                            "it has the same samples as \"{}\": one recording counts twice, and a held-out \
                             prediction is not independent",
                            first.name()
                        ),
                    )
                    .in_experiment(second.name())
                    .with_fix("remove one of the two, or use from and until so that they do not overlap"),
                );
            }
        }
    }
}

/// Whether one log contains a stretch from the middle of the other.
fn shared(first: &View, second: &View) -> bool {
    [Channel::Angle, Channel::Rate, Channel::WheelSpeed]
        .into_iter()
        .filter_map(|channel| Some((first.samples(channel)?, second.samples(channel)?)))
        .any(|(a, b)| contains(a, b) || contains(b, a))
}

fn contains(whole: &[f64], part: &[f64]) -> bool {
    // The stretch with the most activity is compared: logs at rest are all alike.
    let Some(stretch) = part.chunks_exact(IN_A_ROW).max_by(|a, b| {
        let distinct = |chunk: &[f64]| chunk.windows(2).filter(|pair| pair[0] != pair[1]).count();
        distinct(a).cmp(&distinct(b))
    }) else {
        return false;
    };
    let Some((low, high)) = range(stretch) else {
        return false;
    };
    let changes = stretch.windows(2).filter(|pair| pair[0] != pair[1]).count();
    high > low
        && 2 * changes > IN_A_ROW
        && stretch.iter().all(|value| value.is_finite())
        && whole
            .windows(IN_A_ROW)
            .any(|window| is_the_same(window, stretch, ROUNDED * (high - low)))
}

/// Whether two stretches differ by rounding alone.
fn is_the_same(window: &[f64], stretch: &[f64], within: f64) -> bool {
    let mut pairs = window.iter().zip(stretch);
    pairs.all(|(a, b)| (a - b).abs() <= within)
}
