//! Where a learned curve may bend.

use nalgebra::DVector;
use plant::{LearnedCoordinate, MOST_KNOTS, Spline};

use crate::records::{Output, Record};

/// Number of knots of the first curve, from which the knots of the final curve follow.
const FINE: usize = 96;
/// Fewest distinct samples between two knots.
const FEWEST_BETWEEN: usize = 8;
/// Shares of the knots that are spread evenly over the range, and evenly over the samples. The other knots go where the
/// curve bends.
const EVENLY: (f64, f64) = (0.3, 0.05);

/// The measured samples of a coordinate in a log that counts. Samples that the fit leaves out are left out here, too.
pub(super) fn samples_of(record: &Record, coordinate: LearnedCoordinate) -> Vec<f64> {
    let of = |output: Output| {
        record
            .channel(output)
            .map(|channel| channel.samples.clone())
    };
    let integrated = || -> Option<Vec<f64>> {
        of(Output::WheelSpeed)?;
        let turn = std::f64::consts::TAU;
        Some(
            record
                .wheel_angles()
                .iter()
                .map(|a| a.rem_euclid(turn))
                .collect(),
        )
    };
    let series = match coordinate {
        LearnedCoordinate::Angle => {
            of(Output::Angle).or_else(|| crate::records::angle_samples(record))
        }
        LearnedCoordinate::Rate => of(Output::Rate).or_else(|| differences(record)),
        LearnedCoordinate::WheelSpeed => of(Output::WheelSpeed),
        LearnedCoordinate::WheelAngle => integrated(),
    };
    let series = series.unwrap_or_default();
    series
        .into_iter()
        .zip(&record.weight)
        .filter(|(value, weight)| value.is_finite() && **weight > 0.0)
        .map(|(value, _)| value)
        .collect()
}

/// The rate from the measured angle, over enough samples that its noise is small against the rate.
fn differences(record: &Record) -> Option<Vec<f64>> {
    let angle = &record.channel(Output::Angle)?.samples;
    let step = (record.len() / 400).clamp(2, 20);
    let n = angle.len();
    Some(
        (0..n)
            .map(|k| {
                let (from, to) = (k.saturating_sub(step), (k + step).min(n - 1));
                (angle[to] - angle[from]) / (record.time_s[to] - record.time_s[from])
            })
            .collect(),
    )
}

/// Knots from a density over the range: between two knots, the integral of the density is always the same. `cells` are
/// the edges of the pieces over which the density is constant.
fn by_density(cells: &[f64], density: &[f64], count: usize) -> Vec<f64> {
    let total: f64 = density.iter().sum();
    let mut knots = vec![cells[0]];
    let (mut cell, mut before) = (0, 0.0);
    for k in 1..count - 1 {
        let wanted = total * k as f64 / (count - 1) as f64;
        while cell < density.len() - 1 && before + density[cell] < wanted {
            before += density[cell];
            cell += 1;
        }
        let share = if density[cell] > 0.0 {
            (wanted - before) / density[cell]
        } else {
            0.5
        };
        knots.push(cells[cell] + share.clamp(0.0, 1.0) * (cells[cell + 1] - cells[cell]));
    }
    knots.push(cells[cells.len() - 1]);
    let least = 1e-6 * (cells[cells.len() - 1] - cells[0]);
    knots.dedup_by(|next, last| *next - *last < least);
    knots
}

/// The range of the samples, cut evenly, with the number of samples in each cell; `None` where they do not move.
fn cells(samples: &[f64], count: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    let first = samples.iter().copied().fold(f64::INFINITY, f64::min);
    let last = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let span = last - first;
    let moves = span.is_finite() && span > 1e-9 * first.abs().max(last.abs()).max(1e-9);
    if !moves || samples.len() < 4 * FEWEST_BETWEEN {
        return None;
    }
    let edges: Vec<f64> = (0..=count)
        .map(|k| first + span * k as f64 / count as f64)
        .collect();
    let mut seen = vec![0.0; count];
    for sample in samples {
        let cell = ((sample - first) / span * count as f64) as usize;
        seen[cell.min(count - 1)] += 1.0;
    }
    Some((edges, seen))
}

/// Knots for the first curve: half of them evenly over the range of the samples, half of them where the samples are.
pub(super) fn fine_knots(samples: &[f64], coordinate: LearnedCoordinate) -> Option<Vec<f64>> {
    let (edges, seen) = cells(samples, 4 * FINE)?;
    let count = FINE.min(samples.len() / FEWEST_BETWEEN).max(4);
    if let Some(period) = coordinate.period() {
        return Some(evenly_round(period, count));
    }
    let all: f64 = seen.iter().sum();
    let visited = seen.iter().filter(|count| **count > 0.0).count() as f64;
    let density: Vec<f64> = seen
        .iter()
        .map(|&count| if count > 0.0 { 0.5 / visited } else { 0.0 } + 0.5 * count / all)
        .collect();
    Some(by_density(&edges, &density, count))
}

fn evenly_round(period: f64, count: usize) -> Vec<f64> {
    (0..count)
        .map(|k| period * k as f64 / count as f64)
        .collect()
}

/// The knots of the final curve. Most of them go where the first curve (`torque_nm` at the knots of `spline`, found
/// without simulation) bends; the density is the root of the curvature (de Boor, *A Practical Guide to Splines*, 2001,
/// ch. XII).
pub(super) fn final_knots(
    samples: &[f64],
    coordinate: LearnedCoordinate,
    spline: &Spline,
    torque_nm: &[f64],
) -> Option<Vec<f64>> {
    let count = MOST_KNOTS.min(samples.len() / FEWEST_BETWEEN).max(4);
    if let Some(period) = coordinate.period() {
        return Some(evenly_round(period, count));
    }
    let (edges, seen) = cells(samples, 8 * MOST_KNOTS)?;
    let bends: DVector<f64> = spline.curvatures(torque_nm);
    let knots = spline.knots();
    let bend_at = |s: f64| -> f64 {
        let after = knots
            .partition_point(|knot| *knot <= s)
            .clamp(1, knots.len() - 1);
        let share = (s - knots[after - 1]) / (knots[after] - knots[after - 1]);
        let share = share.clamp(0.0, 1.0);
        (bends[after - 1] * (1.0 - share) + bends[after] * share)
            .abs()
            .sqrt()
    };
    let all: f64 = seen.iter().sum();
    let visited = seen.iter().filter(|count| **count > 0.0).count() as f64;
    let bent: Vec<f64> = edges
        .windows(2)
        .zip(&seen)
        .map(|(edge, seen)| {
            if *seen > 0.0 {
                bend_at(0.5 * (edge[0] + edge[1]))
            } else {
                0.0
            }
        })
        .collect();
    let all_bent: f64 = bent.iter().sum();
    let density: Vec<f64> = seen
        .iter()
        .zip(&bent)
        .map(|(&count, &bent)| {
            let even = if count > 0.0 { EVENLY.0 / visited } else { 0.0 };
            let bends = if all_bent > 0.0 {
                (1.0 - EVENLY.0 - EVENLY.1) * bent / all_bent
            } else {
                0.0
            };
            even + EVENLY.1 * count / all + bends
        })
        .collect();
    Some(by_density(&edges, &density, count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_knots_are_spent_on_what_no_log_has_seen() {
        // Swings about hanging, and a body upright.
        let hanging = (0..1000).map(|k| 0.5 * (0.01 * f64::from(k)).sin());
        let upright = (0..1000).map(|k| 3.1 + 0.05 * (0.02 * f64::from(k)).cos());
        let samples: Vec<f64> = hanging.chain(upright).collect();
        let knots = fine_knots(&samples, LearnedCoordinate::Angle).expect("moves");
        assert!(knots.windows(2).all(|pair| pair[1] > pair[0]));
        let between = knots
            .iter()
            .filter(|knot| (0.6..2.95).contains(*knot))
            .count();
        assert!(between <= 2, "{knots:?}");
        assert_eq!(
            knots[0],
            samples.iter().copied().fold(f64::INFINITY, f64::min)
        );
    }

    #[test]
    fn a_coordinate_that_does_not_move_has_no_knots() {
        assert!(fine_knots(&[1.0; 1000], LearnedCoordinate::Rate).is_none());
    }
}
