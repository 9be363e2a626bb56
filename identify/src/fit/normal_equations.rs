//! The normal equations of a fit. Their matrix has the shape of an arrow: the nuisance parameters of a window are
//! coupled with each other and with the shared parameters only. They are eliminated by Schur complements
//! (the structure of bundle adjustment; Triggs et al. 2000, section 6). The computing time is therefore linear in the
//! number of windows.

use nalgebra::{Cholesky, DMatrix, DVector};
use plant::Model;
use rayon::prelude::*;

use super::sensitivity::{WindowNormal, normal};
use super::unknowns::{Unknowns, Window};
use crate::records::Record;

pub(super) struct Assembled {
    pub(super) windows: Vec<Vec<WindowNormal>>,
    pub(super) cost: f64,
}

pub(super) fn assemble(
    records: &[&Record],
    globals: &[Vec<usize>],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
) -> Assembled {
    let jobs: Vec<(usize, usize)> = windows
        .iter()
        .enumerate()
        .flat_map(|(record, list)| (0..list.len()).map(move |window| (record, window)))
        .collect();
    let results: Vec<WindowNormal> = jobs
        .par_iter()
        .map(|&(record, window)| {
            normal(
                records[record],
                &windows[record][window],
                model,
                values,
                unknowns,
                &globals[record],
            )
        })
        .collect();
    // Summed in a fixed order, so that the result does not depend on the number of processors.
    let cost = results.iter().map(|result| result.cost).sum();
    let mut results = results.into_iter();
    let windows = windows
        .iter()
        .map(|list| results.by_ref().take(list.len()).collect())
        .collect();
    Assembled { windows, cost }
}

/// The reduced system in the free parameters, and for each window the data from which its nuisance parameters follow.
pub(super) struct Reduced {
    pub(super) matrix: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    pub(super) windows: Vec<Vec<Option<Eliminated>>>,
}

pub(super) struct Eliminated {
    /// The window's nuisance parameters that act, as indices into [`Window::nuisances`].
    pub(super) nuisances: Vec<usize>,
    pub(super) inverse: Cholesky<f64, nalgebra::Dyn>,
    pub(super) coupling: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
}

fn damped(matrix: &mut DMatrix<f64>, damping: f64) {
    for index in 0..matrix.nrows() {
        let diagonal = matrix[(index, index)];
        // An unknown without any influence on the outputs keeps its value.
        matrix[(index, index)] = if diagonal > 0.0 {
            diagonal * (1.0 + damping)
        } else {
            1.0
        };
    }
}

pub(super) fn reduce(
    assembled: &Assembled,
    globals: &[Vec<usize>],
    count: usize,
    damping: f64,
) -> Reduced {
    let mut whole = Reduced {
        matrix: DMatrix::zeros(count, count),
        gradient: DVector::zeros(count),
        windows: vec![],
    };
    for (list, globals) in assembled.windows.iter().zip(globals) {
        let part = reduce_record(list, globals, count, damping);
        whole.matrix += part.matrix;
        whole.gradient += part.gradient;
        whole.windows.push(part.windows);
    }
    whole
}

/// One record's share of the reduced system.
pub(super) struct ReducedRecord {
    pub(super) matrix: DMatrix<f64>,
    pub(super) gradient: DVector<f64>,
    pub(super) windows: Vec<Option<Eliminated>>,
}

pub(super) fn reduce_record(
    list: &[WindowNormal],
    globals: &[usize],
    count: usize,
    damping: f64,
) -> ReducedRecord {
    let mut matrix = DMatrix::zeros(count, count);
    let mut gradient = DVector::zeros(count);
    let mut windows = vec![];
    for normal in list {
        let p = globals.len();
        let l = normal.gradient.len() - p;
        let mut own = normal.hessian.view((p, p), (l, l)).into_owned();
        // A tiny relative damping: a window whose few samples do not determine all its nuisance parameters would
        // otherwise make the whole system singular.
        damped(&mut own, damping.max(1e-10));
        let coupling = normal.hessian.view((p, 0), (l, p)).into_owned();
        let own_gradient = normal.gradient.rows(p, l).into_owned();
        let eliminated = Cholesky::new(own).map(|inverse| Eliminated {
            nuisances: normal.nuisances.clone(),
            inverse,
            coupling,
            gradient: own_gradient,
        });
        let mut block = normal.hessian.view((0, 0), (p, p)).into_owned();
        let mut right = normal.gradient.rows(0, p).into_owned();
        for (row, &global) in globals.iter().enumerate() {
            matrix[(global, global)] += damping * block[(row, row)];
        }
        if let Some(eliminated) = &eliminated {
            block -=
                eliminated.coupling.transpose() * eliminated.inverse.solve(&eliminated.coupling);
            right -=
                eliminated.coupling.transpose() * eliminated.inverse.solve(&eliminated.gradient);
        }
        for (row, &to_row) in globals.iter().enumerate() {
            gradient[to_row] += right[row];
            for (column, &to_column) in globals.iter().enumerate() {
                matrix[(to_row, to_column)] += block[(row, column)];
            }
        }
        windows.push(eliminated);
    }
    ReducedRecord {
        matrix,
        gradient,
        windows,
    }
}

/// Solves the reduced system, scaled to a unit diagonal, for the unknowns that are not held.
pub(super) fn solve(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    held: &[bool],
) -> Option<DVector<f64>> {
    let count = gradient.len();
    let scale = DVector::from_fn(count, |index, _| {
        let diagonal = matrix[(index, index)];
        if held[index] || diagonal <= 0.0 {
            0.0
        } else {
            1.0 / diagonal.sqrt()
        }
    });
    let scaled = DMatrix::from_fn(count, count, |row, column| {
        if row == column {
            1.0 + if scale[row] == 0.0 { 0.0 } else { 1e-13 }
        } else {
            matrix[(row, column)] * scale[row] * scale[column]
        }
    });
    let right = gradient.component_mul(&scale);
    Cholesky::new(scaled).map(|cholesky| cholesky.solve(&right).component_mul(&scale))
}
