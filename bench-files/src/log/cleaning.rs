//! What is done to the samples of a log before anyone sees them: turns, lost samples, a speed from an angle.

use super::note::Note;
use super::samples::Log;
use crate::channel::Channel;
use crate::drop_out::drop_outs;

/// Unwraps angles, computes the wheel's speed if only its angle was logged, and removes lost samples. Returns notes on
/// what was done.
pub(crate) fn cleaned(log: &mut Log, beside: &mut Log) -> Vec<Note> {
    let mut notes = gaps(&log.time_s);
    if let Some(angle) = &mut beside.angle_rad {
        unwrap_turns(angle);
    }
    for angle in [&mut log.wheel_angle_rad, &mut beside.wheel_angle_rad]
        .into_iter()
        .flatten()
    {
        unwrap_wheel(angle);
    }
    speed_from_angle(log, &mut notes);
    if let Some(angle) = &mut log.angle_rad {
        let count = unwrap_turns(angle);
        if count > 0 {
            notes.push(Note::AngleUnwrapped { count });
        }
    }
    // The current is an input, not a state: it can really jump for one sample.
    for channel in [Channel::Angle, Channel::Rate, Channel::WheelSpeed] {
        let time_s = std::mem::take(&mut log.time_s);
        if let Some(samples) = log.channel_mut(channel) {
            let found = drop_outs(&time_s, samples);
            if !found.is_empty() {
                for &i in &found {
                    samples[i] = f64::NAN;
                }
                notes.push(Note::DropOuts {
                    channel,
                    times_s: found.iter().map(|&i| time_s[i]).collect(),
                });
            }
        }
        log.time_s = time_s;
    }
    notes
}

/// Computes the wheel's speed if only its angle was logged: differences over one sample on either side (one-sided
/// at the ends). Their noise is that of the angle divided by the time between.
fn speed_from_angle(log: &mut Log, notes: &mut Vec<Note>) {
    if log.wheel_speed_rad_s.is_some() {
        return;
    }
    let Some(angle) = &log.wheel_angle_rad else {
        return;
    };
    let last = angle.len() - 1;
    let speed = (0..=last).map(|k| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        (angle[after] - angle[before]) / (log.time_s[after] - log.time_s[before])
    });
    log.wheel_speed_rad_s = Some(speed.collect());
    notes.push(Note::SpeedFromAngle);
}

/// Pauses of more than twenty usual intervals. In an irregular log, intervals vary, but not that much.
fn gaps(time_s: &[f64]) -> Vec<Note> {
    let mut intervals: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = intervals.len() / 2;
    if intervals.is_empty() {
        return Vec::new();
    }
    let (_, median, _) = intervals.select_nth_unstable_by(middle, f64::total_cmp);
    let longest = 20.0 * *median;
    time_s
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > longest)
        .take(8)
        .map(|pair| Note::Gap {
            from_s: pair[0],
            to_s: pair[1],
        })
        .collect()
}

/// Whether a column stays within one turn (and a hundredth for its noise), as the reading of a sensor with a range of one
/// turn does.
fn is_within_a_turn(angle_rad: &[f64]) -> bool {
    let finite = angle_rad.iter().copied().filter(|angle| angle.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), angle| {
        (low.min(angle), high.max(angle))
    });
    high - low <= 1.01 * std::f64::consts::TAU
}

/// Largest distance of a jump from a full turn, as a share of the turn: the motion within one sample.
const OFF_A_TURN: f64 = 0.1;
/// Largest step between two other samples, as a share of a turn. It leaves no doubt about the way that was taken.
const CERTAIN_STEP: f64 = 0.25;

/// Whether a column jumps by full turns and otherwise moves little from sample to sample: it was read from a sensor with
/// a range of one turn, even if it covers more (its noise, or a count of turns that lags behind).
///
/// Such a sensor jumps against its motion, and a count that lags behind jumps to and fro. A column whose jumps go one way
/// without any motion against them counts whole turns, as with one mark on the wheel: its steps are the motion.
fn jumps_by_turns(angle_rad: &[f64]) -> bool {
    let turns = angle_rad
        .windows(2)
        .map(|pair| (pair[1] - pair[0]) / std::f64::consts::TAU)
        .filter(|turns| turns.is_finite());
    let (mut jumps, mut of_jumps, mut of_motion) = (0, 0.0, 0.0);
    for turn in turns {
        if turn.abs() <= CERTAIN_STEP {
            of_motion += turn;
            continue;
        }
        if (turn.abs() - 1.0).abs() > OFF_A_TURN {
            return false;
        }
        of_jumps += turn;
        jumps += 1;
    }
    let counts_turns = of_jumps.abs() > 1.5 && of_jumps * of_motion >= 0.0;
    jumps > 0 && !counts_turns
}

/// Unwraps the angle of a wheel: between two samples, the shorter way is assumed.
fn unwrap_wheel(angle_rad: &mut [f64]) {
    use std::f64::consts::TAU;
    if !is_within_a_turn(angle_rad) && !jumps_by_turns(angle_rad) {
        return;
    }
    let mut turns = 0.0;
    let mut before = angle_rad.first().copied().unwrap_or(0.0);
    for angle in angle_rad.iter_mut() {
        turns -= ((*angle - before) / TAU).round();
        before = *angle;
        *angle += turns * TAU;
    }
}

/// Removes the jumps of a sensor with a range of one turn, and counts them.
///
/// A jump between two samples is a wrap if it is nearer to one full turn than to zero
/// or two turns. Half a turn within one sample is faster than any pendulum at a usable
/// sampling rate; a drop-out from upright to zero is a jump of half a turn. A column that covers more
/// than one turn comes from such a sensor only if its jumps leave no doubt.
fn unwrap_turns(angle_rad: &mut [f64]) -> usize {
    use std::f64::consts::{PI, TAU};
    if !is_within_a_turn(angle_rad) && !jumps_by_turns(angle_rad) {
        return 0;
    }
    let mut turns = 0.0;
    let mut count = 0;
    let mut before = angle_rad.first().copied().unwrap_or(0.0);
    for angle in angle_rad.iter_mut() {
        let jump = *angle - before;
        before = *angle;
        if jump.abs() > 1.5 * PI && jump.abs() < 2.5 * PI {
            turns -= jump.signum();
            count += 1;
        }
        *angle += turns * TAU;
    }
    count
}
