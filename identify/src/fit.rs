//! A fit from a plain start to the minimum, and what it says of every channel.
//!
//! A free run over a hundred periods has a cost with a local minimum for every period by which the
//! phase may slip. The fit therefore begins with windows of two periods, each with a start of its
//! own (multiple shooting; Bock 1983), whose cost is nearly quadratic, and lengthens the windows
//! until one of them spans the log.

use nalgebra::{DMatrix, SymmetricEigen};
use plant::{Kind, Model, TORQUE_CONSTANT, Timing, WHEEL_INERTIA, period_s};

use crate::cogging::settled;
use crate::covariance::covariance;
use crate::record::{Channel, Output, Record, RecordedCurrent};
use crate::sensitivity::{Local, Unknowns, Window, simulate};
use crate::solver::{Effort, Minimum, minimise, promise};
use crate::start::angle_samples;

/// Factor by which windows grow from one stage to the next.
const WINDOW_GROWTH: f64 = 4.0;
/// Periods in the first windows.
const FIRST_PERIODS: f64 = 2.0;

/// A model fitted to records.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Which effects the model has.
    pub model: Model,
    /// Its whole parameter vector, SI.
    pub values: Vec<f64>,
    /// Which of it was free.
    pub unknowns: Unknowns,
    /// The minimum that was found.
    pub minimum: Minimum,
    /// Covariance of the free parameters, in their own units; `None` where the data leave a
    /// combination of them open.
    pub covariance: Option<DMatrix<f64>>,
}

impl Fit {
    /// Standard error of the parameter at this position; `None` if it was not free or is open.
    pub fn std(&self, position: usize) -> Option<f64> {
        let index = self.unknowns.free.iter().position(|&at| at == position)?;
        let variance = self.covariance.as_ref()?[(index, index)];
        (variance > 0.0).then(|| variance.sqrt())
    }

    /// The parameters that have a standard error, by position, and the correlations of their errors
    /// in that order: symmetric, ones on the diagonal, no negative eigenvalue. `None` where fewer
    /// than two have one.
    pub fn correlation(&self) -> Option<(Vec<usize>, DMatrix<f64>)> {
        let covariance = self.covariance.as_ref()?;
        let (indices, stds): (Vec<usize>, Vec<f64>) = (0..self.unknowns.free.len())
            .filter_map(|index| Some((index, self.std(self.unknowns.free[index])?)))
            .unzip();
        let count = indices.len();
        if count < 2 {
            return None;
        }
        let scaled = DMatrix::from_fn(count, count, |row, column| {
            let (a, b) = (indices[row], indices[column]);
            0.5 * (covariance[(a, b)] + covariance[(b, a)]) / (stds[row] * stds[column])
        });
        // Strong correlations are differences of large numbers: rounding can leave an eigenvalue a
        // little below zero, which stands for zero.
        let mut eigen = SymmetricEigen::new(scaled);
        eigen.eigenvalues.apply(|value| *value = value.max(0.0));
        let possible = eigen.recompose();
        let matrix = DMatrix::from_fn(count, count, |row, column| {
            let (a, b) = (row.min(column), row.max(column));
            let scale = (possible[(a, a)] * possible[(b, b)]).sqrt();
            if a == b {
                1.0
            } else {
                possible[(a, b)] / scale
            }
        });
        let positions = indices.iter().map(|&index| self.unknowns.free[index]);
        Some((positions.collect(), matrix))
    }
}

/// Where a window's start lies, guessed from its first samples.
pub(crate) fn guess(record: &Record, values: &[f64], samples: std::ops::Range<usize>) -> Window {
    let span = samples.start..samples.end.min(samples.start + 12);
    let line = |series: &[f64]| -> (f64, f64) {
        // Value and slope at the first sample, by a straight line through the finite samples.
        let t0 = record.time_s[span.start];
        let points: Vec<(f64, f64)> = span
            .clone()
            .filter(|&k| series[k].is_finite())
            .map(|k| (record.time_s[k] - t0, series[k]))
            .collect();
        let n = points.len() as f64;
        if points.len() < 2 {
            return (points.first().map_or(0.0, |point| point.1), 0.0);
        }
        let (mt, my) = points.iter().fold((0.0, 0.0), |sum, point| {
            (sum.0 + point.0 / n, sum.1 + point.1 / n)
        });
        let (mut tt, mut ty) = (0.0, 0.0);
        for (t, y) in &points {
            tt += (t - mt) * (t - mt);
            ty += (t - mt) * (y - my);
        }
        let slope = if tt > 0.0 { ty / tt } else { 0.0 };
        (my - slope * mt, slope)
    };
    let angle = angle_samples(record).map(|series| line(&series));
    let rate = record.channel(Output::Rate).map(|c| line(&c.samples));
    let speed = record.channel(Output::WheelSpeed).map(|c| line(&c.samples));
    let locals = Local::of(record)
        .iter()
        .filter(|local| **local != Local::PastCurrent || samples.start == 0)
        .map(|local| match local {
            Local::Angle => angle.map_or(0.0, |(value, _)| value),
            Local::Rate => rate
                .map(|(value, _)| value)
                .or(angle.map(|(_, slope)| slope))
                .unwrap_or(0.0),
            Local::WheelSpeed => speed.map_or(0.0, |(value, _)| value),
            Local::AngleZero | Local::WheelAngle | Local::PastCurrent => 0.0,
            Local::Current => {
                let torque_per_ampere = values[TORQUE_CONSTANT];
                let inertia = values[WHEEL_INERTIA];
                speed.map_or(0.0, |(_, slope)| slope * inertia / torque_per_ampere)
            }
        })
        .collect();
    Window { samples, locals }
}

/// Share of a window's length by which its start is moved to that of an earlier window.
const SNAP: f64 = 0.1;

/// Windows of about `window_s` seconds whose starts are taken from `before` where it has one that begins
/// there or nearly there, else guessed from the samples. (A dozen noisy samples of a fast swing give a poor
/// guess, and four windows of 159 samples are one sample longer than one of 635.)
fn windows(record: &Record, values: &[f64], window_s: f64, before: &[Window]) -> Vec<Window> {
    let ranges = record.windows(window_s.min(record.window_s));
    let nearest = |range: &std::ops::Range<usize>| -> Option<&Window> {
        let near = before
            .iter()
            .min_by_key(|window| window.samples.start.abs_diff(range.start))?;
        let away = near.samples.start.abs_diff(range.start) as f64;
        (away <= SNAP * range.len() as f64).then_some(near)
    };
    let found: Vec<Option<&Window>> = ranges.iter().map(nearest).collect();
    let start = |index: usize| found[index].map_or(ranges[index].start, |near| near.samples.start);
    (0..ranges.len())
        .map(|index| {
            let end = if index + 1 < ranges.len() {
                start(index + 1)
            } else {
                record.len()
            };
            let samples = start(index)..end;
            match found[index] {
                Some(near) => Window {
                    samples,
                    locals: near.locals.clone(),
                },
                None => guess(record, values, samples),
            }
        })
        .collect()
}

/// The windows of the last stage, guessed from the samples.
pub fn final_windows(record: &Record, values: &[f64]) -> Vec<Window> {
    windows(record, values, f64::INFINITY, &[])
}

/// The same stretches of the log with the starts that the samples show.
pub fn guessed(record: &Record, values: &[f64], windows: &[Window]) -> Vec<Window> {
    windows
        .iter()
        .map(|window| guess(record, values, window.samples.clone()))
        .collect()
}

/// Fits from a plain start: the schedule of growing windows.
pub fn fit_from_scratch(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    free: &[usize],
) -> Minimum {
    let unknowns = Unknowns::new(model, free);
    let longest_s = records
        .iter()
        .map(|record| match record.kind {
            // A spin-up is nearly linear in everything and needs no schedule.
            Kind::SpinUp | Kind::Balance => 0.0,
            Kind::FreeSwing | Kind::Driven => {
                let span_s =
                    record.time_s.last().unwrap_or(&0.0) - record.time_s.first().unwrap_or(&0.0);
                span_s.min(record.window_s)
            }
        })
        .fold(0.0, f64::max);
    let mut window_s = FIRST_PERIODS * period_s(&values);
    let mut values = values;
    let mut current: Vec<Vec<Window>> = vec![vec![]; records.len()];
    loop {
        let last = window_s >= longest_s;
        let length_s = if last { f64::INFINITY } else { window_s };
        current = records
            .iter()
            .zip(&current)
            .map(|(record, before)| match record.kind {
                Kind::SpinUp => windows(record, &values, f64::INFINITY, before),
                _ => windows(record, &values, length_s, before),
            })
            .collect();
        let effort = if last { Effort::FULL } else { Effort::ROUGH };
        let minimum = minimise(records, model, values, current, &unknowns, effort);
        if last {
            return over_samples(records, model, minimum, &unknowns, effort);
        }
        values = minimum.values;
        current = minimum.windows;
        window_s *= WINDOW_GROWTH;
    }
}

/// Fits with windows of `window_s` seconds (where the kind allows a choice), each with a start of
/// its own. The cost is then nearly quadratic, whatever the model lacks.
pub fn fit_windowed(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    free: &[usize],
    window_s: f64,
    effort: Effort,
) -> Minimum {
    let windows = records
        .iter()
        .map(|record| match record.kind {
            Kind::SpinUp => final_windows(record, &values),
            _ => windows(record, &values, window_s, &[]),
        })
        .collect();
    refit(records, model, values, windows, free, effort)
}

/// Windows of the last stage for every record, whose starts continue those of a fit over other windows.
pub fn joined(records: &[&Record], values: &[f64], before: &[Vec<Window>]) -> Vec<Vec<Window>> {
    records
        .iter()
        .zip(before)
        .map(|(record, before)| windows(record, values, f64::INFINITY, before))
        .collect()
}

/// Fits again from a good start: parameters and windows of a neighbouring fit.
pub fn refit(
    records: &[&Record],
    model: &Model,
    values: Vec<f64>,
    windows: Vec<Vec<Window>>,
    free: &[usize],
    effort: Effort,
) -> Minimum {
    let windows = settled(records, model, &values, windows);
    let unknowns = Unknowns::new(model, free);
    let minimum = minimise(records, model, values, windows, &unknowns, effort);
    over_samples(records, model, minimum, &unknowns, effort)
}

/// What the delay of the next sample must promise, in χ², for a fit to start there.
const WORTH_A_SAMPLE: f64 = 1.0;
/// Evaluations that show whether it keeps that: from the middle of an interval the cost is nearly quadratic.
const LOOK_AT_A_SAMPLE: usize = 3;

/// Takes a delay on from sample to sample of the command while that lowers the cost.
///
/// A held command that is late by a part of a sample is a mean of itself, late by one sample more and by one
/// less. Where noise has a share in it (a controller passes that of its sensors on), the mean has less of it,
/// and the cost a minimum between any two samples.
fn over_samples(
    records: &[&Record],
    model: &Model,
    found: Minimum,
    unknowns: &Unknowns,
    effort: Effort,
) -> Minimum {
    let delay = model.find(|info| info.timing == Some(Timing::Delay));
    let (Some((effect, at)), Some(sample_s)) = (
        delay.filter(|(_, at)| unknowns.free.contains(at)),
        shortest_sample_s(records),
    ) else {
        return found;
    };
    let all = vec![true; unknowns.free.len()];
    let look = Effort {
        evaluations: LOOK_AT_A_SAMPLE,
        ..Effort::ROUGH
    };
    let mut best = found;
    let mut has_moved = false;
    for direction in [1.0, -1.0] {
        loop {
            let middle = (best.values[at] / sample_s).floor() + 0.5;
            let next_s = (middle + direction) * sample_s;
            let (low, high) = effect.info().parameters[0].bounds;
            if next_s < low || next_s > high || !best.cost.is_finite() {
                break;
            }
            let mut values = best.values.clone();
            values[at] = next_s;
            let promise = promise(records, model, &values, &best.windows, unknowns, None);
            let goal = best.cost - WORTH_A_SAMPLE;
            if promise.step(&values, unknowns, &all).cost > goal {
                break;
            }
            let windows = best.windows.clone();
            let next = minimise(records, model, values, windows, unknowns, look);
            if next.cost > goal {
                break;
            }
            best = next;
            has_moved = true;
        }
        // What lies behind was worse.
        if has_moved {
            break;
        }
    }
    if has_moved {
        best = minimise(records, model, best.values, best.windows, unknowns, effort);
    }
    best
}

/// The shortest time for which a recorded command is held, in s; `None` where none is.
fn shortest_sample_s(records: &[&Record]) -> Option<f64> {
    let held = records.iter().filter_map(|record| match &record.current {
        RecordedCurrent::Known(input) if record.kind != Kind::FreeSwing => input.held_s(),
        _ => None,
    });
    held.min_by(f64::total_cmp)
}

/// Adds standard errors to a minimum.
pub fn finish(records: &[&Record], model: &Model, free: &[usize], minimum: Minimum) -> Fit {
    let unknowns = Unknowns::new(model, free);
    let covariance = covariance(
        records,
        &minimum.windows,
        model,
        &minimum.values,
        &unknowns,
        &minimum.information,
        &minimum.on_bound,
    )
    .map(|mut matrix| {
        // From the fit's coordinates to the parameters' own units.
        for index in 0..unknowns.free.len() {
            let slope = unknowns.slope(index, minimum.values[unknowns.free[index]]);
            matrix.row_mut(index).scale_mut(slope);
            matrix.column_mut(index).scale_mut(slope);
        }
        matrix
    });
    Fit {
        model: model.clone(),
        values: minimum.values.clone(),
        unknowns,
        minimum,
        covariance,
    }
}

/// Model against measurement, for one channel of one record.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Which output.
    pub output: Output,
    /// The model's output at every sample, SI.
    pub predicted: Vec<f64>,
    /// Root mean square of measured − predicted over the samples that count.
    pub rmse: f64,
    /// 100 (1 − ‖y − ŷ‖/‖y − mean y‖).
    pub fit_percent: f64,
}

impl Trace {
    /// Compares a channel with what is predicted of it, at the samples whose weight is not 0.
    pub fn new(channel: &Channel, predicted: Vec<f64>, weight: &[f64]) -> Trace {
        let counted: Vec<(f64, f64)> = channel
            .samples
            .iter()
            .zip(&predicted)
            .zip(weight)
            .filter(|((y, model), weight)| y.is_finite() && model.is_finite() && **weight > 0.0)
            .map(|((y, model), _)| (*y, *model))
            .collect();
        let n = counted.len().max(1) as f64;
        let mean = counted.iter().map(|(y, _)| y).sum::<f64>() / n;
        let error: f64 = counted.iter().map(|(y, model)| (y - model).powi(2)).sum();
        let spread: f64 = counted.iter().map(|(y, _)| (y - mean).powi(2)).sum();
        Trace {
            output: channel.output,
            predicted,
            rmse: (error / n).sqrt(),
            fit_percent: 100.0 * (1.0 - (error / spread.max(1e-300)).sqrt()),
        }
    }
}

/// Simulates the windows of a record and compares every channel.
pub fn traces(record: &Record, windows: &[Window], model: &Model, values: &[f64]) -> Vec<Trace> {
    let mut predicted = vec![vec![f64::NAN; record.len()]; record.channels.len()];
    for window in windows {
        simulate(record, window, model, values, |k, reading, _| {
            for (series, channel) in predicted.iter_mut().zip(&record.channels) {
                series[k] = channel.output.of(reading);
            }
        });
    }
    record
        .channels
        .iter()
        .zip(predicted)
        .map(|(channel, predicted)| Trace::new(channel, predicted, &record.weight))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 159 samples make a window of 1.27 s at 8 ms, 635 one of 5.08 s: the longer ones begin where a
    /// shorter one did, with its start, and lie end to end over the whole log.
    #[test]
    fn longer_windows_continue_the_shorter_ones() {
        let time_s: Vec<f64> = (0..2001).map(|k| k as f64 * 0.008).collect();
        let angle: Vec<f64> = time_s.iter().map(|t| (10.0 * t).sin()).collect();
        let mut record = Record::new(
            "swing",
            Kind::FreeSwing,
            time_s,
            [Some(angle), None, None],
            None,
            false,
        );
        let shorter: Vec<Window> = record
            .windows(1.2696)
            .into_iter()
            .enumerate()
            .map(|(index, samples)| Window {
                samples,
                locals: vec![index as f64, -1.0],
            })
            .collect();
        record.window_s = 4.0 * 1.2696;
        let longer = joined(&[&record], &[], std::slice::from_ref(&shorter)).remove(0);
        assert_eq!(longer.len(), 4);
        let mut end = 0;
        for window in &longer {
            assert_eq!(window.samples.start, end);
            end = window.samples.end;
            let same = |other: &&Window| other.samples.start == window.samples.start;
            let before = shorter
                .iter()
                .find(same)
                .expect("a shorter one begins there");
            assert_eq!(window.locals, before.locals);
        }
        assert_eq!(end, record.len());
    }
}
