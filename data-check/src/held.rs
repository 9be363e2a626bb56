//! Motion of a joint that this kind of experiment holds still.

use bench_files::Channel;
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::{DEGREES, short};
use crate::thresholds::held::{CLAMPED, CLAMPED_RAD, LOCKED, OVER_NOISE, PLAY_RAD};
use crate::view::{View, median, range};

pub(crate) fn check(view: &View, out: &mut Vec<Finding>) {
    match view.kind() {
        Kind::FreeSwing => locked(view, out),
        Kind::SpinUp => clamped(view, out),
        Kind::Balance | Kind::Driven => {}
    }
}

/// Range of a series without its fast part: range of the medians over blocks of a fiftieth of the log.
fn slow_range(samples: &[f64]) -> Option<f64> {
    let means: Vec<f64> = samples
        .chunks((samples.len() / 50).max(1))
        .filter_map(|block| median(block.to_vec()))
        .collect();
    range(&means).map(|(low, high)| high - low)
}

/// Range from the fifth to the ninety-fifth percentile.
fn usual_range(samples: &[f64]) -> Option<f64> {
    let mut finite: Vec<f64> = samples.iter().copied().filter(|x| x.is_finite()).collect();
    if finite.len() < 20 {
        return None;
    }
    finite.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| finite[((finite.len() - 1) as f64 * share) as usize];
    Some(at(0.95) - at(0.05))
}

/// Differences of the angle divided by the sampling interval, rad/s.
fn speeds(view: &View, angle: &[f64]) -> Vec<f64> {
    let time_s = &view.experiment.log.time_s;
    let pairs = angle.windows(2).zip(time_s.windows(2));
    pairs.map(|(x, t)| (x[1] - x[0]) / (t[1] - t[0])).collect()
}

fn locked(view: &View, out: &mut Vec<Finding>) {
    let beside = &view.experiment.beside;
    let wheel = match (&beside.wheel_speed_rad_s, &beside.wheel_angle_rad) {
        (Some(speed), _) => speed.clone(),
        (None, Some(angle)) => speeds(view, angle),
        (None, None) => return,
    };
    let body = match (view.samples(Channel::Rate), view.samples(Channel::Angle)) {
        (Some(rate), _) => rate.to_vec(),
        (None, Some(angle)) => speeds(view, angle),
        (None, None) => return,
    };
    let (Some(wheel_range), Some(body_range)) = (usual_range(&wheel), usual_range(&body)) else {
        return;
    };
    if wheel_range <= LOCKED * body_range || wheel_range <= OVER_NOISE * identify::noise_std(&wheel)
    {
        return;
    }
    out.push(
        Finding::refusal(
            FindingId::WheelTurns,
            format!(
                "the wheel turns by {} rad/s while the body swings by {} rad/s, but in a free swing it \
                 is locked to the body",
                short(wheel_range),
                short(body_range)
            ),
        )
        .in_experiment(view.name())
        .with_channel("wheel_speed")
        .with_fix("kind = \"driven\" and constants = { current = 0.0 } where the motor is off"),
    );
}

fn clamped(view: &View, out: &mut Vec<Finding>) {
    let beside = &view.experiment.beside;
    let Some(wheel) = view.samples(Channel::WheelSpeed).and_then(usual_range) else {
        return;
    };
    let (moved, refused) = match (&beside.angle_rad, &beside.rate_rad_s) {
        (Some(angle), _) => {
            let way = slow_range(angle).unwrap_or(0.0);
            if way <= PLAY_RAD.max(OVER_NOISE * identify::noise_std(angle)) {
                return;
            }
            // The play of a vice, read from degrees, is some tenths of a radian.
            let or_degrees = if way / DEGREES <= PLAY_RAD {
                ", or by so many degrees, if the unit is not stated,"
            } else {
                ""
            };
            (
                format!("by {} rad{or_degrees}", short(way)),
                way > CLAMPED_RAD,
            )
        }
        (None, Some(rate)) => {
            let speed = usual_range(rate).unwrap_or(0.0);
            if speed <= OVER_NOISE * identify::noise_std(rate) {
                return;
            }
            (
                format!("at up to {} rad/s", short(speed)),
                speed > CLAMPED * wheel,
            )
        }
        (None, None) => return,
    };
    let sentence = format!(
        "the body moves {moved} while the wheel changes its speed by {} rad/s, but in a spin-up it is clamped",
        short(wheel)
    );
    let fix = match view.samples(Channel::Current) {
        Some(_) => "kind = \"driven\"",
        None => "kind = \"driven\" and constants = { current = 0.0 } where the motor is off",
    };
    let finding = if refused {
        Finding::refusal(FindingId::BodyMoves, sentence)
    } else {
        Finding::warning(FindingId::BodyMoves, sentence)
    };
    out.push(
        finding
            .in_experiment(view.name())
            .with_channel("angle")
            .with_fix(fix),
    );
}
