//! The penalty of the final fit: the one that best predicts the held-out experiments, computed with the derivatives of
//! the fit.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use parallel::parallel_map;
use plant::{EffectId, LearnedCurve, Model};

use super::held_out::{Part, best_factor, block_length, sum, that_can_be_held_out};
use super::own_terms::{OwnTerm, apart_from};
use crate::fit::{
    Observation, Unknowns, Window, WindowNormal, normal, normal_observed, relevant, score_test,
};
use crate::records::Record;

/// The curve of `effect` with the penalty that predicts best, linearised at `values`, and the factor of ∫f″² in it;
/// `None` where nothing can be held out.
pub(super) fn smoothed(
    records: &[&Record],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    free: &[usize],
    effect: EffectId,
    terms: &[OwnTerm],
) -> Option<(EffectId, f64)> {
    let curve = effect.info().learned?;
    let own = model.range_of(effect)?;
    let unknowns = Unknowns::new(model, free);
    let place = free.iter().position(|&position| position == own.start)?;
    let range = place..place + own.len();
    let tested = score_test(records, model, values, windows, &unknowns, None);
    let mut parts: Vec<Part> = tested
        .records
        .into_iter()
        .map(|record| Part {
            information: record.information,
            gradient: record.gradient,
            square: record.cost,
        })
        .filter(|part| part.square.is_finite())
        .collect();
    let all = sum(&parts);
    // Only logs that show the curve can determine how smooth it is.
    let shows_curve = |part: &Part| range.clone().any(|at| part.information[(at, at)] > 0.0);
    let mut held = that_can_be_held_out(&parts);
    held.retain(|&index| shows_curve(&parts[index]));
    if held.len() < 2 {
        parts = blocks(records, windows, model, values, &unknowns, &range)?;
        held = (0..parts.len())
            .filter(|&index| shows_curve(&parts[index]))
            .collect();
    }
    let count = parts.first()?.gradient.len();
    let mut from = DVector::zeros(count);
    for (offset, at) in range.clone().enumerate() {
        from[at] = values[own.start + offset];
    }
    let n = own.len();
    let corner = |matrix: &DMatrix<f64>| {
        let mut whole = DMatrix::zeros(count, count);
        whole
            .view_mut((range.start, range.start), (n, n))
            .copy_from(matrix);
        whole
    };
    // The prior of the other curves.
    let mut fixed = DMatrix::zeros(count, count);
    for other in model.learned().filter(|other| *other != effect) {
        let penalty = other
            .info()
            .learned
            .and_then(|curve| curve.penalty.as_ref());
        let start = model
            .range_of(other)
            .and_then(|own| free.iter().position(|&position| position == own.start));
        if let (Some(penalty), Some(start)) = (penalty, start) {
            let size = penalty.nrows();
            fixed
                .view_mut((start, start), (size, size))
                .copy_from(penalty);
        }
    }
    let apart = apart_from(terms, &all.information, range.clone());
    let with_apart = fixed + corner(&apart);
    let roughness = corner(curve.spline.roughness());
    let (factor, _) = best_factor(&parts, &held, &roughness, &with_apart, &from)?;
    let penalty = curve.spline.roughness() * factor + apart;
    let effect = LearnedCurve::effect(curve.coordinate, curve.spline.knots(), Some(penalty))?;
    Some((effect, factor))
}

/// Largest number of blocks that are made from the windows of one log.
const MOST_BLOCKS: usize = 20;

/// Cuts the logs into stretches of ten correlation times of their residual. If a log is simulated in one piece, its
/// stretches share its start; the unknowns of that start stand behind the common parameters. If a log has many windows,
/// several windows make a stretch, each with its own start. A log that does not show the curve is one part.
fn blocks(
    records: &[&Record],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    unknowns: &Unknowns,
    curve: &Range<usize>,
) -> Option<Vec<Part>> {
    let globals: Vec<Vec<usize>> = records
        .iter()
        .map(|record| relevant(record, model, unknowns))
        .collect();
    let is_whole = |index: usize| {
        windows[index].len() == 1 && globals[index].iter().any(|at| curve.contains(at))
    };
    let shared = unknowns.free.len();
    let starts: usize = (0..records.len())
        .filter(|&index| is_whole(index))
        .map(|index| windows[index][0].nuisances.len())
        .sum();
    let count = shared + starts;
    let mut next_start = shared;
    let mut parts = vec![];
    for (index, record) in records.iter().enumerate() {
        let globals = &globals[index];
        if is_whole(index) {
            let window = &windows[index][0];
            let own = stretches(
                record,
                window,
                (model, values),
                unknowns,
                globals,
                |seen| (next_start..next_start + seen).collect(),
                count,
            )?;
            next_start += window.nuisances.len();
            parts.extend(own);
            continue;
        }
        let of_windows: Vec<Part> = parallel_map(&windows[index], |window| {
            let normal = normal(record, window, model, values, unknowns, globals);
            without_starts(&normal, globals, count)
        });
        let each = of_windows.len().div_ceil(MOST_BLOCKS).max(1);
        parts.extend(of_windows.chunks(each).map(sum));
    }
    let is_finite = parts.iter().all(|part| part.square.is_finite());
    (is_finite && !parts.is_empty()).then_some(parts)
}

/// The normal equations of a window whose own unknowns follow the shared ones.
fn without_starts(normal: &WindowNormal, globals: &[usize], count: usize) -> Part {
    let p = globals.len();
    let l = normal.gradient.len() - p;
    let mut matrix = normal.hessian.view((0, 0), (p, p)).into_owned();
    let mut right = normal.gradient.rows(0, p).into_owned();
    let mut square = normal.cost;
    let mut own = normal.hessian.view((p, p), (l, l)).into_owned();
    for at in 0..l {
        own[(at, at)] = own[(at, at)].max(1e-300) * (1.0 + 1e-10);
    }
    if let Some(own) = own.cholesky() {
        let coupling = normal.hessian.view((p, 0), (l, p)).into_owned();
        let own_right = normal.gradient.rows(p, l).into_owned();
        matrix -= coupling.transpose() * own.solve(&coupling);
        right -= coupling.transpose() * own.solve(&own_right);
        square -= own_right.dot(&own.solve(&own_right));
    }
    let mut part = Part::empty(count);
    part.square = square;
    for (row, &to_row) in globals.iter().enumerate() {
        part.gradient[to_row] = right[row];
        for (column, &to_column) in globals.iter().enumerate() {
            part.information[(to_row, to_column)] = matrix[(row, column)];
        }
    }
    part
}

/// One observation of a log in one piece.
struct Seen {
    sample: usize,
    channel: usize,
    residual: f64,
    sensitivity: Vec<f64>,
}

/// A log in one piece, cut into stretches; `places` says where its own unknowns stand.
fn stretches(
    record: &Record,
    window: &Window,
    (model, values): (&Model, &[f64]),
    unknowns: &Unknowns,
    globals: &[usize],
    places: impl Fn(usize) -> Vec<usize>,
    count: usize,
) -> Option<Vec<Part>> {
    let mut seen: Vec<Seen> = vec![];
    let keep = &mut |one: Observation| {
        seen.push(Seen {
            sample: one.sample,
            channel: one.channel,
            residual: one.residual,
            sensitivity: one.sensitivity.to_vec(),
        });
    };
    let normal = normal_observed(record, window, model, values, unknowns, globals, keep);
    if !normal.cost.is_finite() {
        return None;
    }
    let mut at = globals.to_vec();
    at.extend(places(normal.nuisances.len()));
    let first: Vec<f64> = seen
        .iter()
        .filter(|one| one.channel == 0)
        .map(|one| one.residual)
        .collect();
    let length = block_length(&first);
    let size = at.len();
    // Summed small, then put in place.
    let mut blocks: Vec<(DMatrix<f64>, DVector<f64>, f64)> = vec![];
    for one in seen {
        let block = one.sample / length;
        while blocks.len() <= block {
            blocks.push((DMatrix::zeros(size, size), DVector::zeros(size), 0.0));
        }
        let (matrix, right, square) = &mut blocks[block];
        let s = DVector::from_vec(one.sensitivity);
        matrix.ger(1.0, &s, &s, 1.0);
        right.axpy(one.residual, &s, 1.0);
        *square += one.residual * one.residual;
    }
    let parts = blocks.into_iter().map(|(matrix, right, square)| {
        let mut part = Part::empty(count);
        part.square = square;
        for (row, &to_row) in at.iter().enumerate() {
            part.gradient[to_row] = right[row];
            for (column, &to_column) in at.iter().enumerate() {
                part.information[(to_row, to_column)] = matrix[(row, column)];
            }
        }
        part
    });
    Some(parts.collect())
}
