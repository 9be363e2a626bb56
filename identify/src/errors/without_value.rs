//! Parameters that the logs determine only together with others.
//!
//! Of an offset of the current under no command, for example, only the torque τ i₀ shows. If τ is not known, any current
//! fits as well as any other: the number at which the fit stopped means nothing.

use nalgebra::{Cholesky, DMatrix};
use plant::{BASE_PARAMETERS, Model, TORQUE_CONSTANT, WHEEL_INERTIA};

use super::estimate::Fit;
use crate::bench::FitProblem;

/// A parameter is determined beside another one, if that one is held, from this many standard errors: it is plainly not
/// zero. Gaussian noise reaches it once in 16,000 times.
const PLAIN: f64 = 4.0;
/// Added to the diagonal of the scaled information, so that it has an inverse. Combinations of parameters with less
/// information are lost in rounding anyway.
const RIDGE: f64 = 1e-12;

/// A parameter whose value in a fit means nothing by itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WithoutValue {
    /// Its position in the model.
    pub position: usize,
    /// One sentence without its name: why, and what would give it a value.
    pub why: String,
}

/// The parameters of effects that have no value by themselves: they cannot be told from zero while all unknowns are free,
/// and are plainly not zero if one of the others is held. That a fit has ended on a bound of the other makes no
/// difference, since along τ i₀ = const. it ends anywhere.
///
/// Logarithmic parameters are left out: they are never zero.
pub fn without_value(problem: &FitProblem, fit: &Fit) -> Vec<WithoutValue> {
    let free = &fit.unknowns.free;
    let together = variances(&fit.minimum.information, None);
    let mut out = vec![];
    for (index, &position) in free.iter().enumerate() {
        let square = fit.values[position].powi(2);
        let is_open = !fit.unknowns.logarithmic[index]
            && fit.model.effect_at(position).is_some()
            && together[index].is_some_and(|variance| variance > square);
        if !is_open {
            continue;
        }
        let partner = (0..free.len())
            .filter(|&other| other != index)
            .filter_map(|other| {
                let held = variances(&fit.minimum.information, Some(other));
                Some((other, held[index]?))
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|(_, variance)| PLAIN * PLAIN * variance < square);
        if let Some((partner, _)) = partner {
            out.push(WithoutValue {
                position,
                why: why(problem, &fit.model, free[partner]),
            });
        }
    }
    out
}

/// The variances of the unknowns by the information alone; `None` for the one that is held and for those without any
/// information.
fn variances(information: &DMatrix<f64>, held: Option<usize>) -> Vec<Option<f64>> {
    let count = information.nrows();
    let mut out = vec![None; count];
    let is_kept = |index: &usize| Some(*index) != held && information[(*index, *index)] > 0.0;
    let kept: Vec<usize> = (0..count).filter(is_kept).collect();
    let root = |index: usize| information[(index, index)].sqrt();
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), |row, column| {
        let ridge = if row == column { RIDGE } else { 0.0 };
        let (row, column) = (kept[row], kept[column]);
        information[(row, column)] / (root(row) * root(column)) + ridge
    });
    if let Some(factors) = Cholesky::new(scaled) {
        let inverse = factors.inverse();
        for (row, &index) in kept.iter().enumerate() {
            out[index] = Some(inverse[(row, row)] / information[(index, index)]);
        }
    }
    out
}

fn why(problem: &FitProblem, model: &Model, partner: usize) -> String {
    let name = model.parameters()[partner].name;
    let remedy = if partner == TORQUE_CONSTANT && !problem.wheel_scale_known {
        let inertia = BASE_PARAMETERS[WHEEL_INERTIA].name;
        format!("; {name} and {inertia} under [known] would give it one")
    } else if partner < BASE_PARAMETERS.len() {
        format!("; {name} under [known] would give it one")
    } else {
        String::new()
    };
    format!("no value by itself: these logs determine it only together with {name}{remedy}")
}
