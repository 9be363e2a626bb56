//! Samples that were lost although the times are even: the angle goes several steps at once, in the sense and at the pace
//! in which it moves before and after.

use bench_files::Channel;
use bench_files::numbers::number;
use identify::{noise_std, resolution};

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::channels::{BEYOND_STEPS, JUMP_NOISE, LOST_ALIKE, LOST_MOST, LOST_STEP};
use crate::view::View;

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    let Some(angle) = view.samples(Channel::Angle) else {
        return;
    };
    // What jumps for another reason is said already.
    let is_said = out.iter().any(|finding| {
        matches!(
            finding.finding,
            FindingId::Jump | FindingId::Frozen | FindingId::Stale
        )
    });
    if is_said {
        return;
    }
    let time_s = &view.experiment.log.time_s;
    let is_even = |k: &usize| time_s[*k + 1] - time_s[*k] < 1.5 * view.step_s;
    let found: Vec<usize> = after_lost_samples(angle)
        .into_iter()
        .filter(is_even)
        .collect();
    // Many of them are a clock that is not even, or a sensor that is read late.
    let (Some(&at), true) = (found.first(), found.len() <= LOST_MOST) else {
        return;
    };
    let (step, before) = (angle[at + 1] - angle[at], angle[at] - angle[at - 1]);
    let more = match found.len() {
        1 => String::new(),
        2 => " (and 1 more such step)".to_owned(),
        count => format!(" (and {} more such steps)", count - 1),
    };
    out.push(
        Finding::warning(
            FindingId::Jump,
            format!(
                "the angle goes {} times as far between {} and {} s as in the steps beside{more}: samples were lost, \
                 and the times behind are too early",
                short(step / before),
                number(time_s[at]),
                number(time_s[at + 1])
            ),
        )
        .in_experiment(view.name())
        .with_channel(Channel::Angle.key())
        .with_fix(format!(
            "until = {} for the part before, from = {} for the part after; or an experiment for each",
            time_s[at],
            time_s[at + 1]
        )),
    );
}

/// The steps (from sample k to the next) that are longer than the two before and the two after, which are alike.
fn after_lost_samples(angle: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = angle.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let least = (JUMP_NOISE * noise_std(angle)).max(BEYOND_STEPS * resolution(angle));
    let is_lost = |k: &usize| {
        let beside = [steps[k - 2], steps[k - 1], steps[k + 1], steps[k + 2]];
        let sense = steps[*k].signum();
        let sizes = beside.map(|step| sense * step);
        let most = sizes.into_iter().fold(f64::MIN, f64::max);
        let fewest = sizes.into_iter().fold(f64::MAX, f64::min);
        let size = steps[*k].abs();
        // NaN fails each of these.
        fewest > 0.0 && most < LOST_ALIKE * fewest && size > LOST_STEP * most && size - most > least
    };
    (2..steps.len().saturating_sub(2)).filter(is_lost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swing() -> Vec<f64> {
        let swing = |k: u32| {
            let t = 0.05 * f64::from(k);
            let noise = 1e-3 * f64::from((k * 7919) % 13) / 13.0;
            0.8 * (-0.05 * t).exp() * (6.0 * t).cos() + noise
        };
        (0..600).map(swing).collect()
    }

    #[test]
    fn lost_samples_are_found_where_the_body_moves_and_nothing_else_is() {
        let whole = swing();
        assert_eq!(after_lost_samples(&whole), []);
        let mut lossy = whole;
        lossy.remove(309);
        assert_eq!(after_lost_samples(&lossy), [308]);
    }
}
