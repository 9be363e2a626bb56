//! The angle of a record, measured or integrated.

use plant::Kind;

use super::record::{Output, Record};

/// The angle of a record in rad. If it was not measured, it is integrated from the rate, and its trend removed.
pub fn angle_samples(record: &Record) -> Option<Vec<f64>> {
    if let Some(channel) = record.channel(Output::Angle) {
        return Some(channel.samples.clone());
    }
    let rate = record.channel(Output::Rate)?;
    let mut angle = vec![0.0; rate.samples.len()];
    let mut last = 0.0;
    for k in 1..angle.len() {
        let (a, b) = (rate.samples[k - 1], rate.samples[k]);
        if a.is_finite() && b.is_finite() {
            last = 0.5 * (a + b);
        }
        angle[k] = angle[k - 1] + last * (record.time_s[k] - record.time_s[k - 1]);
    }
    let mean = angle.iter().sum::<f64>() / angle.len().max(1) as f64;
    let rest = if record.kind == Kind::Balance {
        std::f64::consts::PI
    } else {
        0.0
    };
    for value in &mut angle {
        *value += rest - mean;
    }
    Some(angle)
}
