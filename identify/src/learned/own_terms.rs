//! The part of a learned curve that the model's own terms describe already.
//!
//! A curve over the angle overlaps with gravity: a part proportional to sin α could belong to either. The curve is
//! therefore kept orthogonal, over the samples, to every fitted term of the model that depends on the curve's
//! coordinate alone. The same holds for a term with a given parameter, if the logs cannot tell it from the curve. If
//! they can, the curve may show that the given value is wrong.

use nalgebra::{DMatrix, DVector};
use plant::{EffectId, GRAVITY_TORQUE, Instant, LearnedCoordinate, Model, Role, Smoothing, Spline};

/// Weight of the orthogonality rows against the information of the data: about a thousandth of the overlap remains.
const WEIGHT: f64 = 1e3;
/// If the other parameters leave less than this share of the information about a term, the logs cannot distinguish the
/// term from them.
const TOLD: f64 = 0.01;

/// A term of the model in the coordinate of a curve.
pub(super) struct OwnTerm {
    /// Its torque, up to a factor, at the knots.
    pub at_knots: DVector<f64>,
    /// Σ over the samples of (term · weight of each knot).
    row: DVector<f64>,
    /// Whether the fit moves it.
    pub is_free: bool,
}

/// A torque over a coordinate.
type Term<'t> = dyn Fn(f64) -> f64 + 't;

fn instant(coordinate: LearnedCoordinate, value: f64) -> Instant<f64> {
    let mut at = Instant {
        angle_rad: 0.0,
        rate_rad_s: 0.0,
        wheel_angle_rad: 0.0,
        wheel_speed_rad_s: 0.0,
        current_a: 0.0,
        memory: 0.0,
    };
    match coordinate {
        LearnedCoordinate::Angle => at.angle_rad = value,
        LearnedCoordinate::Rate => at.rate_rad_s = value,
        LearnedCoordinate::WheelSpeed => at.wheel_speed_rad_s = value,
        LearnedCoordinate::WheelAngle => at.wheel_angle_rad = value,
    }
    at
}

/// The derivative of an effect's torque with respect to one of its parameters.
fn slope(effect: EffectId, p: &[f64], parameter: usize, at: &Instant<f64>) -> f64 {
    let step = 1e-6 * p[parameter].abs().max(1e-9);
    let moved = |step: f64| {
        let mut p = p.to_vec();
        p[parameter] += step;
        effect.torque(&p, at, &Smoothing::SIMULATION)
    };
    (moved(step) - moved(-step)) / (2.0 * step)
}

/// The terms of a model (without learned curves) in a coordinate. `samples` are its values over the logs.
pub(super) fn own_terms(
    model: &Model,
    values: &[f64],
    free: &[usize],
    coordinate: LearnedCoordinate,
    spline: &Spline,
    samples: &[f64],
) -> Vec<OwnTerm> {
    let mut terms: Vec<(Box<Term>, bool)> = vec![];
    if coordinate == LearnedCoordinate::Angle {
        terms.push((Box::new(f64::sin), free.contains(&GRAVITY_TORQUE)));
    }
    let role = coordinate.role();
    for (effect, own) in model.ranges() {
        let info = effect.info();
        if info.role != role || info.learned.is_some() {
            continue;
        }
        let p = &values[own.clone()];
        for parameter in 0..own.len() {
            let is_free = free.contains(&(own.start + parameter));
            let term = move |value: f64| slope(effect, p, parameter, &instant(coordinate, value));
            if is_free {
                terms.push((Box::new(term), true));
            }
        }
    }
    debug_assert!(matches!(role, Role::Body | Role::Wheel));
    let n = spline.knots().len();
    let (mut weights, mut slopes) = (vec![0.0; n], vec![0.0; n]);
    let mut found = vec![];
    for (term, is_free) in terms {
        let mut row = DVector::zeros(n);
        let mut square = 0.0;
        for &sample in samples {
            let value = term(sample);
            square += value * value;
            spline.weights(sample, &mut weights, &mut slopes);
            for (entry, weight) in row.iter_mut().zip(&weights) {
                *entry += value * weight;
            }
        }
        if square > 0.0 && square.is_finite() && row.norm() > 0.0 {
            found.push(OwnTerm {
                at_knots: DVector::from_iterator(n, spline.knots().iter().map(|&knot| term(knot))),
                row,
                is_free,
            });
        }
    }
    found
}

/// The penalty that keeps a curve apart from these terms. `information` is that of the logs on all unknowns, of
/// which the curve's are at `curve`.
pub(super) fn apart_from(
    terms: &[OwnTerm],
    information: &DMatrix<f64>,
    curve: std::ops::Range<usize>,
) -> DMatrix<f64> {
    let n = curve.len();
    let largest = curve
        .clone()
        .map(|at| information[(at, at)])
        .fold(0.0, f64::max);
    let mut penalty = DMatrix::zeros(n, n);
    // Two terms may be the same function (a cable's rest angle and an offset). An orthonormal set of rows counts each
    // function once.
    let mut rows: Vec<DVector<f64>> = vec![];
    for term in terms {
        if !term.is_free && is_told(term, information, curve.clone()) {
            continue;
        }
        let mut row = term.row.normalize();
        for other in &rows {
            let along = other.dot(&row);
            row -= other * along;
        }
        if row.norm() > 1e-6 {
            let row = row.normalize();
            penalty += &row * row.transpose() * (WEIGHT * largest);
            rows.push(row);
        }
    }
    penalty
}

/// Whether the logs distinguish a curve along this term from the effects of the other unknowns.
fn is_told(term: &OwnTerm, information: &DMatrix<f64>, curve: std::ops::Range<usize>) -> bool {
    let others: Vec<usize> = (0..information.nrows())
        .filter(|at| !curve.contains(at) && information[(*at, *at)] > 0.0)
        .collect();
    let of_curve = information.view((curve.start, curve.start), (curve.len(), curve.len()));
    let whole = term.at_knots.dot(&(of_curve * &term.at_knots));
    if whole <= 0.0 {
        return false;
    }
    if others.is_empty() {
        return true;
    }
    let scale: Vec<f64> = others
        .iter()
        .map(|&at| 1.0 / information[(at, at)].sqrt())
        .collect();
    let matrix = DMatrix::from_fn(others.len(), others.len(), |row, column| {
        information[(others[row], others[column])] * scale[row] * scale[column]
            + if row == column { 1e-12 } else { 0.0 }
    });
    let coupling = DVector::from_fn(others.len(), |row, _| {
        let entries = curve.clone().zip(term.at_knots.iter());
        entries
            .map(|(at, value)| information[(others[row], at)] * value)
            .sum::<f64>()
            * scale[row]
    });
    let Some(cholesky) = matrix.cholesky() else {
        return false;
    };
    let taken = coupling.dot(&cholesky.solve(&coupling));
    whole - taken > TOLD * whole
}
