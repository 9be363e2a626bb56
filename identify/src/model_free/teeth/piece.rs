//! A quarter of a second of a log, projected on teeth of a given order.

use std::f64::consts::TAU;
use std::ops::Range;

use super::WheelLog;

/// Highest order that is looked for.
pub(super) const HIGHEST_ORDER: usize = 60;
/// Smallest number of samples in a piece: three times the unknowns of its projection.
const FEWEST_SAMPLES: usize = 24;
/// Teeth that must pass in a piece for its projection to differ from a parabola.
const FEWEST_TEETH: f64 = 1.5;
/// Largest advance of the ripple's phase from sample to sample, rad. Beyond half a turn it is taken for a slower one.
const LARGEST_ADVANCE_RAD: f64 = 2.0;
/// Share of its path by which a wheel must get ahead. One that turns back meets the step of dry friction, which is no
/// parabola.
const AHEAD: f64 = 0.9;
/// Number of parts of a piece by which its path is measured; noise averages out over each.
const PATH_PARTS: usize = 12;
/// Share of its length that a term must keep beside those before it to be told from them.
const TOLD_APART: f64 = 1e-4;
/// As [`TOLD_APART`], for cosine and sine, squared.
const TOLD_APART_SQUARED: f64 = 1e-6;
/// Turn of the phase from sample to sample, rad, below which its antiderivative is lost in rounding.
const AT_REST_RAD: f64 = 1e-6;

/// A piece of a log, with what a parabola and the charge explain taken out of its speed.
pub(super) struct Piece {
    log: usize,
    centre_s: f64,
    time_s: Vec<f64>,
    angle_rad: Vec<f64>,
    /// What is left of the speed, rad/s.
    left: Vec<f64>,
    /// Orthonormal: what was taken out.
    basis: Vec<Vec<f64>>,
    turned_rad: f64,
    /// The largest turn of the wheel from sample to sample, rad.
    advance_rad: f64,
    noise_std: f64,
    walk: f64,
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(x, y)| x * y).sum()
}

/// Takes the part along each of the orthonormal `basis` out of `series`.
fn project_out(basis: &[Vec<f64>], series: &mut [f64]) {
    for one in basis {
        let along = dot(one, series);
        for (value, unit) in series.iter_mut().zip(one) {
            *value -= along * unit;
        }
    }
}

impl Piece {
    /// `None` where the piece has too few samples or gaps, or where its wheel turns back or rests.
    pub(super) fn of(log: &WheelLog, index: usize, samples: Range<usize>) -> Option<Piece> {
        let n = samples.len();
        let is_whole = log.speed_rad_s[samples.clone()]
            .iter()
            .all(|speed| speed.is_finite());
        if n < FEWEST_SAMPLES || !is_whole {
            return None;
        }
        let time_s = log.time_s[samples.clone()].to_vec();
        let angle_rad = log.angle_rad[samples.clone()].to_vec();
        let turned_rad = (angle_rad[n - 1] - angle_rad[0]).abs();
        let part = (n / PATH_PARTS).max(1);
        let coarse: Vec<f64> = angle_rad.iter().copied().step_by(part).collect();
        let steps = coarse.windows(2).map(|two| (two[1] - two[0]).abs());
        let path: f64 = steps.clone().sum();
        let ahead = (coarse[coarse.len() - 1] - coarse[0]).abs();
        if ahead < AHEAD * path || turned_rad * HIGHEST_ORDER as f64 <= FEWEST_TEETH * TAU {
            return None;
        }
        let advance_rad = steps.fold(0.0, f64::max) / part as f64;
        let charge = log.charge.as_ref().map(|charge| &charge[samples.clone()]);
        let basis = smooth_terms(&time_s, charge);
        let mut left = log.speed_rad_s[samples].to_vec();
        project_out(&basis, &mut left);
        Some(Piece {
            log: index,
            centre_s: 0.5 * (time_s[0] + time_s[n - 1]),
            time_s,
            angle_rad,
            left,
            basis,
            turned_rad,
            advance_rad,
            noise_std: log.noise_std,
            walk: log.walk,
        })
    }

    /// Whether teeth of this order can be counted here. `alone` asks that no other order can be taken for it.
    fn counts(&self, order: f64, alone: bool) -> bool {
        let highest = HIGHEST_ORDER as f64 * self.advance_rad;
        order * self.turned_rad >= FEWEST_TEETH * TAU
            && order * self.advance_rad <= LARGEST_ADVANCE_RAD
            && (!alone || highest <= TAU - LARGEST_ADVANCE_RAD)
    }

    /// The projection on teeth of order `n`; `None` if they cannot be counted here.
    pub(super) fn projected(&self, n: f64, alone: bool) -> Option<Projected> {
        if !self.counts(n, alone) {
            return None;
        }
        let (mut cosine, mut sine) = self.integrals(n);
        project_out(&self.basis, &mut cosine);
        project_out(&self.basis, &mut sine);
        let (cc, cs, ss) = (
            dot(&cosine, &cosine),
            dot(&cosine, &sine),
            dot(&sine, &sine),
        );
        let (ce, se) = (dot(&cosine, &self.left), dot(&sine, &self.left));
        let determinant = cc * ss - cs * cs;
        if determinant <= TOLD_APART_SQUARED * cc * ss {
            return None;
        }
        let gain = (ss * ce * ce - 2.0 * cs * ce * se + cc * se * se) / determinant;
        let freedom = (self.left.len() - self.basis.len() - 2) as f64;
        let left = (dot(&self.left, &self.left) - gain) / freedom;
        // A misfit of another shape is noise to the teeth.
        let variance = left.max(self.noise_std * self.noise_std);
        Some(Projected {
            log: self.log,
            centre_s: self.centre_s,
            walk: self.walk * n * n,
            information: [cc / variance, cs / variance, ss / variance],
            towards: [ce / variance, se / variance],
            gain: gain / variance,
        })
    }

    /// ∫cos nφ dt and ∫sin nφ dt from the first sample to every one. The wheel is taken to turn evenly between samples.
    fn integrals(&self, n: f64) -> (Vec<f64>, Vec<f64>) {
        let count = self.left.len();
        let (mut cosine, mut sine) = (vec![0.0; count], vec![0.0; count]);
        let mut before = (n * self.angle_rad[0]).sin_cos();
        for k in 1..count {
            let step_s = self.time_s[k] - self.time_s[k - 1];
            let turned = n * (self.angle_rad[k] - self.angle_rad[k - 1]);
            let now = (n * self.angle_rad[k]).sin_cos();
            let (cos, sin) = if turned.abs() > AT_REST_RAD {
                ((now.0 - before.0) / turned, (before.1 - now.1) / turned)
            } else {
                (now.1, now.0)
            };
            cosine[k] = cosine[k - 1] + cos * step_s;
            sine[k] = sine[k - 1] + sin * step_s;
            before = now;
        }
        (cosine, sine)
    }
}

/// A parabola over time and the charge, as orthonormal series; without the charge where it is a parabola itself.
fn smooth_terms(time_s: &[f64], charge: Option<&[f64]>) -> Vec<Vec<f64>> {
    let n = time_s.len();
    let span_s = time_s[n - 1] - time_s[0];
    let place = |time: &f64| 2.0 * (time - time_s[0]) / span_s - 1.0;
    let line: Vec<f64> = time_s.iter().map(place).collect();
    let square = line.iter().map(|s| s * s).collect();
    let mut terms = vec![vec![1.0; n], line, square];
    terms.extend(charge.map(<[f64]>::to_vec));
    let mut basis: Vec<Vec<f64>> = vec![];
    for mut term in terms {
        if !basis.is_empty() {
            // The charge may have grown far before the piece begins.
            let mean = term.iter().sum::<f64>() / n as f64;
            term.iter_mut().for_each(|value| *value -= mean);
        }
        let before = dot(&term, &term).sqrt();
        // Twice, against rounding.
        project_out(&basis, &mut term);
        project_out(&basis, &mut term);
        let length = dot(&term, &term).sqrt();
        if length > TOLD_APART * before {
            term.iter_mut().for_each(|value| *value /= length);
            basis.push(term);
        }
    }
    basis
}

/// The projection of a piece on teeth of one order, in units of its noise. Teeth of amplitude a over the inertia and of
/// phase ψ have the coordinates (−a sin ψ, −a cos ψ).
pub(super) struct Projected {
    /// Index of the log.
    pub(super) log: usize,
    /// The middle of the piece, s.
    pub(super) centre_s: f64,
    /// Variance per second of the walk of the phase, rad²/s.
    pub(super) walk: f64,
    /// Information about the coordinates: cos·cos, cos·sin, sin·sin.
    pub(super) information: [f64; 3],
    /// The series left times cos, and times sin.
    pub(super) towards: [f64; 2],
    /// Gain in χ² with an amplitude and a phase of its own.
    pub(super) gain: f64,
}
