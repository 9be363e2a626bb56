//! Channels that never change beside one that does, and a wheel's speed that is held like a command.

use bench_files::Channel;
use identify::noise_std;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::thresholds::constant::{COMMAND_LEVELS, MOVES, SPEED_LEVELS};
use crate::view::{View, largest, levels, range, spoken};

/// Checks for channels that never change, beside one that does. Returns whether the wheel's speed and the current are
/// swapped: then no other comparison means anything.
pub(crate) fn check(view: &View, out: &mut Vec<Finding>) -> bool {
    if are_swapped(view) {
        let sentence = "the wheel's speed is held like a current, and the current changes like a speed: the two columns \
                        are swapped";
        out.push(
            Finding::refusal(FindingId::WheelSpeedFactor, sentence)
                .in_experiment(view.name())
                .with_channel("wheel_speed")
                .with_fix(
                    "columns = { wheel_speed = …, current = … }, each with the other's column",
                ),
        );
        return true;
    }
    let moves = |channel: Channel| {
        let (low, high) = view.samples(channel).and_then(range)?;
        Some(high > low)
    };
    let [angle, rate, wheel] = [Channel::Angle, Channel::Rate, Channel::WheelSpeed].map(moves);
    let mut say = |channel: Channel, make: fn(FindingId, String) -> Finding, beside: &str| {
        let sentence = format!("the {} never changes{beside}", spoken(channel));
        out.push(
            make(FindingId::Frozen, sentence)
                .in_experiment(view.name())
                .with_channel(channel.key())
                .with_fix("name another column, leave this one out, or check the sensor"),
        );
    };
    let refusal: fn(FindingId, String) -> Finding = Finding::refusal;
    match (angle, rate) {
        (Some(true), Some(false)) => say(Channel::Rate, refusal, ", but the angle does"),
        (Some(false), Some(true)) => say(Channel::Angle, refusal, ", but the rate does"),
        (Some(false), None) if wheel != Some(true) => say(Channel::Angle, refusal, ""),
        (Some(false), Some(false)) if wheel != Some(true) => say(Channel::Angle, refusal, ""),
        (None, Some(false)) if wheel != Some(true) => say(Channel::Rate, refusal, ""),
        _ => {}
    }
    // A wheel that its current does not move has dry friction, and its tachometer may say exactly 0.
    let has_current = view
        .samples(Channel::Current)
        .is_some_and(|current| largest(current) > 0.0);
    if wheel == Some(false) && has_current {
        say(
            Channel::WheelSpeed,
            Finding::warning,
            ", although a current flows",
        );
    }
    false
}

/// Whether the wheel's speed is held like a command while the current moves like a speed.
fn are_swapped(view: &View) -> bool {
    let (Some(speed), Some(current)) = (
        view.samples(Channel::WheelSpeed),
        view.samples(Channel::Current),
    ) else {
        return false;
    };
    // A tachometer without power says 0 throughout, and a current has noise.
    view.kind() == Kind::SpinUp
        && largest(speed) > 0.0
        && levels(speed) <= COMMAND_LEVELS
        && levels(current) > SPEED_LEVELS.max(current.len() / 4)
        && range(current).is_some_and(|(low, high)| high - low > MOVES * noise_std(current))
}
