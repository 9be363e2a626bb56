//! Small statistics of samples.

/// The median of the finite values (for an even number, the upper of the two middle ones); `None` if there is none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut finite: Vec<f64> = values
        .into_iter()
        .filter(|value| value.is_finite())
        .collect();
    if finite.is_empty() {
        return None;
    }
    let middle = finite.len() / 2;
    Some(*finite.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// A straight line fitted to points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StraightLine {
    /// Mean of the abscissas.
    pub(crate) mean_t: f64,
    /// Value of the line at the mean abscissa.
    pub(crate) mean: f64,
    /// Slope of the line; 0 if all points have the same abscissa.
    pub(crate) slope: f64,
}

impl StraightLine {
    /// The least-squares line; zero if there are no points.
    pub(crate) fn through(
        points: impl ExactSizeIterator<Item = (f64, f64)> + Clone,
    ) -> StraightLine {
        let n = points.len().max(1) as f64;
        let (mean_t, mean) = points.clone().fold((0.0, 0.0), |sum, point| {
            (sum.0 + point.0 / n, sum.1 + point.1 / n)
        });
        let (mut tt, mut ty) = (0.0, 0.0);
        for (t, y) in points {
            tt += (t - mean_t) * (t - mean_t);
            ty += (t - mean_t) * (y - mean);
        }
        StraightLine {
            mean_t,
            mean,
            slope: if tt > 0.0 { ty / tt } else { 0.0 },
        }
    }

    /// Value of the line at `t`.
    pub(crate) fn at(&self, t: f64) -> f64 {
        self.mean + self.slope * (t - self.mean_t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_through_points_of_a_line_is_that_line() {
        let points = [0.0, 0.5, 2.0, 3.5].map(|t| (t, 3.0 - 0.25 * t));
        let line = StraightLine::through(points.into_iter());
        assert!((line.slope + 0.25).abs() < 1e-15);
        assert!((line.at(10.0) - 0.5).abs() < 1e-14);
        let one = StraightLine::through([(2.0, 7.0)].into_iter());
        assert_eq!((one.slope, one.at(5.0)), (0.0, 7.0));
    }

    #[test]
    fn a_median_does_not_see_gaps() {
        assert_eq!(median([3.0, f64::NAN, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0, 1.0]), Some(4.0));
        assert_eq!(median([f64::NAN]), None);
    }
}
