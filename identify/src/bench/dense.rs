//! Which logs are sampled far more densely than their motion needs, and by how much.

use plant::{Kind, Model, period_s};

use super::problem::FitProblem;
use super::toothed::{BLOCKS_PER_PERIOD, LONGEST_FREE_BLOCK_S, Toothed};
use crate::fit::ratios;
use crate::model_free::find_teeth;
use crate::records::Record;

/// A log with fewer samples is fitted as recorded.
const MANY_SAMPLES: usize = 30_000;
/// Smallest number of block averages that a log is reduced to.
const ENOUGH_SAMPLES: usize = 10_000;
/// Longest block, in s, in a log in which only the wheel turns. The cogging of a motor that makes one turn per second
/// is still resolved; at higher speeds the ripple of the wheel speed is below the sensor's noise.
const LONGEST_WHEEL_BLOCK_S: f64 = 0.01;
/// Smallest number of blocks between two steps of the current: the mean of a block that contains a step is not the
/// value at its middle.
const BLOCKS_PER_STEP: usize = 50;

impl FitProblem {
    /// Replaces logs that are far denser than their motion by block averages, after a search for teeth of the motor, which
    /// averages hide.
    pub(super) fn average_dense_logs(&mut self) {
        if self
            .records
            .iter()
            .all(|record| record.len() < MANY_SAMPLES)
        {
            return;
        }
        self.toothed = match find_teeth(&self.records) {
            Some(teeth) => Toothed::shown(&teeth, &self.records),
            None => Toothed::Absent,
        };
        let shown = ratios(&self.all_records());
        let period_s = shown
            .gravity_over_total
            .or(shown.gravity_over_free)
            .map(|_| period_s(&self.values_from(&shown, &Model::base())));
        for (log, record) in self.records.iter_mut().enumerate() {
            // Both ways of reading a log have the same samples, so that a fit of one can be looked at in the other.
            let block = match self.toothed.block(log) {
                Some(block) => block,
                None => block_of(record, period_s),
            };
            if block > 1 {
                *record = record.averaged(block);
            }
        }
    }
}

/// Number of samples per block for a log; 1 if it is not averaged.
fn block_of(record: &Record, period_s: Option<f64>) -> usize {
    let n = record.len();
    if n < MANY_SAMPLES {
        return 1;
    }
    let interval_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
    let of_period_s = period_s.map_or(f64::INFINITY, |period_s| period_s / BLOCKS_PER_PERIOD);
    let longest_s = match record.kind {
        Kind::FreeSwing => of_period_s,
        Kind::SpinUp => of_period_s.min(LONGEST_WHEEL_BLOCK_S),
        Kind::Balance | Kind::Driven => of_period_s.min(LONGEST_FREE_BLOCK_S),
    };
    let of_steps = n / (BLOCKS_PER_STEP * (record.kinks().len() + 1));
    let of_time = (longest_s / interval_s) as usize;
    of_time.min(of_steps).min(n / ENOUGH_SAMPLES).max(1)
}
