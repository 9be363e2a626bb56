//! Two experiments with the same samples: a held-out prediction of one by the other proves nothing, and
//! standard errors count the same noise twice.

use bench_files::Channel;

use crate::finding::{Finding, FindingId};
use crate::view::{View, range};

/// Samples in a row that two recordings do not share by chance.
const IN_A_ROW: usize = 32;

pub(crate) fn check(views: &[View], out: &mut Vec<Finding>) {
    for (index, second) in views.iter().enumerate() {
        for first in &views[..index] {
            if shared(first, second) {
                out.push(
                    Finding::warning(
                        FindingId::SameData,
                        format!(
                            "it has the same samples as \"{}\": one recording counts twice, and what is held \
                             out is not unseen",
                            first.name()
                        ),
                    )
                    .in_experiment(second.name())
                    .with_fix("take one of the two out, or use from and until so that they do not overlap"),
                );
            }
        }
    }
}

/// Whether the second log contains a stretch from the middle of the first, or the other way round.
fn shared(first: &View, second: &View) -> bool {
    [Channel::Angle, Channel::Rate, Channel::WheelSpeed]
        .into_iter()
        .filter_map(|channel| Some((first.samples(channel)?, second.samples(channel)?)))
        .any(|(a, b)| contains(a, b) || contains(b, a))
}

fn contains(whole: &[f64], part: &[f64]) -> bool {
    // The stretch of the part in which most happens: where nothing does, all logs are alike.
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
        && whole.windows(IN_A_ROW).any(|window| window == stretch)
}
