//! Natural and periodic cubic splines through given values.
//!
//! A natural cubic spline is a sum Σ c_j B_j(s) of cubic B-splines without curvature at its ends. Of all curves
//! through given values it has the least ∫f″² (Reinsch, Numer. Math. 10 (1967)), so that the curve which a
//! penalty on ∫f″² asks for is one of these. It is described by its values at the knots, in which it is linear
//! (Green & Silverman, *Nonparametric Regression and Generalized Linear Models*, 1994, section 2.1).

use nalgebra::{DMatrix, DVector};

/// A cubic spline over fixed knots, linear in its values at them.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    knots: Vec<f64>,
    /// Length after which the curve repeats; `None` for a natural one, which is constant outside of its knots.
    period: Option<f64>,
    /// Second derivatives at the knots (rows) per value at a knot (columns), n×n.
    curvature: DMatrix<f64>,
    /// The matrix Q (n×n) of [`Spline::roughness`].
    roughness: DMatrix<f64>,
}

impl Spline {
    /// A spline over at least four increasing knots. If it is periodic, first and last knot are less than `period`
    /// apart. `None` for other knots.
    pub fn new(knots: &[f64], period: Option<f64>) -> Option<Spline> {
        let n = knots.len();
        let span = knots.last()? - knots.first()?;
        let increases = knots.windows(2).all(|pair| pair[1] > pair[0]);
        let is_usable = n >= 4
            && increases
            && knots.iter().all(|knot| knot.is_finite())
            && period.is_none_or(|period| period.is_finite() && span < period);
        if !is_usable {
            return None;
        }
        let intervals = match period {
            Some(_) => n,
            None => n - 1,
        };
        let width = |interval: usize| match period {
            Some(period) if interval == n - 1 => knots[0] + period - knots[n - 1],
            _ => knots[interval + 1] - knots[interval],
        };
        // Continuous slopes: for every inner knot i, h₋/6 m₋ + (h₋ + h₊)/3 m + h₊/6 m₊ = Δ₊/h₊ − Δ₋/h₋.
        let inner: Vec<usize> = match period {
            Some(_) => (0..n).collect(),
            None => (1..n - 1).collect(),
        };
        let mut band = DMatrix::zeros(inner.len(), inner.len());
        let mut differences = DMatrix::zeros(inner.len(), n);
        for (row, &knot) in inner.iter().enumerate() {
            let (before, after) = (width((knot + n - 1) % n), width(knot));
            let place = |knot: usize| inner.iter().position(|&inner| inner == knot);
            let neighbours = [
                ((knot + n - 1) % n, before / 6.0),
                (knot, (before + after) / 3.0),
                ((knot + 1) % n, after / 6.0),
            ];
            for (other, entry) in neighbours {
                if let Some(column) = place(other) {
                    band[(row, column)] += entry;
                }
            }
            differences[(row, (knot + n - 1) % n)] += 1.0 / before;
            differences[(row, knot)] -= 1.0 / before + 1.0 / after;
            differences[(row, (knot + 1) % n)] += 1.0 / after;
        }
        let of_inner = band.cholesky()?.solve(&differences);
        let mut curvature = DMatrix::zeros(n, n);
        for (row, &knot) in inner.iter().enumerate() {
            curvature.set_row(knot, &of_inner.row(row));
        }
        // f″ is linear between knots: ∫f″² = Σ h (m² + m m₊ + m₊²)/3.
        let mut gram = DMatrix::zeros(n, n);
        for interval in 0..intervals {
            let (from, to, h) = (interval, (interval + 1) % n, width(interval));
            gram[(from, from)] += h / 3.0;
            gram[(to, to)] += h / 3.0;
            gram[(from, to)] += h / 6.0;
            gram[(to, from)] += h / 6.0;
        }
        let roughness = curvature.transpose() * gram * &curvature;
        Some(Spline {
            knots: knots.to_vec(),
            period,
            curvature,
            roughness,
        })
    }

    /// The knots.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The matrix Q (n×n) with ∫f″² = vᵀ Q v for the values v at the knots.
    pub fn roughness(&self) -> &DMatrix<f64> {
        &self.roughness
    }

    /// Second derivatives at the knots.
    pub fn curvatures(&self, values: &[f64]) -> DVector<f64> {
        &self.curvature * DVector::from_column_slice(values)
    }

    /// Writes the weight of each knot's value in f(s) into `weights`, and in f′(s) into `slopes`.
    pub fn weights(&self, s: f64, weights: &mut [f64], slopes: &mut [f64]) {
        let n = self.knots.len();
        weights.fill(0.0);
        slopes.fill(0.0);
        let (first, last) = (self.knots[0], self.knots[n - 1]);
        let s = match self.period {
            Some(period) => first + (s - first).rem_euclid(period),
            None if s <= first => {
                weights[0] = 1.0;
                return;
            }
            None if s >= last => {
                weights[n - 1] = 1.0;
                return;
            }
            None => s,
        };
        let from = self.knots.partition_point(|knot| *knot <= s).max(1) - 1;
        let to = (from + 1) % n;
        let end = match self.period {
            Some(period) if from == n - 1 => first + period,
            _ => self.knots[to],
        };
        let h = end - self.knots[from];
        let (a, b) = ((end - s) / h, (s - self.knots[from]) / h);
        let (of_from, of_to) = ((a * a * a - a) * h * h / 6.0, (b * b * b - b) * h * h / 6.0);
        let (slope_from, slope_to) = (
            -(3.0 * a * a - 1.0) * h / 6.0,
            (3.0 * b * b - 1.0) * h / 6.0,
        );
        // Stored by columns: a column holds the effect of one value on the second derivative at every knot.
        for (column, (weight, slope)) in weights.iter_mut().zip(slopes.iter_mut()).enumerate() {
            let (m, m_next) = (self.curvature[(from, column)], self.curvature[(to, column)]);
            *weight = of_from * m + of_to * m_next;
            *slope = slope_from * m + slope_to * m_next;
        }
        weights[from] += a;
        weights[to] += b;
        slopes[from] -= 1.0 / h;
        slopes[to] += 1.0 / h;
    }

    /// f(s) of the curve with these values at the knots.
    pub fn value(&self, values: &[f64], s: f64) -> f64 {
        let n = self.knots.len();
        let (mut weights, mut slopes) = (vec![0.0; n], vec![0.0; n]);
        self.weights(s, &mut weights, &mut slopes);
        weights.iter().zip(values).map(|(w, v)| w * v).sum()
    }

    /// The largest |f′| at the knots.
    pub fn steepest(&self, values: &[f64]) -> f64 {
        let n = self.knots.len();
        let (mut weights, mut slopes) = (vec![0.0; n], vec![0.0; n]);
        let mut steepest = 0.0f64;
        for &knot in &self.knots {
            // Just inside of the knots: outside the curve is constant.
            let inside = knot.clamp(
                self.knots[0] + 1e-9 * (self.knots[1] - self.knots[0]),
                self.knots[n - 1] - 1e-9 * (self.knots[n - 1] - self.knots[n - 2]),
            );
            self.weights(inside, &mut weights, &mut slopes);
            let slope: f64 = slopes.iter().zip(values).map(|(w, v)| w * v).sum();
            steepest = steepest.max(slope.abs());
        }
        steepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOTS: [f64; 7] = [-1.0, -0.6, -0.1, 0.0, 0.3, 0.9, 1.4];

    fn values(f: impl Fn(f64) -> f64) -> Vec<f64> {
        KNOTS.iter().map(|&knot| f(knot)).collect()
    }

    #[test]
    fn a_straight_line_comes_out_exactly_and_is_not_rough() {
        let spline = Spline::new(&KNOTS, None).expect("usable");
        let line = values(|s| 2.0 - 3.0 * s);
        for k in 0..=48 {
            let s = -1.0 + 0.05 * f64::from(k);
            assert!(
                (spline.value(&line, s) - (2.0 - 3.0 * s)).abs() < 1e-12,
                "{s}"
            );
        }
        let v = DVector::from_vec(line);
        assert!((v.transpose() * spline.roughness() * &v)[0].abs() < 1e-12);
    }

    #[test]
    fn outside_of_its_knots_a_natural_spline_is_constant() {
        let spline = Spline::new(&KNOTS, None).expect("usable");
        let v = values(|s| s.sin());
        assert_eq!(spline.value(&v, -5.0), v[0]);
        assert_eq!(spline.value(&v, 5.0), v[6]);
    }

    #[test]
    fn values_and_slopes_agree_with_numerical_ones() {
        let spline = Spline::new(&KNOTS, None).expect("usable");
        let v = values(|s| (2.0 * s).sin());
        let (mut weights, mut slopes) = ([0.0; 7], [0.0; 7]);
        for s in [-0.93, -0.35, -0.02, 0.15, 0.7, 1.1] {
            spline.weights(s, &mut weights, &mut slopes);
            let slope: f64 = slopes.iter().zip(&v).map(|(w, v)| w * v).sum();
            let h = 1e-5;
            let numeric = (spline.value(&v, s + h) - spline.value(&v, s - h)) / (2.0 * h);
            assert!((slope - numeric).abs() < 1e-8, "{s} {slope} {numeric}");
        }
    }

    /// ∫f″² of the form against the integral of the second difference.
    #[test]
    fn the_roughness_is_the_integral_of_the_squared_curvature() {
        for period in [None, Some(3.0)] {
            let spline = Spline::new(&KNOTS, period).expect("usable");
            let v = values(|s| (2.0 * s).sin());
            let (steps, h) = (60_000, 1e-4);
            let span = period.unwrap_or(2.4);
            let mut integral = 0.0;
            for k in 0..steps {
                let s = -1.0 + span * (k as f64 + 0.5) / steps as f64;
                if period.is_none() && (s + 1.0 < h || 1.4 - s < h) {
                    continue;
                }
                let second =
                    spline.value(&v, s + h) - 2.0 * spline.value(&v, s) + spline.value(&v, s - h);
                integral += (second / (h * h)).powi(2) * span / steps as f64;
            }
            let v = DVector::from_vec(v);
            let form = (v.transpose() * spline.roughness() * &v)[0];
            assert!((integral / form - 1.0).abs() < 1e-3, "{integral} {form}");
        }
    }

    #[test]
    fn a_periodic_spline_repeats_with_its_slope() {
        let spline = Spline::new(&KNOTS, Some(3.0)).expect("usable");
        let v = values(|s| s * s);
        assert!((spline.value(&v, -0.3) - spline.value(&v, 5.7)).abs() < 1e-12);
        let (mut weights, mut before, mut after) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        spline.weights(2.0 - 1e-9, &mut weights, &mut before);
        spline.weights(2.0 + 1e-9, &mut weights, &mut after);
        let slope = |s: &[f64]| -> f64 { s.iter().zip(&v).map(|(w, v)| w * v).sum() };
        assert!((slope(&before) - slope(&after)).abs() < 1e-6);
    }

    #[test]
    fn knots_of_which_no_curve_can_be_made_are_refused() {
        assert!(Spline::new(&[0.0, 1.0, 2.0], None).is_none());
        assert!(Spline::new(&[0.0, 1.0, 1.0, 2.0], None).is_none());
        assert!(Spline::new(&[0.0, 1.0, f64::NAN, 2.0], None).is_none());
        assert!(Spline::new(&[0.0, 1.0, 2.0, 3.0], Some(3.0)).is_none());
    }
}
