//! An angle that stands still while its rate goes on, or a rate while its angle does: a sensor that stopped. The two are
//! compared with each other, so that neither the noise of a channel nor a jump behind the standstill is needed.

use std::f64::consts::{PI, TAU};

use bench_files::Channel;
use identify::{noise_std, resolution};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::channels::{FROZEN, FROZEN_SHARE};
use crate::thresholds::kinematics::{AGREES, MISSED_NOISE, MISSED_SHARE, MISSED_STEPS};
use crate::view::{View, median, range, spoken};

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    let (Some(angle), Some(rate)) = (view.samples(Channel::Angle), view.samples(Channel::Rate))
    else {
        return;
    };
    let Some((low, high)) = range(angle) else {
        return;
    };
    if view.kind() == Kind::SpinUp || low == high {
        return;
    }
    let time_s = &view.experiment.log.time_s;
    // The way of the rate from one sample to the next.
    let way = |k: usize| {
        let way = 0.5 * (rate[k] + rate[k + 1]) * (time_s[k + 1] - time_s[k]);
        if way.is_finite() { way } else { 0.0 }
    };
    if !agree(angle, way) {
        return;
    }
    let least = (MISSED_NOISE * noise_std(angle))
        .max(MISSED_STEPS * resolution(angle))
        .max(MISSED_SHARE * (high - low));
    for (channel, samples) in [(Channel::Angle, angle), (Channel::Rate, rate)] {
        let (mut count, mut missed, mut most) = (0, 0.0, 0.0_f64);
        for run in runs(samples) {
            let by_rate: f64 = run.clone().take(run.len() - 1).map(way).sum();
            let by_angle = angle[run.end - 1] - angle[run.start];
            let off = (by_rate - by_angle).abs();
            if off > least {
                count += run.len();
                missed += off;
                most = most.max(off);
            }
        }
        if count == 0 {
            continue;
        }
        // An angle that missed half a turn is behind by whole turns afterwards, or ahead.
        let is_lost = most > PI || count as f64 > FROZEN_SHARE * samples.len() as f64;
        let make = if is_lost {
            Finding::refusal
        } else {
            Finding::warning
        };
        let other = match channel {
            Channel::Angle => "rate",
            _ => "angle",
        };
        let turns = if most > TAU {
            format!(" ({} turns)", short(missed / TAU))
        } else {
            String::new()
        };
        // What the channel shows by itself says less.
        out.retain(|finding| {
            finding.finding != FindingId::Frozen
                || finding.channel.as_deref() != Some(channel.key())
        });
        out.push(
            make(
                FindingId::Frozen,
                format!(
                    "the {} stands still for {count} samples in which the body moves on by {} rad{turns}, as the {other} \
                     says",
                    spoken(channel),
                    short(missed)
                ),
            )
            .in_experiment(view.name())
            .with_channel(channel.key())
            .with_fix("exclude that part with from and until, or check the bus of the sensor"),
        );
    }
}

/// The stretches of at least [`FROZEN`] equal samples.
fn runs(samples: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut runs = vec![];
    let mut from = 0;
    for k in 1..=samples.len() {
        if k < samples.len() && samples[k] == samples[from] {
            continue;
        }
        if k - from >= FROZEN {
            runs.push(from..k);
        }
        from = k;
    }
    runs
}

/// Whether angle and rate agree where both move: else a wrong unit would look like a standstill.
fn agree(angle: &[f64], way: impl Fn(usize) -> f64) -> bool {
    let moving = || {
        (0..angle.len() - 1)
            .map(|k| (angle[k + 1] - angle[k], way(k)))
            .filter(|(step, _)| *step != 0.0)
    };
    let off = median(moving().map(|(step, way)| (step - way).abs()).collect());
    let usual = median(moving().map(|(step, _)| step.abs()).collect());
    matches!((off, usual), (Some(off), Some(usual)) if off < AGREES * usual)
}
