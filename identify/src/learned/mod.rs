//! The torque that a model lacks as a smooth curve over one coordinate, and its fit together with everything else.
//!
//! | file | job |
//! |---|---|
//! | `held_out` | the strength of the penalty on ∫f″²: the one that best predicts data that a fit has not seen |
//! | `own_terms` | the part of a curve that the model's own terms describe already |
//! | `missing` | the missing torque as a curve, without simulating |
//! | `knots` | where the curve may bend |
//! | `smoothing` | the penalty of the final fit |
//! | `learn` | the fit |
//!
//! A curve explains nothing: it follows whatever depends on its coordinate. The penalty keeps it from following noise.

mod held_out;
mod knots;
mod learn;
mod missing;
mod own_terms;
mod smoothing;

pub(crate) use learn::learn;
pub use missing::{CurvePoint, MissingCurve, best_missing_curve, missing_curve};

use nalgebra::DMatrix;
use plant::{Kind, LearnedCoordinate, Model, Role};

use crate::fit::Unknowns;

/// The prior of a model's learned curves, as a quadratic form of the free parameters in the fit's coordinates; `None`
/// for a model without learned curves.
pub(crate) fn penalty_of(model: &Model, unknowns: &Unknowns) -> Option<DMatrix<f64>> {
    let count = unknowns.free.len();
    let mut whole: Option<DMatrix<f64>> = None;
    for effect in model.learned() {
        let own = model.range_of(effect);
        let penalty = effect
            .info()
            .learned
            .and_then(|curve| curve.penalty.as_ref());
        let (Some(own), Some(penalty)) = (own, penalty) else {
            continue;
        };
        let places: Vec<Option<usize>> = own
            .map(|position| unknowns.free.iter().position(|&free| free == position))
            .collect();
        let whole = whole.get_or_insert_with(|| DMatrix::zeros(count, count));
        for (row, to_row) in places.iter().enumerate() {
            for (column, to_column) in places.iter().enumerate() {
                if let (Some(to_row), Some(to_column)) = (*to_row, *to_column) {
                    whole[(to_row, to_column)] += penalty[(row, column)];
                }
            }
        }
    }
    whole
}

/// Whether an experiment of this kind moves over the coordinate.
fn shows(coordinate: LearnedCoordinate, kind: Kind) -> bool {
    match coordinate.role() {
        Role::Wheel => kind != Kind::FreeSwing,
        _ => kind != Kind::SpinUp,
    }
}
