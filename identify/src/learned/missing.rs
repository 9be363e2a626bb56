//! The missing torque as a curve over a coordinate, without simulating.
//!
//! The torque that a model lacks, averaged over bumps ([`crate::residuals`]), is regressed on the weights of a spline,
//! averaged over the same bumps, so that the averaging does not smear a narrow curve. Small shifts of the model's
//! parameters are further regressors, because the fit of an incomplete model bends its parameters. The penalty on ∫f″²
//! is the one that predicts held-out experiments best (Wahba, *Spline Models for Observational Data*, 1990, ch. 4).

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use parallel::parallel_map;
use plant::{Instant, LearnedCoordinate, Model, Role, Spline};

use super::held_out::{
    Part, best_factor, block_length, held_out_cost, solved, sum, that_can_be_held_out,
};
use super::knots::{fine_knots, samples_of};
use super::own_terms::{apart_from, own_terms};
use super::shows;
use crate::fit::Window;
use crate::records::Record;
use crate::residuals::{MeasuredMotion, SIGNIFICANT, TorqueOn, half_bump, residual_torque};

/// Factor by which a bump is narrower than the usual one, so that narrow features of the curve are not smoothed away.
/// The second value is for logs whose rate was not measured, where narrower bumps are mostly noise.
const NARROW: (usize, usize) = (3, 2);
/// Smallest number of samples on either side of a bump's centre.
const FEWEST_HALF: usize = 4;
/// Most bumps of a log.
const MOST_BUMPS: usize = 1500;
/// Number of points on either side of a bump at which the spline is evaluated.
const POINTS: usize = 12;
/// A coordinate earlier in the list is preferred if its gain reaches this share of the gain of a later one.
const AS_GOOD: f64 = 0.9;
/// Points at which a curve is handed out.
const POINTS_OF_CURVE: usize = 81;

/// The torque that a model lacks, as a curve.
#[derive(Clone, Debug)]
pub struct MissingCurve {
    /// Over what.
    pub coordinate: LearnedCoordinate,
    /// Which torque it is a part of.
    pub on: TorqueOn,
    /// The names of the experiments that show it.
    pub experiments: Vec<String>,
    /// Share of the missing torque beyond the noise that the curve predicts in experiments from which it was not made.
    pub share: f64,
    /// The fall of χ² of the missing torque over all experiments by the curve, minus the fall that its degrees of
    /// freedom would cause on noise alone.
    pub explained: f64,
    /// Number of standard deviations by which the gain exceeds the gain by chance.
    pub significance: f64,
    pub(super) spline: Spline,
    pub(super) torque_nm: DVector<f64>,
    covariance: DMatrix<f64>,
    /// How far the parameters are off, by position.
    pub(super) shifts: Vec<(usize, f64)>,
    /// The factor of ∫f″².
    pub(super) smoothing: f64,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// The coordinate, SI.
    pub at: f64,
    /// The torque as it acts, N m (per kg m² where the scale of the torques is not known).
    pub torque_nm: f64,
    /// Its standard error, same unit.
    pub std_nm: f64,
}

impl MissingCurve {
    /// The curve with its band, over the range of the logs.
    pub fn points(&self) -> Vec<CurvePoint> {
        let knots = self.spline.knots();
        let n = knots.len();
        let (from, to) = match self.coordinate.period() {
            Some(period) => (0.0, period),
            None => (knots[0], knots[n - 1]),
        };
        let (mut weights, mut slopes) = (vec![0.0; n], vec![0.0; n]);
        (0..POINTS_OF_CURVE)
            .map(|k| {
                let at = from + (to - from) * k as f64 / (POINTS_OF_CURVE - 1) as f64;
                self.spline.weights(at, &mut weights, &mut slopes);
                let w = DVector::from_column_slice(&weights);
                CurvePoint {
                    at,
                    torque_nm: w.dot(&self.torque_nm),
                    std_nm: w.dot(&(&self.covariance * &w)).max(0.0).sqrt(),
                }
            })
            .collect()
    }
}

/// The rows of the regression from one log, each divided by the noise.
struct Rows {
    name: String,
    on: TorqueOn,
    /// A row for every bump: weights of the knots, then of the parameters.
    matrix: DMatrix<f64>,
    torque: DVector<f64>,
    /// Of neighbouring bumps.
    correlation: Vec<f64>,
    /// The number of each bump in strides. Bumps that touch a gap are missing.
    place: Vec<usize>,
}

/// The missing curve over a coordinate; `None` if the logs do not move over it, or if the curve predicts nothing.
/// `free` are the positions of the parameters that the fit of the model adjusts.
pub fn missing_curve(
    records: &[&Record],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    free: &[usize],
    coordinate: LearnedCoordinate,
) -> Option<MissingCurve> {
    let samples: Vec<f64> = records
        .iter()
        .filter(|record| shows(coordinate, record.kind))
        .flat_map(|record| samples_of(record, coordinate))
        .collect();
    let spline = Spline::new(&fine_knots(&samples, coordinate)?, coordinate.period())?;
    let n = spline.knots().len();
    let rows: Vec<Rows> = parallel_map(records.iter().zip(windows), |(record, windows)| {
        rows(record, windows, (model, values, free), coordinate, &spline)
    })
    .into_iter()
    .flatten()
    .collect();
    let count = n + free.len();
    if rows.is_empty() {
        return None;
    }
    let mut ranges: Vec<(&Rows, Range<usize>)> = rows
        .iter()
        .map(|rows| (rows, 0..rows.torque.len()))
        .collect();
    let parts_of = |ranges: &[(&Rows, Range<usize>)]| -> Vec<Part> {
        let parts = ranges.iter();
        parts
            .map(|(rows, range)| part(rows, range.clone()))
            .collect()
    };
    let mut parts = parts_of(&ranges);
    let all = sum(&parts);
    let mut held = that_can_be_held_out(&parts);
    if held.len() < 2 {
        ranges = rows.iter().flat_map(stretches).collect();
        parts = parts_of(&ranges);
        held = (0..parts.len()).collect();
    }
    let terms = own_terms(model, values, free, coordinate, &spline, &samples);
    let mut roughness = DMatrix::zeros(count, count);
    roughness
        .view_mut((0, 0), (n, n))
        .copy_from(spline.roughness());
    let mut fixed = DMatrix::zeros(count, count);
    let apart = apart_from(&terms, &all.information, 0..n);
    fixed.view_mut((0, 0), (n, n)).copy_from(&apart);
    let origin = DVector::zeros(count);
    let (smoothing, cost) = best_factor(&parts, &held, &roughness, &fixed, &origin)?;
    // Without a curve: its knots are held at zero.
    let mut no_curve = DMatrix::zeros(count, count);
    for at in 0..n {
        no_curve[(at, at)] = 1e9 * all.information[(at, at)].max(1e-300);
    }
    let without = held_out_cost(&parts, &held, &no_curve, &origin)?;
    let bumps: usize = rows.iter().map(|rows| rows.torque.len()).sum();
    let penalty = &roughness * smoothing + &fixed;
    let found = solved(&all, &penalty, &origin)?;
    // The residual that the curve leaves is the measure of noise: if something else is missing too, little is certain.
    let scatter = (all.cost(&found) / bumps.max(1) as f64).max(1.0);
    let gain = (without - cost) / scatter;
    let bumps_held: usize = held.iter().map(|&index| ranges[index].1.len()).sum();
    let beyond = (without / scatter - bumps_held as f64).max(gain);
    let in_all = all.cost(&solved(&all, &no_curve, &origin)?) - all.cost(&found);
    let covariance = covariance(&rows, &all, &penalty, count)? * scatter;
    // For noise alone, χ² has a variance of twice the number of the curve's own degrees of freedom.
    let freedom = freedom(&all, &penalty, n)?;
    Some(MissingCurve {
        coordinate,
        on: rows[0].on,
        experiments: rows.iter().map(|rows| rows.name.clone()).collect(),
        share: (gain / beyond.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0),
        explained: in_all - freedom * scatter,
        significance: gain / (2.0 * freedom.max(1.0)).sqrt(),
        torque_nm: found.rows(0, n).into_owned(),
        covariance: covariance.view((0, 0), (n, n)).into_owned(),
        shifts: free
            .iter()
            .enumerate()
            .map(|(index, &position)| (position, found[n + index]))
            .collect(),
        smoothing,
        spline,
    })
}

/// A log in stretches of ten correlation times of its missing torque.
fn stretches(rows: &Rows) -> Vec<(&Rows, Range<usize>)> {
    let series: Vec<f64> = rows.torque.iter().copied().collect();
    let length = block_length(&series);
    let starts = (0..series.len()).step_by(length);
    starts
        .map(|start| (rows, start..(start + length).min(series.len())))
        .collect()
}

/// The coordinate that describes the missing torque best, with its curve; `None` where no curve predicts
/// anything beyond chance.
pub fn best_missing_curve(
    records: &[&Record],
    windows: &[Vec<Window>],
    model: &Model,
    values: &[f64],
    free: &[usize],
) -> Option<MissingCurve> {
    // Among coordinates that do equally well, the first of the list is named. While a swing dies out, a torque that
    // depends on speed also looks like one that depends on the angle, but not the other way round.
    const ORDER: [LearnedCoordinate; 4] = [
        LearnedCoordinate::Rate,
        LearnedCoordinate::WheelSpeed,
        LearnedCoordinate::Angle,
        LearnedCoordinate::WheelAngle,
    ];
    let mut found: Vec<MissingCurve> = parallel_map(ORDER, |coordinate| {
        missing_curve(records, windows, model, values, free, coordinate)
    })
    .into_iter()
    .flatten()
    .filter(|curve| curve.significance > SIGNIFICANT)
    .collect();
    let best = found
        .iter()
        .map(|curve| curve.explained)
        .fold(0.0, f64::max);
    let chosen = found
        .iter()
        .position(|curve| best > 0.0 && curve.explained >= AS_GOOD * best)?;
    Some(found.swap_remove(chosen))
}

fn rows(
    record: &Record,
    windows: &[Window],
    (model, values, free): (&Model, &[f64], &[usize]),
    coordinate: LearnedCoordinate,
    spline: &Spline,
) -> Option<Rows> {
    if record.len() < 8 * FEWEST_HALF || !shows(coordinate, record.kind) {
        return None;
    }
    let usual = half_bump(record, values);
    let motion = MeasuredMotion::new(record, windows, model, values, usual)?;
    let narrow = if motion.rate_measured || coordinate.role() == Role::Wheel {
        NARROW.0
    } else {
        NARROW.1
    };
    let half = (usual / narrow).max(FEWEST_HALF);
    let stride = (record.len() / MOST_BUMPS).max(half / 2).max(1);
    let on: &[TorqueOn] = match coordinate.role() {
        Role::Wheel => &[TorqueOn::Wheel],
        _ => &[TorqueOn::Body, TorqueOn::BodyByCommand],
    };
    let missing = on.iter().find_map(|&on| {
        let shape = (half, stride);
        residual_torque(record, &record.weight, &motion, model, values, on, shape)
    })?;
    let n = spline.knots().len();
    let bumps = missing.centres.len();
    let noise = missing.noise_std_nm;
    if noise <= 0.0 || !noise.is_finite() {
        return None;
    }
    let of_parameters = motion.parameter_slopes(record, model, values, &missing);
    let mut matrix = DMatrix::zeros(bumps, n + free.len());
    let (mut weights, mut slopes) = (vec![0.0; n], vec![0.0; n]);
    for (row, &centre) in missing.centres.iter().enumerate() {
        let of_bump = missing.weights(record, centre);
        let first = centre - half;
        let every = half.div_ceil(POINTS).max(1);
        let mut total = 0.0;
        for (index, weight) in of_bump.iter().enumerate().step_by(every) {
            let state = &motion.state[first + index];
            let at = Instant {
                angle_rad: state.angle_rad,
                rate_rad_s: state.rate_rad_s,
                wheel_angle_rad: state.wheel_angle_rad,
                wheel_speed_rad_s: state.wheel_speed_rad_s,
                current_a: state.current_a,
                memory: 0.0,
            };
            spline.weights(coordinate.of(&at), &mut weights, &mut slopes);
            total += weight;
            for (column, own) in weights.iter().enumerate() {
                matrix[(row, column)] += weight * own;
            }
        }
        for column in 0..n {
            matrix[(row, column)] /= total * noise;
        }
        for (column, &position) in free.iter().enumerate() {
            // A larger parameter of the model makes the missing torque smaller.
            matrix[(row, n + column)] = -of_parameters[row][position] / noise;
        }
    }
    let is_finite = matrix.iter().all(|entry| entry.is_finite());
    is_finite.then(|| Rows {
        name: record.name.clone(),
        on: missing.on,
        matrix,
        torque: DVector::from_iterator(bumps, missing.torque_nm.iter().map(|one| one / noise)),
        correlation: missing.noise_correlation.clone(),
        place: missing
            .centres
            .iter()
            .map(|centre| centre / stride)
            .collect(),
    })
}

fn part(rows: &Rows, range: Range<usize>) -> Part {
    let matrix = rows.matrix.rows(range.start, range.len());
    let torque = rows.torque.rows(range.start, range.len());
    Part {
        information: matrix.tr_mul(&matrix),
        gradient: matrix.tr_mul(&torque),
        square: torque.norm_squared(),
    }
}

/// Covariance of the unknowns: from the correlated noise of overlapping bumps, and from what the penalty holds
/// (Wahba's band, which covers a curve on average over its range; Nychka, J. Am. Stat. Assoc. 83 (1988)).
fn covariance(
    rows: &[Rows],
    all: &Part,
    penalty: &DMatrix<f64>,
    count: usize,
) -> Option<DMatrix<f64>> {
    let mut middle = DMatrix::zeros(count, count);
    for rows in rows {
        for (lag, correlation) in rows.correlation.iter().enumerate() {
            for (row, place) in rows.place.iter().enumerate() {
                // The bump that is `lag` strides later, if it is there.
                let found = (row..=(row + lag).min(rows.place.len() - 1))
                    .rev()
                    .find(|&later| rows.place[later] <= place + lag);
                let Some(later) = found.filter(|&later| rows.place[later] == place + lag) else {
                    continue;
                };
                let (a, b) = (rows.matrix.row(row), rows.matrix.row(later));
                middle.ger(*correlation, &a.transpose(), &b.transpose(), 1.0);
                if lag > 0 {
                    middle.ger(*correlation, &b.transpose(), &a.transpose(), 1.0);
                }
            }
        }
    }
    let inverse = inverse(&(&all.information + penalty))?;
    Some(&inverse * (middle + penalty) * &inverse)
}

/// The degrees of freedom of the curve, without those of the parameters.
fn freedom(all: &Part, penalty: &DMatrix<f64>, knots: usize) -> Option<f64> {
    let inverse = inverse(&(&all.information + penalty))?;
    Some((inverse * &all.information).diagonal().rows(0, knots).sum())
}

fn inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let count = matrix.nrows();
    let scale: Vec<f64> = (0..count)
        .map(|at| {
            let diagonal = matrix[(at, at)];
            if diagonal > 0.0 {
                1.0 / diagonal.sqrt()
            } else {
                0.0
            }
        })
        .collect();
    let scaled = DMatrix::from_fn(count, count, |row, column| {
        let entry = matrix[(row, column)] * scale[row] * scale[column];
        match row == column {
            true => entry.max(1.0) + 1e-10,
            false => entry,
        }
    });
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(count, count, |row, column| {
        inverse[(row, column)] * scale[row] * scale[column]
    }))
}
