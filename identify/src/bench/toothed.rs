//! A bench of dense logs whose motor shows teeth, read so that the teeth can be counted.
//!
//! Averages over a hundredth of a second hide the teeth that pass in it, and at a standstill a tooth decides where a
//! wheel goes. Such logs are therefore read in windows of a quarter of a second, in blocks that are shorter than a tooth
//! takes, at wheel angles that the teeth themselves tell. Not all windows count: those in which the teeth show most, and
//! as many again evenly over the log, which tell inertia and friction.

use std::ops::Range;
use std::sync::Arc;

use parallel::parallel_map;
use plant::Kind;

use crate::model_free::Teeth;
use crate::records::{BALANCE_WINDOW_S, Output, Record, ToothStart, median};

/// Longest block, in s, in a log in which the wheel also moves the body. Near the upright position the motion is as
/// fast as the controller, whose time scale sets the window; on a body that moves freely, cogging shows at higher
/// wheel speeds.
pub(super) const LONGEST_FREE_BLOCK_S: f64 = BALANCE_WINDOW_S / BLOCKS_PER_PERIOD;
/// Smallest number of blocks per period of the pendulum. The mean over a block then flattens the motion by 5e-4 of
/// its amplitude, and [`Record::averaged`] corrects this to 1e-5.
pub(super) const BLOCKS_PER_PERIOD: f64 = 60.0;
/// Number of windows of a log that count. Each tells a wheel's acceleration to some percent; sixty tell it to some
/// tenths, in a hundredth of a second of computing time.
const MOST_WINDOWS: usize = 60;
/// Number of windows of a bench that count. The logs share their parameters, so that many logs need fewer windows each:
/// 240 tell an acceleration of some percent to a quarter of a percent.
const MOST_WINDOWS_OF_BENCH: usize = 240;
/// Number of windows that count in every log, however many logs there are: they tell whether it agrees with the others.
const LEAST_WINDOWS: usize = 20;
/// Largest advance of the teeth's phase over a block, rad: its mean then flattens a ripple by 4 %.
const LARGEST_ADVANCE_RAD: f64 = 1.0;
/// Share of what the teeth promise that must lie in windows that slow.
const SHARE_RESOLVED: f64 = 0.9;
/// Standard deviation of the phase, rad, above which a window does not say where its teeth are.
const LARGEST_PHASE_STD_RAD: f64 = 0.7;

/// What dense logs say of the teeth of the motor.
#[derive(Clone, Debug)]
pub(super) enum Toothed {
    /// No log is dense.
    NotSought,
    /// Dense logs show none.
    Absent,
    /// They show teeth: for every log, the same samples read by its teeth, or `None` where no wheel shows them.
    Shown(Arc<Vec<Option<Record>>>),
    /// The logs of this bench are read by their teeth.
    Read,
}

impl Toothed {
    /// From the logs as recorded.
    pub(super) fn shown(teeth: &Teeth, raw: &[Record]) -> Toothed {
        let turning = raw.iter().filter(|raw| turns(raw)).count();
        let most = MOST_WINDOWS_OF_BENCH / turning.max(1);
        let most = most.clamp(LEAST_WINDOWS, MOST_WINDOWS);
        let logs = parallel_map(raw.iter().enumerate(), |(log, raw)| {
            by_teeth(teeth, log, raw, most)
        });
        Toothed::Shown(Arc::new(logs))
    }

    /// Number of samples per block of a log that is read by its teeth.
    pub(super) fn block(&self, log: usize) -> Option<usize> {
        match self {
            Toothed::Shown(records) => Some(records.get(log)?.as_ref()?.averaged_over),
            _ => None,
        }
    }
}

/// Whether a log has the speed of a wheel that moves.
fn turns(raw: &Record) -> bool {
    raw.kind != Kind::FreeSwing && raw.len() >= 2 && raw.channel(Output::WheelSpeed).is_some()
}

/// A log read by its teeth, with at most `most` windows that count; `None` if it has no wheel that moves, or its teeth
/// do not show.
fn by_teeth(teeth: &Teeth, log: usize, raw: &Record, most: usize) -> Option<Record> {
    let speed = raw.channel(Output::WheelSpeed).filter(|_| turns(raw))?;
    let n = raw.len();
    let at_start = teeth.correction(log, raw.time_s[0])?;
    let interval_s = (raw.time_s[n - 1] - raw.time_s[0]) / (n - 1) as f64;
    // The windows, each with what its teeth promise and how fast its wheel is.
    let mut promised: Vec<(f64, f64)> = raw
        .windows(BALANCE_WINDOW_S)
        .into_iter()
        .map(|samples| {
            let expected = promise(teeth, log, raw, &samples);
            let finite = speed.samples[samples].iter().filter(|v| v.is_finite());
            let mean = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
            (mean.abs(), expected)
        })
        .collect();
    promised.sort_by(|one, other| one.0.total_cmp(&other.0));
    let all: f64 = promised.iter().map(|one| one.1).sum();
    let mut sum = 0.0;
    let fastest = promised.iter().find(|one| {
        sum += one.1;
        sum >= SHARE_RESOLVED * all
    });
    let fastest_rad_s = fastest.map_or(0.0, |one| one.0);
    let of_teeth_s = LARGEST_ADVANCE_RAD / (teeth.order * fastest_rad_s).max(f64::MIN_POSITIVE);
    let block = (of_teeth_s.min(LONGEST_FREE_BLOCK_S) / interval_s) as usize;
    let mut record = raw.averaged(block.max(1));
    for channel in &mut record.channels {
        // Teeth that pass in a few blocks would count as noise in differences.
        if let Some(whole) = raw.channel(channel.output) {
            channel.set_noise(whole.noise_std / (block.max(1) as f64).sqrt());
        }
    }
    record.window_s = BALANCE_WINDOW_S;
    let corrections: Vec<_> = record
        .time_s
        .iter()
        .map(|&time_s| teeth.correction(log, time_s).unwrap_or(at_start))
        .collect();
    let measured = record.wheel_angles().to_vec();
    let shifts = corrections.iter().map(|one| one.angle_rad);
    let corrected: Vec<f64> = measured.iter().zip(shifts).map(|(a, b)| a + b).collect();
    let windows = record.windows(BALANCE_WINDOW_S);
    let known = windows.into_iter().filter(|samples| {
        let middle = usize::midpoint(samples.start, samples.end);
        corrections[middle].std_rad * teeth.order <= LARGEST_PHASE_STD_RAD
    });
    let promised = known.map(|samples| {
        let promised = promise(teeth, log, &record, &samples);
        (samples, promised)
    });
    let kept = kept(promised.collect(), most);
    if kept.is_empty() {
        return None;
    }
    record.weight.fill(0.0);
    for samples in &kept {
        record.weight[samples.clone()].fill(1.0);
    }
    let std_rad = median(
        kept.iter()
            .map(|samples| corrections[samples.start].std_rad),
    );
    record.set_corrected_wheel_angles(corrected, std_rad.unwrap_or(0.0));
    record.teeth = Some(ToothStart {
        order: teeth.order,
        per_inertia: teeth.per_inertia,
        phase_rad: teeth.phase_rad,
        gain: 2.0 * teeth.log_evidence,
    });
    Some(record)
}

/// The gain in log likelihood that the teeth promise in these samples.
fn promise(teeth: &Teeth, log: usize, record: &Record, samples: &Range<usize>) -> f64 {
    let (from, until) = (record.time_s[samples.start], record.time_s[samples.end - 1]);
    teeth.expected(log, from, until)
}

/// The windows that count, at most `most`, in the order of time: of `known`, each with what its teeth promise.
fn kept(mut known: Vec<(Range<usize>, f64)>, most: usize) -> Vec<Range<usize>> {
    if known.len() <= most {
        return known.into_iter().map(|one| one.0).collect();
    }
    let half = most / 2;
    let count = known.len();
    let evenly: Vec<Range<usize>> = (0..half)
        .map(|index| known[index * count / half].0.clone())
        .collect();
    known.sort_by(|one, other| other.1.total_cmp(&one.1));
    let mut kept: Vec<Range<usize>> = known.into_iter().take(half).map(|one| one.0).collect();
    kept.extend(evenly);
    kept.sort_by_key(|samples| samples.start);
    kept.dedup();
    kept
}
