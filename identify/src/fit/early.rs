//! Fewer samples for the stages of a fit before its last one.
//!
//! These stages only bring the parameters near their minimum. Of a dense log, one sample every tenth of a radian of the
//! pendulum's phase leads there as well; of a wheel that turns alone, which is linear, fewer do. The last stage reads all
//! samples.

use plant::{Kind, Model, WHEEL_INERTIA, period_s};

use super::unknowns::Window;
use crate::records::Record;

/// A log with fewer samples is read as it is: it takes little time.
const MANY_SAMPLES: usize = 4_000;
/// Samples of a spin-up that are enough: the parameters of a straight line or an exponential take ten.
const SAMPLES_OF_SPIN_UP: usize = 2_000;
/// Longest time between two samples of a spin-up, as a share of the time in which its friction stops the wheel.
const SHARE_OF_STOP: f64 = 0.1;
/// Samples per period of the pendulum.
const SAMPLES_PER_PERIOD: f64 = 63.0;
/// Samples in a window of a log that is read in windows only: four for each of its unknowns, and as many again.
const SAMPLES_PER_WINDOW: f64 = 24.0;

/// A log with fewer samples.
pub(super) struct Early {
    pub(super) record: Record,
    /// Every how many samples one is read.
    step: usize,
}

impl Early {
    /// The log for the stages before the last one of a fit of the base model from these values; `None` if it has few
    /// samples already, or if the model may need all of them.
    pub(super) fn of(record: &Record, model: &Model, values: &[f64]) -> Option<Early> {
        let n = record.len();
        if n < MANY_SAMPLES || *model != Model::base() || record.teeth.is_some() {
            return None;
        }
        let interval_s = (record.time_s[n - 1] - record.time_s[0]) / (n - 1) as f64;
        let step = if record.kind == Kind::SpinUp && record.window_s.is_infinite() {
            let friction = model.position_of("wheel_viscous_friction")?;
            let stops_s = values[WHEEL_INERTIA] / values[friction].abs();
            let longest = SHARE_OF_STOP * stops_s / interval_s;
            (n / SAMPLES_OF_SPIN_UP).min(longest as usize)
        } else {
            let of_period_s = period_s(values) / SAMPLES_PER_PERIOD;
            let longest_s = of_period_s.min(record.window_s / SAMPLES_PER_WINDOW);
            (longest_s / interval_s) as usize
        };
        (step > 1).then(|| Early {
            record: record.thinned(step),
            step,
        })
    }

    /// Windows over these samples as windows over all `count` samples of the log.
    pub(super) fn whole(&self, windows: Vec<Window>, count: usize) -> Vec<Window> {
        let whole = windows.into_iter().map(|window| Window {
            samples: window.samples.start * self.step..(window.samples.end * self.step).min(count),
            nuisances: window.nuisances,
        });
        whole.collect()
    }
}
