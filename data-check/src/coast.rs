//! A wheel that gains speed in a log whose current is zero: something drove it there.

use bench_files::Channel;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::coast::{BLOCKS, GAIN_NOISE, GAIN_SHARE};
use crate::view::{View, largest};
use identify::Output;

/// Reports the speed that a clamped body's wheel gains without a current. Where everything is free, the body's own swing
/// moves the wheel against it.
pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    let (Kind::SpinUp, Some(speed), Some(current)) = (
        view.kind(),
        view.samples(Channel::WheelSpeed),
        view.samples(Channel::Current),
    ) else {
        return;
    };
    if largest(current) != 0.0 || speed.len() < 2 * BLOCKS {
        return;
    }
    // Means of blocks, each with the index of its last sample.
    let length = speed.len().div_ceil(BLOCKS);
    let means: Vec<(usize, f64)> = speed
        .chunks(length)
        .enumerate()
        .filter_map(|(block, samples)| {
            let last = block * length + samples.len() - 1;
            let finite: Vec<f64> = samples.iter().copied().filter(|x| x.is_finite()).collect();
            // A block with holes averages less noise away.
            let is_whole = 2 * finite.len() > samples.len();
            let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
            is_whole.then_some((last, mean.abs()))
        })
        .collect();
    let Some(top) = (0..means.len()).max_by(|a, b| means[*a].1.total_cmp(&means[*b].1)) else {
        return;
    };
    let (last, fastest) = means[top];
    let before = means[..top].iter().map(|(_, mean)| *mean);
    let slowest = before.fold(fastest, f64::min);
    let gained = fastest - slowest;
    if gained < GAIN_SHARE * fastest || gained < GAIN_NOISE * view.noise(Output::WheelSpeed) {
        return;
    }
    let time_s = &view.experiment.log.time_s;
    // The means tell that it gained speed; its fastest sample near the fastest mean, until when.
    let near = (last + 1).saturating_sub(2 * length)..(last + 1 + length).min(speed.len());
    let top_speed = near
        .filter(|k| speed[*k].is_finite())
        .max_by(|a, b| speed[*a].abs().total_cmp(&speed[*b].abs()));
    let until = (time_s[top_speed.unwrap_or(last)] * 1e3).ceil() / 1e3;
    let is_driven_to_the_end = top + 1 == means.len();
    let fix = match is_driven_to_the_end {
        true => "state the current that drove it, constants = { current = … } in A, or leave this log out".to_owned(),
        false => format!("from = {until}; or state the current that drove it"),
    };
    let sentence = format!(
        "the wheel gains speed without a current until {} s, from {} to {} rad/s: a motor or a hand drove it",
        short(until),
        short(slowest),
        short(fastest)
    );
    out.push(
        Finding::warning(FindingId::Hand, sentence)
            .in_experiment(view.name())
            .with_channel(Channel::WheelSpeed.key())
            .with_fix(fix),
    );
}
