//! One window of a log: simulated with exact derivatives, compared with the measurement, summed into normal equations.

use nalgebra::{DMatrix, DVector};
use plant::{Dual, Kind, Model, Scalar, Smoothing};

use super::simulation::{run, simulate};
use super::unknowns::{Nuisance, Unknowns, Window};
use crate::records::Record;

/// The normal equations of one window: the matrix (Hgg Hgl; Hlg Hll) and the right-hand side. The unknowns are the
/// shared parameters ("globals"), then the acting nuisance parameters of the window ("locals"). Residuals are
/// divided by the noise of their channel.
#[derive(Clone, Debug)]
pub struct WindowNormal {
    /// Sum over the samples of sensitivity times its transpose, (p+l)×(p+l), for p globals and l locals.
    pub hessian: DMatrix<f64>,
    /// Sum of sensitivity times residual, length p+l.
    pub gradient: DVector<f64>,
    /// Sum of squared residuals; infinite if the simulation did not stay finite.
    pub cost: f64,
    /// The locals that act, as indices into [`Window::nuisances`].
    pub nuisances: Vec<usize>,
}

/// The unknowns that carry derivatives in the simulation of a window, in this order.
struct Lanes<'a> {
    /// Globals: indices into the unknowns.
    globals: &'a [usize],
    /// Locals on which the motion of the model depends, as indices into [`Window::nuisances`].
    nuisances: Vec<usize>,
}

impl Lanes<'_> {
    fn of<'a>(record: &Record, window: &Window, model: &Model, globals: &'a [usize]) -> Lanes<'a> {
        let nuisances = Nuisance::of(record).into_iter().zip(&window.nuisances);
        let nuisances = nuisances
            .enumerate()
            .filter(|(_, (local, _))| local.acts_on(model) && local.lies_in(record, window))
            .map(|(index, _)| index)
            .collect();
        Lanes { globals, nuisances }
    }

    fn count(&self) -> usize {
        self.globals.len() + self.nuisances.len()
    }

    /// At most `most` of these lanes, beginning with the lane `first`.
    fn part(&self, first: usize, most: usize) -> Lanes<'_> {
        let end = (first + most).min(self.count());
        let globals = self.globals.len();
        Lanes {
            globals: &self.globals[first.min(globals)..end.min(globals)],
            nuisances: self.nuisances[first.max(globals) - globals..end.max(globals) - globals]
                .to_vec(),
        }
    }

    /// The lane of a local, if it has one.
    fn of_nuisance(&self, local: usize) -> Option<usize> {
        let at = self.nuisances.iter().position(|&acting| acting == local)?;
        Some(self.globals.len() + at)
    }
}

/// One observation of a simulated window.
pub struct Observation<'a> {
    /// Index of the sample in the log.
    pub sample: usize,
    /// Index of the channel in the record.
    pub channel: usize,
    /// (measured − model)/noise.
    pub residual: f64,
    /// ∂(model/noise)/∂unknown, globals then acting locals.
    pub sensitivity: &'a [f64],
}

/// Largest number of unknowns, globals and locals together, that one simulation of a window carries.
const MAX_LANES: usize = 12;
/// Number of unknowns, globals and locals together, up to which it pays to score many effects at one point together:
/// two simulations of every window. A window may have more.
pub const MAX_UNKNOWNS: usize = 2 * MAX_LANES;

fn run_lanes<const N: usize>(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    lanes: &Lanes,
    // Not generic, so that the integrator is compiled once for each number of lanes.
    each: &mut dyn FnMut(usize, &plant::Reading<Dual<N>>),
) {
    let mut duals: Vec<Dual<N>> = values.iter().map(|&value| Dual::constant(value)).collect();
    for (lane, &unknown) in lanes.globals.iter().enumerate() {
        let position = unknowns.free[unknown];
        let mut dual = Dual::constant(values[position]);
        dual.derivatives[lane] = unknowns.slope(unknown, values[position]);
        duals[position] = dual;
    }
    let starts: Vec<Dual<N>> = window
        .nuisances
        .iter()
        .enumerate()
        .map(|(index, &value)| match lanes.of_nuisance(index) {
            Some(lane) => Dual::variable(value, lane),
            None => Dual::constant(value),
        })
        .collect();
    run(
        record,
        window,
        model,
        (&duals, &starts),
        Smoothing::SIMULATION,
        &mut |k, reading, _| each(k, reading),
    );
}

/// The normal equations of a window. Samples of weight 0 and missing samples do not count.
pub fn normal(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    globals: &[usize],
) -> WindowNormal {
    normal_observed(
        record,
        window,
        model,
        values,
        unknowns,
        globals,
        &mut |_| {},
    )
}

/// As [`normal`], and passes every observation that counts to `each`, sample by sample.
pub fn normal_observed(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    globals: &[usize],
    each: &mut dyn FnMut(Observation),
) -> WindowNormal {
    let lanes = Lanes::of(record, window, model, globals);
    let nothing = |lanes: &Lanes, cost: f64| WindowNormal {
        hessian: DMatrix::zeros(lanes.count(), lanes.count()),
        gradient: DVector::zeros(lanes.count()),
        cost,
        nuisances: lanes.nuisances.clone(),
    };
    if is_impossible(record, values) {
        return nothing(&lanes, f64::INFINITY);
    }
    if !counts(record, window) {
        return with_priors(record, window, &lanes, nothing(&lanes, 0.0));
    }
    // The integrator is compiled for each of these numbers of lanes. Unused lanes cost simulation time. The numbers are
    // therefore few, and closest together where most fits lie.
    let solve = match lanes.count() {
        0..=4 => normal_lanes::<4>,
        5..=6 => normal_lanes::<6>,
        7..=8 => normal_lanes::<8>,
        9..=MAX_LANES => normal_lanes::<MAX_LANES>,
        _ => normal_wide,
    };
    solve(record, window, model, values, unknowns, lanes, each)
}

/// From a simulation with `N` lanes: channel, residual and sensitivities of every measurement that counts at one
/// sample. Residual and sensitivities are divided by the noise.
fn observations<const N: usize>(
    record: &Record,
    k: usize,
    reading: &plant::Reading<Dual<N>>,
    mut each: impl FnMut(usize, f64, &[f64; N]),
) {
    let weight = record.weight[k];
    if weight == 0.0 {
        return;
    }
    for (index, channel) in record.channels.iter().enumerate() {
        let measured = channel.samples[k];
        if measured.is_nan() {
            continue;
        }
        let output = channel.output.of(reading);
        let scale = weight / channel.noise_std;
        let residual = (measured - output.value) * scale;
        let mut sensitivity = output.derivatives;
        for lane in &mut sensitivity {
            *lane *= scale;
        }
        each(index, residual, &sensitivity);
    }
}

fn normal_lanes<const N: usize>(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    lanes: Lanes,
    each: &mut dyn FnMut(Observation),
) -> WindowNormal {
    let count = lanes.count();
    let mut hessian = [[0.0; N]; N];
    let mut gradient = [0.0; N];
    let mut cost = 0.0;
    run_lanes::<N>(
        record,
        window,
        model,
        values,
        unknowns,
        &lanes,
        &mut |k, reading| {
            observations(record, k, reading, |channel, residual, sensitivity| {
                cost += residual * residual;
                for row in 0..count {
                    gradient[row] += sensitivity[row] * residual;
                    // The lower triangle is filled by symmetry at the end.
                    for column in 0..N {
                        hessian[row][column] += sensitivity[row] * sensitivity[column];
                    }
                }
                each(Observation {
                    sample: k,
                    channel,
                    residual,
                    sensitivity: &sensitivity[..count],
                });
            });
        },
    );
    let normal = WindowNormal {
        hessian: DMatrix::from_fn(count, count, |row, column| hessian[row][column]),
        gradient: DVector::from_fn(count, |row, _| gradient[row]),
        cost,
        nuisances: lanes.nuisances.clone(),
    };
    with_priors(record, window, &lanes, normal)
}

/// As [`normal_lanes`], for more unknowns than one simulation carries: several simulations, each with a part of the
/// lanes.
fn normal_wide(
    record: &Record,
    window: &Window,
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    lanes: Lanes,
    each: &mut dyn FnMut(Observation),
) -> WindowNormal {
    let count = lanes.count();
    // Sample, channel and residual of every observation, and its sensitivities in rows of `count`.
    let mut observed: Vec<(usize, usize, f64)> = vec![];
    let mut sensitivities: Vec<f64> = vec![];
    for first in (0..count).step_by(MAX_LANES) {
        let part = lanes.part(first, MAX_LANES);
        let own = part.count();
        let mut at = 0;
        run_lanes::<MAX_LANES>(
            record,
            window,
            model,
            values,
            unknowns,
            &part,
            &mut |k, reading| {
                observations(record, k, reading, |channel, residual, sensitivity| {
                    if first == 0 {
                        observed.push((k, channel, residual));
                        sensitivities.resize(count * observed.len(), 0.0);
                    }
                    let row = &mut sensitivities[count * at + first..];
                    row[..own].copy_from_slice(&sensitivity[..own]);
                    at += 1;
                });
            },
        );
    }
    let mut normal = WindowNormal {
        hessian: DMatrix::zeros(count, count),
        gradient: DVector::zeros(count),
        cost: 0.0,
        nuisances: lanes.nuisances.clone(),
    };
    let rows = sensitivities.chunks_exact(count);
    for (&(sample, channel, residual), sensitivity) in observed.iter().zip(rows) {
        normal.cost += residual * residual;
        for (row, &own) in sensitivity.iter().enumerate() {
            normal.gradient[row] += own * residual;
            let column = normal.hessian.column_mut(row);
            for (entry, other) in column.into_iter().zip(sensitivity) {
                *entry += own * other;
            }
        }
        each(Observation {
            sample,
            channel,
            residual,
            sensitivity,
        });
    }
    with_priors(record, window, &lanes, normal)
}

/// Adds the priors of the window's nuisance parameters to the normal equations.
fn with_priors(
    record: &Record,
    window: &Window,
    lanes: &Lanes,
    mut normal: WindowNormal,
) -> WindowNormal {
    for (local, value, std) in priors(record, window) {
        normal.cost += (value / std).powi(2);
        let Some(lane) = lanes.of_nuisance(local) else {
            continue;
        };
        normal.gradient[lane] -= value / (std * std);
        normal.hessian[(lane, lane)] += 1.0 / (std * std);
    }
    if !normal.cost.is_finite() {
        normal.cost = f64::INFINITY;
    }
    normal
}

/// The nuisance parameters of a window that have a prior: index, mean, standard deviation.
fn priors(record: &Record, window: &Window) -> Vec<(usize, f64, f64)> {
    let nuisances = Nuisance::of(record).into_iter().zip(&window.nuisances);
    nuisances
        .enumerate()
        .filter_map(|(index, (local, &value))| {
            let std = local.prior_std(record, window.samples.start)?;
            Some((index, value, std))
        })
        .collect()
}

/// Whether any sample of a window has weight. A window of which nothing counts need not be simulated.
pub(crate) fn counts(record: &Record, window: &Window) -> bool {
    let weights = &record.weight[window.samples.clone()];
    weights.iter().any(|&weight| weight > 0.0)
}

/// Whether the wheel's inertia would exceed that of body and wheel together.
fn is_impossible(record: &Record, values: &[f64]) -> bool {
    matches!(record.kind, Kind::Balance | Kind::Driven)
        && values[plant::WHEEL_INERTIA] >= values[plant::TOTAL_INERTIA]
}

/// The cost of [`normal`], computed without derivatives.
pub fn window_cost(record: &Record, window: &Window, model: &Model, values: &[f64]) -> f64 {
    if is_impossible(record, values) {
        return f64::INFINITY;
    }
    let mut cost = 0.0;
    if counts(record, window) {
        simulate(record, window, model, values, |k, reading, _| {
            let weight = record.weight[k];
            for channel in &record.channels {
                let measured = channel.samples[k];
                if weight > 0.0 && !measured.is_nan() {
                    let scale = weight / channel.noise_std;
                    cost += ((measured - channel.output.of(reading)) * scale).powi(2);
                }
            }
        });
    }
    for (_, value, std) in priors(record, window) {
        cost += (value / std).powi(2);
    }
    if cost.is_finite() {
        cost
    } else {
        f64::INFINITY
    }
}
