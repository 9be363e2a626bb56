//! A channel that starts again from the other end of its range: a wheel or a body that turns on, seen by a sensor with
//! a range of one turn.

use std::f64::consts::TAU;

use bench_files::Channel;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::thresholds::sawtooth::{ALIKE, FEWEST, FITTING, JUMP, NEAR};
use crate::view::{median, range, spoken};

/// Counts a turn of usual encoders.
const COUNTS: [f64; 12] = [
    1000.0, 1024.0, 2000.0, 2048.0, 4000.0, 4096.0, 8192.0, 10_000.0, 16_384.0, 32_768.0, 65_536.0,
    512.0,
];

/// The jumps of a channel.
struct Sawtooth {
    jumps: usize,
    /// The range of the sensor, in the channel's SI unit.
    turn: f64,
}

/// The jumps of a series that goes on in one direction, jumps back by its range, and goes on in the direction that it
/// had. A motion that really jumps does not move against its own jump before and after it.
fn sawtooth(samples: &[f64]) -> Option<Sawtooth> {
    let (low, high) = range(samples)?;
    let steps: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let is_jump = |k: usize| steps[k].abs() > JUMP * (high - low);
    let jumps: Vec<usize> = (1..steps.len().saturating_sub(1))
        .filter(|k| is_jump(*k))
        .collect();
    if jumps.len() < FEWEST {
        return None;
    }
    let turns: Vec<f64> = jumps
        .iter()
        .filter(|k| !is_jump(**k - 1) && !is_jump(**k + 1))
        .filter_map(|&k| {
            let motion = 0.5 * (steps[k - 1] + steps[k + 1]);
            let goes_on = steps[k - 1] * steps[k] < 0.0 && steps[k + 1] * steps[k] < 0.0;
            goes_on.then(|| (steps[k] - motion).abs())
        })
        .collect();
    let turn = median(turns.clone())?;
    let alike = turns
        .iter()
        .filter(|one| (*one / turn - 1.0).abs() < ALIKE)
        .count();
    (alike >= FEWEST && alike as f64 >= FITTING * jumps.len() as f64).then_some(Sawtooth {
        jumps: jumps.len(),
        turn,
    })
}

/// Whether a column without a stated unit starts again after a range that is no turn in SI, or is an angle where a
/// speed should be.
pub(crate) fn check(channel: Channel, samples: &[f64]) -> Option<Finding> {
    let found = sawtooth(samples)?;
    let spoken = spoken(channel);
    let sentence = format!(
        "the {spoken} jumps {} times by {} within one sample while the motion goes on: the sensor starts again from the \
         other end of its range",
        found.jumps,
        short(found.turn)
    );
    let angle = if channel == Channel::WheelSpeed {
        "wheel_angle"
    } else {
        channel.key()
    };
    let (unit, unit_fix) = unit(found.turn, angle);
    let refusal = |sentence: String| Finding::refusal(FindingId::Wrapped, sentence);
    Some(match channel {
        Channel::Angle | Channel::WheelAngle => refusal(format!("{sentence}{unit}"))
            .with_factor(found.turn / TAU)
            .with_fix(unit_fix),
        Channel::WheelSpeed => refusal(format!(
            "{sentence}, so that it is the wheel's angle and not its speed{unit}"
        ))
        .with_factor(found.turn / TAU)
        .with_fix(format!(
            "columns = {{ wheel_angle = … }} in the place of wheel_speed{}",
            match unit_fix.as_str() {
                SAMPLED_TOO_SLOWLY => String::new(),
                fix => format!(", with {fix}"),
            }
        )),
        _ => refusal(format!(
            "{sentence}, as a number does that has too few bits"
        ))
        .with_fix("use a larger range of the sensor, or exclude that part with from and until"),
    })
}

/// Said where the range is a turn in the stated unit, and still was not unwrapped.
const SAMPLED_TOO_SLOWLY: &str = "log faster: several samples in every quarter of a turn";

/// The unit in which this range is a turn: for the sentence, and as text for bench.toml.
fn unit(turn: f64, channel: &str) -> (String, String) {
    let near = |size: f64| (turn / size - 1.0).abs() < NEAR;
    let in_unit = |unit: &str| format!("units = {{ {channel} = \"{unit}\" }}");
    if near(TAU) {
        return (String::new(), SAMPLED_TOO_SLOWLY.to_owned());
    }
    for (size, unit) in [(360.0, "deg"), (1.0, "rev"), (1e3 * TAU, "mrad")] {
        if near(size) {
            return (
                format!(", at {}: it is in {unit}", short(turn)),
                in_unit(unit),
            );
        }
    }
    let nearest = COUNTS.into_iter().min_by(|a, b| {
        let off = |size: &f64| (turn / size).ln().abs();
        off(a).total_cmp(&off(b))
    });
    match nearest.filter(|size| near(*size)) {
        Some(counts) => (
            format!(
                ": it is in counts of {counts} a turn, or of another number near {}",
                short(turn)
            ),
            format!(
                "scale = {{ {channel} = {:.6e} }} (2 pi / {counts})",
                TAU / counts
            ),
        ),
        None => (
            String::new(),
            format!(
                "scale = {{ {channel} = … }}: 2 pi divided by the sensor's counts a turn (here about {:.4e})",
                TAU / turn
            ),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turning(turn: f64, step: f64) -> Vec<f64> {
        (0..400)
            .map(|k| (step * turn * f64::from(k)).rem_euclid(turn))
            .collect()
    }

    #[test]
    fn a_sawtooth_tells_its_range() {
        for (turn, step, part) in [
            (360.0, 0.03, "\"deg\""),
            (1.0, 0.2, "\"rev\""),
            (4096.0, 0.11, "1.533981e-3"),
            (6283.2, 0.05, "\"mrad\""),
        ] {
            let found = check(Channel::WheelAngle, &turning(turn, step)).expect("a sawtooth");
            assert!(found.fix.contains(part), "{found:?}");
            let found = check(Channel::WheelSpeed, &turning(turn, step)).expect("a sawtooth");
            assert!(found.fix.contains("wheel_angle"), "{found:?}");
        }
    }

    #[test]
    fn a_square_wave_is_none() {
        let square: Vec<f64> = (0..400)
            .map(|k| {
                let level = if (k / 40) % 2 == 0 { 1.0 } else { -1.0 };
                level * (1.0 - (-f64::from(k % 40) / 10.0).exp() * 0.1)
            })
            .collect();
        assert_eq!(check(Channel::WheelSpeed, &square), None);
    }
}
