//! The windows of a record, with their starts: continued from an earlier fit, or guessed from the samples.

use plant::{TORQUE_CONSTANT, WHEEL_INERTIA};

use super::simulation::quantile_of;
use super::unknowns::{Nuisance, Window};
use crate::records::{Output, Record, StraightLine, angle_samples};

/// A window with its start guessed from its first samples.
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
        if points.len() < 2 {
            return (points.first().map_or(0.0, |point| point.1), 0.0);
        }
        let line = StraightLine::through(points.iter().copied());
        (line.at(0.0), line.slope)
    };
    let angle = angle_samples(record).map(|series| line(&series));
    let rate = record.channel(Output::Rate).map(|c| line(&c.samples));
    let speed = record.channel(Output::WheelSpeed).map(|c| line(&c.samples));
    let nuisances = Nuisance::of(record)
        .iter()
        .filter(|local| !local.is_past() || samples.start == 0)
        .map(|local| match local {
            Nuisance::Angle => angle.map_or(0.0, |(value, _)| value),
            Nuisance::Rate => rate
                .map(|(value, _)| value)
                .or(angle.map(|(_, slope)| slope))
                .unwrap_or(0.0),
            Nuisance::WheelSpeed => speed.map_or(0.0, |(value, _)| value),
            Nuisance::AngleZero
            | Nuisance::WheelAngle
            | Nuisance::PastMotion
            | Nuisance::PastCurrent => 0.0,
            Nuisance::EarlyStep(at) => quantile_of(record.unknown_steps[*at].guess),
            Nuisance::Current => {
                let torque_per_ampere = values[TORQUE_CONSTANT];
                let inertia = values[WHEEL_INERTIA];
                speed.map_or(0.0, |(_, slope)| slope * inertia / torque_per_ampere)
            }
        })
        .collect();
    Window { samples, nuisances }
}

/// A window may take over the start of an earlier window that begins within this share of its length.
const SNAP: f64 = 0.1;

/// Windows of about `window_s` seconds. A start is taken from a window of `before` that begins at the same place or
/// nearly so, otherwise it is guessed from the samples. (Two reasons for "nearly": a dozen noisy samples of a fast swing
/// give a poor guess, and four windows of 159 samples are one sample longer than one of 635.)
pub(super) fn windows(
    record: &Record,
    values: &[f64],
    window_s: f64,
    before: &[Window],
) -> Vec<Window> {
    let ranges = record.windows(window_s.min(record.window_s));
    let nearest = |range: &std::ops::Range<usize>| -> Option<&Window> {
        let near = before
            .iter()
            .min_by_key(|window| window.samples.start.abs_diff(range.start))?;
        let away = near.samples.start.abs_diff(range.start) as f64;
        // A log that is read by its teeth has other unknowns than the same log read in one piece.
        let unknowns = Nuisance::of(record).into_iter();
        let own = unknowns.filter(|local| !local.is_past() || near.samples.start == 0);
        let fits = near.nuisances.len() == own.count();
        (fits && away <= SNAP * range.len() as f64).then_some(near)
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
                    nuisances: near.nuisances.clone(),
                },
                None => guess(record, values, samples),
            }
        })
        .collect()
}

/// The windows of the last stage, with starts guessed from the samples.
pub fn final_windows(record: &Record, values: &[f64]) -> Vec<Window> {
    windows(record, values, f64::INFINITY, &[])
}

/// The same windows of the log, with starts guessed from the samples.
pub fn guessed(record: &Record, values: &[f64], windows: &[Window]) -> Vec<Window> {
    windows
        .iter()
        .map(|window| guess(record, values, window.samples.clone()))
        .collect()
}

/// The windows of the last stage for every record, with starts that continue those of a fit over other windows.
pub fn joined(records: &[&Record], values: &[f64], before: &[Vec<Window>]) -> Vec<Vec<Window>> {
    records
        .iter()
        .zip(before)
        .map(|(record, before)| windows(record, values, f64::INFINITY, before))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use plant::Kind;

    /// 159 samples make a window of 1.27 s at 8 ms, and 635 samples one of 5.08 s. A longer window begins where a
    /// shorter one began and takes over its start; the longer windows lie end to end over the whole log.
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
            .map(|(index, samples)| {
                let mut window = guess(&record, &[], samples);
                window.nuisances[0] = index as f64;
                window
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
            assert_eq!(window.nuisances, before.nuisances);
        }
        assert_eq!(end, record.len());
    }
}
