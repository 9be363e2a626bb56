//! Which logs are denser than their motion, and by how much.

use plant::{Kind, Model, period_s};

use super::problem::FitProblem;
use crate::fit::ratios;
use crate::records::{BALANCE_WINDOW_S, Record};

/// A log of fewer samples is fitted as it was recorded.
const MANY_SAMPLES: usize = 30_000;
/// Samples that are left at least: averages make a long log short, but no shorter.
const ENOUGH_SAMPLES: usize = 10_000;
/// Blocks in a period of the pendulum, at least: what the mean over one smooths is then 5e-4 of the amplitude, of
/// which [`Record::averaged`] leaves 1e-5.
const BLOCKS_PER_PERIOD: f64 = 60.0;
/// Longest block of a log in which the wheel turns alone, s: the teeth of a motor still show at a turn a second, and
/// faster ones make its speed ripple by less than a sensor shows.
const LONGEST_WHEEL_BLOCK_S: f64 = 0.01;
/// The same where it moves the body too, s: upright the motion is as fast as its controller, which the window knows,
/// and on a free body teeth show at higher speeds.
const LONGEST_FREE_BLOCK_S: f64 = BALANCE_WINDOW_S / BLOCKS_PER_PERIOD;
/// Blocks from one step of the current to the next, at least: in the block of a step the mean is not the middle.
const BLOCKS_PER_STEP: usize = 50;

impl FitProblem {
    /// Puts averages in the place of logs that are far denser than their motion.
    pub(super) fn average_dense_logs(&mut self) {
        if self
            .records
            .iter()
            .all(|record| record.len() < MANY_SAMPLES)
        {
            return;
        }
        let shown = ratios(&self.all_records());
        let period_s = shown
            .gravity_over_total
            .or(shown.gravity_over_free)
            .map(|_| period_s(&self.values_from(&shown, &Model::base())));
        for record in &mut self.records {
            let block = block_of(record, period_s);
            if block > 1 {
                *record = record.averaged(block);
            }
        }
    }
}

/// How many samples of a log make a block.
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
