//! Drop-outs: samples that were lost between sensor and log.
//!
//! A lost sample shows as a value that appears for a moment: a zero, a stuck
//! number, a spike. Angle, rate and wheel speed are integrals of bounded torques. The motion
//! itself therefore cannot change and return between neighbouring samples by many times its usual
//! variation. A run of up to [`LONGEST_DROP_OUT`] samples is a drop-out if all of these hold:
//!
//! 1. **It leaves.** Every sample of the run differs by more than [`DEVIATIONS`] s, all in the same direction, from two
//!    references: from the cubic through two good samples on either side, and from every value
//!    between the nearest two. s is the largest of three
//!    scales of normal variation: the robust standard deviation (1.4826 × median absolute value,
//!    Hampel's identifier) of this difference over the whole log, the same over the samples
//!    nearby (fast motion), and the resolution of the column (the lower decile of its nonzero
//!    steps).
//! 2. **It comes back.** The two good neighbours differ from each other by less than half of that
//!    difference. Without this condition, the kink at which a wheel starts to turn would count.
//! 3. **It looks like a lost sample.** The run is at zero (within s), or it is one constant
//!    number while the samples around it vary, or it lies outside the range of the rest of the log by more
//!    than [`DEVIATIONS`] s.
//!
//! With Gaussian noise, a false alarm needs 8 standard deviations, 1 in 10¹⁵. The first and the
//! last two samples are not tested. Source of the identifier: F. R. Hampel, "The influence curve
//! and its role in robust estimation", J. Am. Stat. Assoc. 69 (1974); the conditions are our own.

/// Longest run of lost samples that is recognised as a drop-out.
pub const LONGEST_DROP_OUT: usize = 3;
/// Distance of a lost sample from normal values, in robust standard deviations.
const DEVIATIONS: f64 = 8.0;
/// 1 / Φ⁻¹(3/4): converts the median absolute value of Gaussian noise to its standard deviation.
const MEDIAN_TO_DEVIATION: f64 = 1.4826;
/// Number of samples on either side that count as nearby.
const NEARBY: usize = 12;

/// Indices of the lost samples, in rising order. `values` is the column of one sensor in SI units, finite;
/// `time_s` has the same length and is strictly increasing.
pub fn drop_outs(time_s: &[f64], values: &[f64]) -> Vec<usize> {
    let n = values.len().min(time_s.len());
    if n < 5 {
        return Vec::new();
    }
    let differences = differences(time_s, values);
    let global = deviation(differences[2..n - 2].iter().copied());
    let floor = global.max(resolution(values));
    // If nothing varies, there is no scale for the test, and no drop-out.
    if floor <= 0.0 {
        return Vec::new();
    }

    let mut lost = vec![false; n];
    // The largest differences come first: a lost sample disturbs the differences of its neighbours.
    let mut candidates: Vec<usize> = (2..n - 2)
        .filter(|&i| differences[i].abs() > DEVIATIONS * floor)
        .collect();
    candidates.sort_by(|&a, &b| differences[b].abs().total_cmp(&differences[a].abs()));
    let (low, high) = inner_range(values, &candidates);
    for &i in &candidates {
        if lost[i] {
            continue;
        }
        // The shortest run with sample i that passes the test; i can be any sample of the run.
        let run = (1..=LONGEST_DROP_OUT)
            .flat_map(|length| (0..length).map(move |back| (length, back)))
            .filter_map(|(length, back)| {
                let start = i.checked_sub(back)?;
                let run = start..start + length;
                (start >= 2 && run.end + 2 <= n).then_some(run)
            })
            .find(|run| {
                let test = RunTest {
                    time_s,
                    values,
                    lost: &lost,
                    differences: &differences,
                    floor,
                    range: (low, high),
                };
                test.is_drop_out(run.clone())
            });
        if let Some(run) = run {
            for j in run {
                lost[j] = true;
            }
        }
    }
    (0..n).filter(|&i| lost[i]).collect()
}

/// The data for the test of a run of samples.
struct RunTest<'a> {
    time_s: &'a [f64],
    values: &'a [f64],
    lost: &'a [bool],
    differences: &'a [f64],
    floor: f64,
    range: (f64, f64),
}

impl RunTest<'_> {
    fn is_drop_out(&self, run: std::ops::Range<usize>) -> bool {
        if run.clone().any(|j| self.lost[j]) {
            return false;
        }
        let good = |j: &usize| !self.lost[*j];
        let before: Vec<usize> = (0..run.start).rev().filter(good).take(2).collect();
        let after: Vec<usize> = (run.end..self.values.len()).filter(good).take(2).collect();
        let (&[b1, b2], &[a1, a2]) = (&before[..], &after[..]) else {
            return false;
        };
        let support = [b2, b1, a1, a2];
        let low = self.values[b1].min(self.values[a1]);
        let high = self.values[b1].max(self.values[a1]);
        // The smaller of two differences: from the cubic, which follows the motion but overshoots
        // near a kink, and from the range between the neighbours, which does not overshoot.
        let leaves: Vec<f64> = run
            .clone()
            .map(|j| {
                let value = self.values[j];
                let from_cubic = value - self.cubic(support, self.time_s[j]);
                let from_neighbours = value - value.clamp(low, high);
                if from_cubic * from_neighbours <= 0.0 {
                    0.0
                } else if from_cubic.abs() < from_neighbours.abs() {
                    from_cubic
                } else {
                    from_neighbours
                }
            })
            .collect();

        // Condition 1: it leaves.
        let scale = self.scale(&run);
        let smallest = leaves.iter().fold(f64::INFINITY, |m, d| m.min(d.abs()));
        let one_side = leaves.iter().all(|d| *d > 0.0) || leaves.iter().all(|d| *d < 0.0);
        if !one_side || smallest <= DEVIATIONS * scale {
            return false;
        }
        // Condition 2: it comes back.
        if (self.values[a1] - self.values[b1]).abs() >= 0.5 * smallest {
            return false;
        }
        // Condition 3: it looks like a lost sample.
        let samples = &self.values[run.clone()];
        let at_zero = samples.iter().all(|value| value.abs() <= scale);
        let stuck = samples.len() > 1
            && samples.iter().all(|value| *value == samples[0])
            && self.values[a1] != self.values[a2]
            && self.values[b1] != self.values[b2];
        let (low, high) = self.range;
        let outside = samples
            .iter()
            .all(|value| *value > high + DEVIATIONS * scale || *value < low - DEVIATIONS * scale);
        at_zero || stuck || outside
    }

    /// The cubic through four samples, at time `t` (Lagrange).
    fn cubic(&self, support: [usize; 4], t: f64) -> f64 {
        support
            .iter()
            .map(|&j| {
                let weight: f64 = support
                    .iter()
                    .filter(|&&k| k != j)
                    .map(|&k| (t - self.time_s[k]) / (self.time_s[j] - self.time_s[k]))
                    .product();
                weight * self.values[j]
            })
            .sum()
    }

    /// The scale of normal variation here: the lower limit, or the deviation over those nearby samples whose cubic does
    /// not use the run.
    fn scale(&self, run: &std::ops::Range<usize>) -> f64 {
        let n = self.values.len();
        let from = run.start.saturating_sub(NEARBY).max(2);
        let to = (run.end + NEARBY).min(n - 2);
        let nearby = (from..to)
            .filter(|&j| j + 2 < run.start || j >= run.end + 2)
            .filter(|&j| (j - 2..=j + 2).all(|k| !self.lost[k]))
            .map(|j| self.differences[j]);
        self.floor.max(deviation(nearby))
    }
}

/// Difference of each sample from the cubic through two samples on either side; 0 at the ends.
fn differences(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let none = vec![false; n];
    let test = RunTest {
        time_s,
        values,
        lost: &none,
        differences: &[],
        floor: 0.0,
        range: (0.0, 0.0),
    };
    (0..n)
        .map(|i| {
            if i < 2 || i + 2 >= n {
                0.0
            } else {
                values[i] - test.cubic([i - 2, i - 1, i + 1, i + 2], time_s[i])
            }
        })
        .collect()
}

/// Robust standard deviation about zero.
fn deviation(differences: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = differences.map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    MEDIAN_TO_DEVIATION * *median
}

/// The lower decile of the nonzero steps: one count of a quantised column.
fn resolution(values: &[f64]) -> f64 {
    let mut steps: Vec<f64> = values
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .filter(|step| *step > 0.0)
        .collect();
    if steps.is_empty() {
        return 0.0;
    }
    let tenth = steps.len() / 10;
    *steps.select_nth_unstable_by(tenth, f64::total_cmp).1
}

/// Range of the samples that are not candidates.
fn inner_range(values: &[f64], candidates: &[usize]) -> (f64, f64) {
    let mut skip = vec![false; values.len()];
    for &i in candidates {
        skip[i] = true;
    }
    values
        .iter()
        .zip(skip)
        .filter(|(_, skip)| !skip)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (v, _)| {
            (low.min(*v), high.max(*v))
        })
}
