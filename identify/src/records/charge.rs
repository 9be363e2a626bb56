//! The charge that flowed through the motor.

use plant::Kind;

use super::{Record, RecordedCurrent};

impl Record {
    /// The charge in A s that flowed from the first sample to every sample, by the way in which the current was held or
    /// measured; `None` if no current acts or none was recorded.
    pub(crate) fn charge(&self) -> Option<Vec<f64>> {
        let RecordedCurrent::Known(input) = &self.current else {
            return None;
        };
        if self.kind == Kind::FreeSwing {
            return None;
        }
        let mut charge = vec![0.0; self.len()];
        for k in 1..self.len() {
            let (from, to) = (self.time_s[k - 1], self.time_s[k]);
            charge[k] = charge[k - 1] + input.mean::<f64>(from, to, None, k - 1) * (to - from);
        }
        Some(charge)
    }
}
