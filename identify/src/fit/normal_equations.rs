//! The normal equations of a fit. Their matrix has the shape of an arrow: the nuisance parameters of a window are
//! coupled with each other and with the shared parameters only. They are eliminated by Schur complements
//! (the structure of bundle adjustment; Triggs et al. 2000, section 6). The computing time is therefore linear in the
//! number of windows.

use nalgebra::{Cholesky, DMatrix, DVector};
use parallel::parallel_map;
use plant::Model;

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
    let results: Vec<WindowNormal> = parallel_map(jobs, |(record, window)| {
        normal(
            records[record],
            &windows[record][window],
            model,
            values,
            unknowns,
            &globals[record],
        )
    });
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

/// The damping of a step (Marquardt): each unknown is held by this share of its own information.
///
/// Where the scale of the torques is hardly known, the logs determine the ratios of the torques to an inertia many
/// orders better than the inertia itself. An inertia held by its information at *fixed torques* could then not move
/// along equal ratios. Therefore the ratios are damped beside the inertia at *fixed ratios*.
pub(super) struct Damping<'a> {
    /// The share; zero for none.
    pub(super) share: f64,
    /// For each free parameter that is a torque: the free parameter that is its inertia, and the change of the torque
    /// that keeps their ratio while the inertia changes by one, both in the fit's coordinates.
    pub(super) ratios: &'a [Option<(usize, f64)>],
}

/// No damping.
pub(super) const UNDAMPED: Damping<'static> = Damping {
    share: 0.0,
    ratios: &[],
};

/// Smallest damping of an inertia, relative to its information at fixed torques: where the logs tell nothing of the
/// scale, rounding would decide.
const LEAST_OF_SCALE: f64 = 1e-10;

impl Damping<'_> {
    /// Adds the damping to `matrix` (all free parameters), from the information `own` of one window about the free
    /// parameters `globals`.
    fn add(&self, own: &DMatrix<f64>, globals: &[usize], matrix: &mut DMatrix<f64>) {
        if self.share == 0.0 {
            return;
        }
        // The change of every torque when an inertia changes at fixed ratios.
        let mut along: Vec<DVector<f64>> = (0..globals.len())
            .map(|row| DVector::from_fn(globals.len(), |other, _| f64::from(row == other)))
            .collect();
        for (row, &global) in globals.iter().enumerate() {
            let Some(&Some((inertia, change))) = self.ratios.get(global) else {
                continue;
            };
            let diagonal = self.share * own[(row, row)];
            if let Some(at) = globals.iter().position(|&global| global == inertia) {
                along[at][row] = change;
                matrix[(global, inertia)] -= change * diagonal;
                matrix[(inertia, global)] -= change * diagonal;
                matrix[(inertia, inertia)] += change * change * diagonal;
            }
        }
        for (row, &global) in globals.iter().enumerate() {
            let at_fixed_ratios = along[row].dot(&(own * &along[row]));
            let least = LEAST_OF_SCALE * own[(row, row)];
            matrix[(global, global)] += self.share * at_fixed_ratios.max(least);
        }
    }
}

pub(super) fn reduce(
    assembled: &Assembled,
    globals: &[Vec<usize>],
    count: usize,
    damping: &Damping,
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
    damping: &Damping,
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
        damped(&mut own, damping.share.max(1e-10));
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
        damping.add(&block, globals, &mut matrix);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters of a window without nuisance parameters: an inertia of 2 and its torque of 6. The logs determine
    /// the torque per inertia to 1e-5 of the torque's value, and the inertia to a tenth. They ask for a step to an
    /// inertia that is larger by a third, at the same ratio.
    #[test]
    fn a_damped_step_keeps_to_the_ratios_that_the_logs_determine() {
        let (inertia, torque) = (2.0, 6.0);
        let across = DVector::from_vec(vec![-torque / inertia, 1.0]);
        let own = DVector::from_vec(vec![1.0, 0.0]);
        let hessian = &across * across.transpose() * (1e-5f64 * torque).powi(-2)
            + &own * own.transpose() * (0.1f64 * inertia).powi(-2);
        let wanted = DVector::from_vec(vec![inertia / 3.0, torque / 3.0]);
        let gradient = &hessian * &wanted;
        let step = |ratios: &[Option<(usize, f64)>]| {
            let mut matrix = hessian.clone();
            let damping = Damping {
                share: 1e-4,
                ratios,
            };
            damping.add(&hessian, &[0, 1], &mut matrix);
            solve(&matrix, &gradient, &[false, false]).expect("a step")
        };
        // The damping of 1e-4 shortens the step by this share; the rest is rounding, the two scales being 1e8 apart.
        let along = step(&[None, Some((0, torque / inertia))]);
        assert!((along - &wanted).norm() < 2e-4 * wanted.norm());
        // Held at a fixed torque, the inertia would hardly move.
        assert!(step(&[None, None]).norm() < 1e-3 * wanted.norm());
        // Without damping there is nothing to hold.
        let undamped = solve(&hessian, &gradient, &[false, false]).expect("a step");
        assert!((undamped - &wanted).norm() < 1e-4 * wanted.norm());
    }
}
