//! Where a model fails: its residuals over physical coordinates (speed, angle, current, …).
//!
//! Two residuals are broken down. The missing torque ([`super::residual_torque`]) has no memory, so its dependence on
//! a coordinate can be fitted. The residual of the free-running simulation is what users see in a figure; for it, the
//! breakdown says where it is large.
//!
//! **The missing torque.** For each coordinate x, the torque is modelled as a function f(x) that is constant within
//! each of a few bins, and fitted by least squares. A bump of the weak form sees the mean of f along
//! its path, Σ ψₖ f(xₖ). The regression on these means undoes the smearing, so a magnet that a
//! swing passes within one bump is located correctly. Where friction may depend on place or time, each bin has a
//! second coefficient, f₂(x) sign(speed). One function serves all logs together: friction must be the same function of
//! speed in every log, otherwise it does not depend on speed. Two coordinates have one function per log instead:
//! time, and the wheel's angle, which counts from the start of each log.
//!
//! Before that, the part that changes of the parameters explain is removed: the fit of an incomplete model has biased
//! parameters, and their bias adds to the missing torque everywhere.
//!
//! The sum of squares that a coordinate explains is compared with the sum that it would explain of noise
//! alone: tr(P Σ), with P the projection and Σ the known covariance of overlapping bumps, and variance
//! 2 tr(P Σ P Σ) (Seber & Lee, *Linear Regression Analysis*, 2003, theorem 1.6). The region is given in the coordinate
//! that explains most: the shortest run of bins that holds four fifths of the explained squares.
//!
//! **The residual of the free run** lags behind its causes, because a pendulum has memory. It is reported only where its
//! square exceeds the sensor's noise.

mod coordinate;
mod failure_map;
mod output;
mod series;
mod steps;
mod stretches;
mod torque;

use parallel::parallel_map;
use plant::Model;

use self::coordinate::coordinates;
use self::series::{Context, ResidualSeries, adjust, output_series, torque_series};
use super::residual_torque::{MeasuredMotion, TorqueOn, half_bump};
use crate::fit::{PredictedSeries, Window};
use crate::records::Record;

pub use self::coordinate::Coordinate;
pub use self::failure_map::{
    BreakdownBin, ExplainedTorque, FailureMap, FailureRegion, ResidualBreakdown, ResidualKind,
};

/// Largest number of regions that are named.
const MOST_REGIONS: usize = 12;

/// The residuals of one record.
struct Seen {
    motion: Option<MeasuredMotion>,
    /// For each coordinate its value in every interval.
    places: Vec<Vec<f64>>,
    /// The missing torques, with their slopes with respect to the parameters.
    torques: Vec<(TorqueOn, ResidualSeries, Vec<Vec<f64>>)>,
    outputs: Vec<ResidualSeries>,
}

fn seen(
    index: usize,
    record: &Record,
    windows: &[Window],
    traces: &[PredictedSeries],
    model: &Model,
    values: &[f64],
) -> Seen {
    let half = if record.len() > 1 {
        half_bump(record, values)
    } else {
        1
    };
    let Some(motion) = MeasuredMotion::new(record, windows, model, values, half) else {
        return Seen {
            motion: None,
            places: vec![vec![]; Coordinate::ALL.len()],
            torques: vec![],
            outputs: vec![],
        };
    };
    let torques = motion
        .residual_torques(record, model, values, half)
        .into_iter()
        .map(|missing| {
            let slopes = motion.parameter_slopes(record, model, values, &missing);
            (missing.on, torque_series(index, record, &missing), slopes)
        })
        .collect();
    Seen {
        places: coordinates(record, &motion, values),
        torques,
        outputs: output_series(index, record, traces),
        motion: Some(motion),
    }
}

/// Breaks down the residuals of a model. `windows` and `traces` are those of the fit, in the order of the records.
pub fn breakdown(
    records: &[Record],
    windows: &[Vec<Window>],
    traces: &[Vec<PredictedSeries>],
    model: &Model,
    values: &[f64],
) -> FailureMap {
    let mut map = FailureMap::default();
    let mut places: Vec<Vec<Vec<f64>>> = vec![];
    let mut motions: Vec<Option<MeasuredMotion>> = vec![];
    let mut torques: Vec<(TorqueOn, ResidualSeries)> = vec![];
    let mut slopes: Vec<Vec<Vec<f64>>> = vec![];
    let mut outputs: Vec<ResidualSeries> = vec![];
    let seen: Vec<Seen> = parallel_map(0..records.len(), |index| {
        let (windows, traces) = (&windows[index], &traces[index]);
        seen(index, &records[index], windows, traces, model, values)
    });
    for one in seen {
        motions.push(one.motion);
        places.push(one.places);
        for (on, series, own_slopes) in one.torques {
            torques.push((on, series));
            slopes.push(own_slopes);
        }
        outputs.extend(one.outputs);
    }
    for on in [TorqueOn::Body, TorqueOn::BodyByCommand, TorqueOn::Wheel] {
        let mut group: Vec<(&mut ResidualSeries, &[Vec<f64>])> = torques
            .iter_mut()
            .zip(&slopes)
            .filter(|((which, _), _)| *which == on)
            .map(|((_, series), slopes)| (series, slopes.as_slice()))
            .collect();
        adjust(&mut group, values.len());
    }
    let context = Context {
        records,
        places: &places,
        motions: &motions,
    };
    for on in [TorqueOn::Body, TorqueOn::BodyByCommand, TorqueOn::Wheel] {
        let group: Vec<&ResidualSeries> = torques
            .iter()
            .filter(|(which, _)| *which == on)
            .map(|(_, series)| series)
            .collect();
        if !group.is_empty() {
            context.break_torque_down(on, &group, &mut map);
        }
    }
    plainest_first(&mut map.regions);
    let mut of_outputs: Vec<FailureRegion> = outputs
        .iter()
        .filter_map(|series| context.break_output_down(series, &mut map.breakdowns))
        .collect();
    plainest_first(&mut of_outputs);
    map.regions.extend(of_outputs);
    if map.regions.iter().any(|region| region.is_significant) {
        map.regions.retain(|region| region.is_significant);
    }
    map.regions.truncate(MOST_REGIONS);
    for region in &mut map.regions {
        region.stretches_s = context.stretches_of(region);
    }
    map
}

fn plainest_first(regions: &mut [FailureRegion]) {
    regions.sort_by(|a, b| {
        let significant = b.is_significant.cmp(&a.is_significant);
        significant.then(b.size.total_cmp(&a.size))
    });
}
