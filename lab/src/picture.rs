//! Curves reduced to the pixels of a screen.

/// A curve: times in s, and the values there. A gap is a value that is NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Times.
    pub time_s: Vec<f64>,
    /// Values.
    pub value: Vec<f64>,
}

/// The part of a curve that a screen shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Left edge, s.
    pub from_s: f64,
    /// Right edge, s.
    pub to_s: f64,
    /// Width of the screen.
    pub pixels: usize,
}

/// The smallest and the largest value of every pixel with their times, and the sample on either side of the
/// view. Nothing visible on a screen of that width is lost: a line through these points covers the same
/// pixels as one through all samples. Gaps stay gaps.
pub fn thinned(time_s: &[f64], value: &[f64], view: &View) -> Curve {
    let count = time_s.len().min(value.len());
    let time_s = &time_s[..count];
    let first = time_s.partition_point(|&t| t < view.from_s);
    let last = time_s.partition_point(|&t| t <= view.to_s);
    let (first, last) = (first.saturating_sub(1), (last + 1).min(count));
    let mut curve = Curve::default();
    let mut put = |index: usize| {
        curve.time_s.push(time_s[index]);
        curve.value.push(value[index]);
    };
    if last.saturating_sub(first) <= 2 * view.pixels {
        (first..last).for_each(put);
        return curve;
    }
    let width = view.to_s - view.from_s;
    let pixel = |index: usize| {
        let share = (time_s[index] - view.from_s) / width;
        // Samples left of the view get −1, samples right of it the last pixel but one.
        (share * view.pixels as f64).floor() as i64
    };
    let mut index = first;
    while index < last {
        let here = pixel(index);
        let mut end = index;
        let (mut least, mut largest, mut gap) = (None, None, None);
        while end < last && pixel(end) == here {
            if value[end].is_nan() {
                gap = Some(end);
            } else {
                if least.is_none_or(|at: usize| value[end] < value[at]) {
                    least = Some(end);
                }
                if largest.is_none_or(|at: usize| value[end] > value[at]) {
                    largest = Some(end);
                }
            }
            end += 1;
        }
        let mut kept: Vec<usize> = [least, largest, gap].into_iter().flatten().collect();
        kept.sort_unstable();
        kept.dedup();
        kept.into_iter().for_each(&mut put);
        index = end;
    }
    curve
}

/// A run of lost samples: the times in s of the samples on either side, and how many are lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lost {
    /// The last sample before; the first lost one where there is none before.
    pub from_s: f64,
    /// The first sample after; the last lost one where there is none after.
    pub to_s: f64,
    /// Number of lost samples.
    pub count: usize,
}

/// The runs of lost samples (NaN) of a channel.
pub fn lost(time_s: &[f64], value: &[f64]) -> Vec<Lost> {
    let count = time_s.len().min(value.len());
    let mut found = Vec::new();
    let mut index = 0;
    while index < count {
        let end = (index..count)
            .find(|k| !value[*k].is_nan())
            .unwrap_or(count);
        if end > index {
            found.push(Lost {
                from_s: time_s[index.saturating_sub(1)],
                to_s: time_s[end.min(count - 1)],
                count: end - index,
            });
        }
        index = end + 1;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lost_samples_lie_between_those_that_were_kept() {
        let nan = f64::NAN;
        let time = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let found = lost(&time, &[nan, 1.0, nan, nan, 2.0, 3.0, nan]);
        let runs: Vec<_> = found
            .iter()
            .map(|run| (run.from_s, run.to_s, run.count))
            .collect();
        assert_eq!(runs, [(0.0, 1.0, 1), (1.0, 4.0, 2), (5.0, 6.0, 1)]);
        assert_eq!(lost(&time, &[1.0; 7]), []);
    }

    fn samples(count: usize, value: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<f64>) {
        let times = (0..count).map(|k| k as f64 * 1e-3).collect();
        (times, (0..count).map(value).collect())
    }

    /// Each pixel keeps the extremes of its samples, has at most three points, and the times increase.
    #[test]
    fn extremes_of_every_pixel_are_kept() {
        let (time, value) = samples(100_000, |k| {
            ((k * k) as f64 * 1e-3).sin() * (k % 977) as f64
        });
        let view = View {
            from_s: 20.0,
            to_s: 70.0,
            pixels: 500,
        };
        let curve = thinned(&time, &value, &view);
        assert!(
            curve.time_s.len() <= 2 * view.pixels + 4,
            "{}",
            curve.time_s.len()
        );
        assert!(curve.time_s.is_sorted());
        let extremes = |time: &[f64], value: &[f64], pixel: usize| {
            let inside = time
                .iter()
                .zip(value)
                .filter(|(t, _)| ((**t - 20.0) / 50.0 * 500.0).floor() as i64 == pixel as i64);
            inside.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (_, v)| {
                (a.min(*v), b.max(*v))
            })
        };
        for pixel in 0..500 {
            assert_eq!(
                extremes(&curve.time_s, &curve.value, pixel),
                extremes(&time, &value, pixel)
            );
        }
        // The line goes on to both edges.
        assert!(curve.time_s[0] < 20.0 && curve.time_s[curve.time_s.len() - 1] > 70.0);
    }

    #[test]
    fn a_single_peak_and_a_gap_survive() {
        let (time, value) = samples(100_000, |k| match k {
            54_321 => 1.0,
            70_000..70_300 => f64::NAN,
            _ => 0.0,
        });
        let view = View {
            from_s: 0.0,
            to_s: 100.0,
            pixels: 300,
        };
        let curve = thinned(&time, &value, &view);
        assert!(curve.value.contains(&1.0));
        assert!(curve.value.iter().any(|v| v.is_nan()));
    }

    #[test]
    fn few_samples_are_sent_as_they_are() {
        let (time, value) = samples(50, |k| k as f64);
        let view = View {
            from_s: 0.01,
            to_s: 0.02,
            pixels: 100,
        };
        let curve = thinned(&time, &value, &view);
        assert_eq!(curve.value.first(), Some(&9.0));
        assert_eq!(curve.value.last(), Some(&21.0));
    }
}
