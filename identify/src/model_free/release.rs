//! The rows of a free swing from before its release: the log begins while a hand still holds the body.
//!
//! Without a motor, a body near a turning point moves in the same way before and after it: to first order in friction,
//! α(t − s) = α(t + s), and the rate has the opposite sign. A held body stands still instead. The time of the release
//! follows from the swing behind it: from rest, the first passage of the middle comes half the time later that lies between
//! the first two passages. The rows before that time are then compared with the mirrored rows after it: their slope β
//! against these is 1 for a body that swings, and 0 for one that is held. Nothing of a model is needed but that.

use plant::{Kind, Output};

use super::decay::agm;
use crate::records::{Record, median};

/// The beginning of a free swing during which the body was held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldStart {
    /// Number of rows before the release.
    pub rows: usize,
    /// Time from the first row to the release, s.
    pub held_s: f64,
    /// Time of the first row after the release, s.
    pub from_s: f64,
    /// Period of the swing, s.
    pub period_s: f64,
}

/// Distance from the middle within which a passage is not yet certain, in standard deviations of the noise (noise goes
/// beyond four of them once in 16,000 rows), and as a share of half the range (judgement: a tenth).
const CLEAR: f64 = 4.0;
/// See [`CLEAR`].
const CLEAR_SHARE: f64 = 0.1;
/// Share of half the range above which noise hides the passages.
const TOO_WIDE: f64 = 0.3;
/// Share of the amplitude about the middle in which the motion is a straight line: a sine differs from it there by 1.5 %.
const STRAIGHT: f64 = 0.3;
/// Largest slope β of a body that is held: nearer to 0 than to 1.
const HELD: f64 = 0.5;
/// Standard errors by which β must differ from 1, as for every finding that may be chance.
const STANDARD_ERRORS: f64 = 6.0;
/// Shortest hold that is told from an error of the release's time, as a share of the period: what is left out of the motion
/// (the change of the amplitude from one half of a swing to the next, a spring, dry friction) moves the passages by less.
const LEAST_SHARE: f64 = 0.03;
/// Fewest rows before the release for a slope.
const FEWEST_ROWS: usize = 3;

/// The rows before the release of a free swing; `None` if the body swings from the first row, or if that cannot be told.
pub fn held_start(record: &Record) -> Option<HeldStart> {
    if record.kind != Kind::FreeSwing {
        return None;
    }
    let output = [Output::Angle, Output::Rate]
        .into_iter()
        .find(|&output| record.channel(output).is_some())?;
    let channel = record.channel(output)?;
    let points: Vec<(f64, f64)> = record
        .time_s
        .iter()
        .copied()
        .zip(channel.samples.iter().copied())
        .filter(|(_, value)| value.is_finite())
        .collect();
    let swing = Swing::of(&points, channel.noise_std)?;
    let release_s = match output {
        Output::Angle => {
            // The period grows with the amplitude, which is largest at the release.
            let small = |amplitude_rad: f64| agm(1.0, (0.5 * amplitude_rad.min(3.0)).cos());
            let [first, second] = swing.amplitudes;
            swing.passages_s[0] - 0.5 * swing.half_s() * small(second) / small(first)
        }
        // The rate passes zero half a swing after the release.
        _ => swing.passages_s[0] - swing.half_s(),
    };
    let held_s = release_s - points.first()?.0;
    let period_s = 2.0 * swing.half_s();
    if held_s < LEAST_SHARE * period_s {
        return None;
    }
    let is_even = output == Output::Angle;
    let (slope, std) = swing.slope_before(&points, release_s, is_even)?;
    if slope > HELD || 1.0 - slope < STANDARD_ERRORS * std {
        return None;
    }
    let rows = record.time_s.partition_point(|&time| time < release_s);
    Some(HeldStart {
        rows,
        held_s,
        from_s: *record.time_s.get(rows)?,
        period_s,
    })
}

/// The first one and a half swings of a channel about its middle.
struct Swing {
    middle: f64,
    /// Distances of the first two turning points from the middle.
    amplitudes: [f64; 2],
    /// The first two passages of the middle, s.
    passages_s: [f64; 2],
    noise_std: f64,
}

impl Swing {
    /// `None` where no swing can be seen.
    fn of(points: &[(f64, f64)], noise_std: f64) -> Option<Swing> {
        let values = || points.iter().map(|(_, value)| *value);
        // Late in the log, the swing is small, so that the median is near the middle.
        let about = median(values())?;
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let half_range = 0.5 * (high - low);
        let clear = (CLEAR * noise_std).max(CLEAR_SHARE * half_range);
        if clear > TOO_WIDE * half_range {
            return None;
        }
        // The farthest point of each stretch on one side of the middle.
        let mut farthest: Vec<usize> = vec![];
        let mut side = 0.0;
        for (k, (_, value)) in points.iter().enumerate() {
            let off = value - about;
            if off.abs() <= clear {
                continue;
            }
            if off.signum() != side {
                if farthest.len() == 3 {
                    break;
                }
                side = off.signum();
                farthest.push(k);
            } else if let Some(last) = farthest.last_mut()
                && off.abs() > (points[*last].1 - about).abs()
            {
                *last = k;
            }
        }
        let &[first, second, third] = farthest.as_slice() else {
            return None;
        };
        let at = |k: usize| points[k].1;
        // Of three turning points of a decaying swing, this mean lies in the middle.
        let middle = 0.25 * (at(first) + 2.0 * at(second) + at(third));
        let amplitudes = [first, second].map(|k| (at(k) - middle).abs());
        let smallest = amplitudes[0].min(amplitudes[1]);
        let passage =
            |from: usize, to: usize| passage_s(&points[from..=to], middle, STRAIGHT * smallest);
        let passages_s = [passage(first, second)?, passage(second, third)?];
        let swing = Swing {
            middle,
            amplitudes,
            passages_s,
            noise_std,
        };
        (swing.half_s() > 0.0).then_some(swing)
    }

    /// Time between the first two passages of the middle, s.
    fn half_s(&self) -> f64 {
        self.passages_s[1] - self.passages_s[0]
    }

    /// The slope of the rows before the release against the mirrored rows after it, and its standard error. Rows more than
    /// a quarter of a period before the release are not compared. `None` if there are too few, or if the mirrored rows
    /// hardly move.
    fn slope_before(
        &self,
        points: &[(f64, f64)],
        release_s: f64,
        is_even: bool,
    ) -> Option<(f64, f64)> {
        let pairs: Vec<(f64, f64)> = points
            .iter()
            .take_while(|(time_s, _)| *time_s < release_s)
            .filter(|(time_s, _)| release_s - time_s <= 0.5 * self.half_s())
            .filter_map(|&(time_s, value)| {
                let after = at(points, 2.0 * release_s - time_s)?;
                let mirrored = if is_even {
                    after
                } else {
                    2.0 * self.middle - after
                };
                Some((mirrored, value))
            })
            .collect();
        let n = pairs.len() as f64;
        if pairs.len() < FEWEST_ROWS {
            return None;
        }
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
        let (mean_x, mean_y) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let sum = |of: &dyn Fn(f64, f64) -> f64| {
            let each = pairs.iter().map(|(x, y)| of(x - mean_x, y - mean_y));
            each.sum::<f64>()
        };
        let (xx, xy, yy) = (sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y));
        // The mirrored rows have noise, too; it does not belong to their motion.
        let moves = xx - n * self.noise_std.powi(2);
        if moves <= 0.5 * xx {
            return None;
        }
        let slope = xy / moves;
        let scatter = ((yy - slope * xy).max(0.0) / (n - 2.0)).sqrt();
        let error = scatter.max(2f64.sqrt() * self.noise_std);
        Some((slope, error / moves.sqrt()))
    }
}

/// The time at which a straight line through the points within `width` of the middle passes it; the line between the two
/// points beside the passage where there are fewer than three.
fn passage_s(points: &[(f64, f64)], middle: f64, width: f64) -> Option<f64> {
    let near: Vec<(f64, f64)> = points
        .iter()
        .filter(|(_, value)| (value - middle).abs() < width)
        .map(|(time_s, value)| (*time_s, value - middle))
        .collect();
    if near.len() >= 3 {
        let line = crate::records::StraightLine::through(near.iter().copied());
        return (line.slope != 0.0).then(|| line.mean_t - line.mean / line.slope);
    }
    points.windows(2).find_map(|pair| {
        let [(t0, x0), (t1, x1)] = [pair[0], pair[1]];
        let (x0, x1) = (x0 - middle, x1 - middle);
        (x0 * x1 <= 0.0 && x0 != x1).then(|| t0 + (t1 - t0) * x0 / (x0 - x1))
    })
}

/// The value at a time, along straight lines between the points; `None` outside of them.
fn at(points: &[(f64, f64)], time_s: f64) -> Option<f64> {
    let next = points.partition_point(|(time, _)| *time < time_s);
    let (&(t0, x0), &(t1, x1)) = (points.get(next.checked_sub(1)?)?, points.get(next)?);
    Some(x0 + (x1 - x0) * (time_s - t0) / (t1 - t0))
}
