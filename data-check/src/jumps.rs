//! Jumps that no motion makes: two logs in one file, or a sensor that lost its count.

use bench_files::numbers::number;
use bench_files::{Channel, Note};
use identify::{noise_std, resolution};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::channels::{
    BEYOND_STEPS, JUMP_AGAINST_RATE, JUMP_INSIDE, JUMP_NOISE, JUMP_SHARE, JUMP_STEPS,
};
use crate::view::{View, median, range, spoken};

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    // A jump beside a pause is the motion in the pause.
    let mut notes = view.experiment.report.notes.iter();
    if notes.any(|note| matches!(note, Note::Gap { .. })) {
        return;
    }
    let rate = match view.kind() {
        Kind::SpinUp => None,
        Kind::FreeSwing | Kind::Driven | Kind::Balance => view.samples(Channel::Rate),
    };
    let channels = [Channel::Angle, Channel::Rate, Channel::WheelSpeed];
    let mut found_one = false;
    for channel in channels {
        // A log of balancing may have pushes, which are found as such; and a jump of the angle says all.
        if channel == Channel::Rate && (view.kind() == Kind::Balance || found_one) {
            continue;
        }
        let Some(samples) = view.samples(channel) else {
            continue;
        };
        // Behind a standstill, a sensor jumps to where the motion has gone.
        let is_frozen = out.iter().any(|finding| {
            finding.finding == FindingId::Frozen
                && finding.channel.as_deref() == Some(channel.key())
        });
        if is_frozen {
            continue;
        }
        let of_rate = rate.filter(|_| channel == Channel::Angle);
        // Beside a rate that says otherwise, the jump leaves no doubt; by itself it may be a motion of a sparse log.
        let found = match against_rate(view, samples, of_rate) {
            Some(at) => Some((at, Finding::refusal as fn(FindingId, String) -> Finding)),
            None => against_itself(samples).map(|at| (at, Finding::warning as _)),
        };
        let Some((at, make)) = found else { continue };
        found_one = true;
        let cause = match channel {
            Channel::Rate => "a knock, or two logs in one file",
            _ => "two logs in one file, or a sensor that lost its count",
        };
        let time_s = &view.experiment.log.time_s;
        let size = samples[at + 1] - samples[at];
        out.push(
            make(
                FindingId::Jump,
                format!(
                    "the {} jumps by {} between {} and {} s, farther than in any other sample: {cause}",
                    spoken(channel),
                    short(size),
                    number(time_s[at]),
                    number(time_s[at + 1])
                ),
            )
            .in_experiment(view.name())
            .with_channel(channel.key())
            .with_fix(format!(
                "until = {} for the part before, from = {} for the part after; or an experiment for each",
                time_s[at],
                time_s[at + 1]
            )),
        );
    }
}

/// The steps of a channel that are larger than its noise, its digits and a share of its range allow.
fn least(samples: &[f64]) -> Option<f64> {
    let (low, high) = range(samples)?;
    Some(
        (JUMP_NOISE * noise_std(samples))
            .max(BEYOND_STEPS * resolution(samples))
            .max(JUMP_SHARE * (high - low)),
    )
}

/// The only step of a channel that is several times as large as all others, with neighbours that do not prepare it.
fn against_itself(samples: &[f64]) -> Option<usize> {
    let least = least(samples)?;
    let steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let size = |k: usize| steps[k].abs();
    let finite = || (0..steps.len()).filter(|k| steps[*k].is_finite());
    let at = finite().max_by(|a, b| size(*a).total_cmp(&size(*b)))?;
    let others = finite().filter(|k| *k != at).map(size);
    let second = others.fold(0.0, f64::max);
    // A channel that hardly moves has no usual step.
    (is_inside(at, steps.len())
        && second > 0.0
        && size(at) > JUMP_STEPS * second
        && size(at) > least)
        .then_some(at)
}

/// The step of an angle that contradicts the rate before and after it, where all others agree with it.
fn against_rate(view: &View, angle: &[f64], rate: Option<&[f64]>) -> Option<usize> {
    let (rate, least) = (rate?, least(angle)?);
    let time_s = &view.experiment.log.time_s;
    let off = |k: usize| {
        let way = 0.5 * (rate[k] + rate[k + 1]) * (time_s[k + 1] - time_s[k]);
        (angle[k + 1] - angle[k] - way).abs()
    };
    let all: Vec<f64> = (0..angle.len() - 1).map(off).collect();
    let usual = median(all.clone())?;
    let large = |k: &usize| all[*k] > (JUMP_AGAINST_RATE * usual).max(least);
    let mut found = (0..all.len()).filter(large);
    let (at, more) = (found.next()?, found.next());
    (more.is_none() && is_inside(at, all.len())).then_some(at)
}

/// Whether a step is far enough from both ends.
fn is_inside(at: usize, steps: usize) -> bool {
    at >= JUMP_INSIDE && at + JUMP_INSIDE < steps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A swing with two thousand samples, and the same from another release behind it.
    fn two_swings(second: f64) -> Vec<f64> {
        let swing = |size: f64, k: u32| {
            let t = 0.005 * f64::from(k);
            size * (-0.05 * t).exp() * (9.0 * t).cos() + 1e-3 * f64::from((k * 7919) % 13) / 13.0
        };
        let first = (0..1500).map(|k| swing(0.8, k));
        first.chain((0..1500).map(|k| swing(second, k))).collect()
    }

    #[test]
    fn two_logs_in_one_file_show_where_the_second_begins() {
        assert_eq!(against_itself(&two_swings(0.9)), Some(1499));
        assert_eq!(against_itself(&two_swings(-0.5)), Some(1499));
    }

    /// One swing, a square wave (which switches several times) and a spin-up from a switched current have no jump.
    #[test]
    fn motions_are_no_jumps() {
        assert_eq!(against_itself(&two_swings(0.8)[..1500]), None);
        let square: Vec<f64> = (0..400).map(|k| f64::from((k / 50) % 2)).collect();
        assert_eq!(against_itself(&square), None);
        let spin: Vec<f64> = (0..400)
            .map(|k| 300.0 * (1.0 - (-f64::from((k - 50).max(0)) / 80.0).exp()))
            .collect();
        assert_eq!(against_itself(&spin), None);
    }
}
