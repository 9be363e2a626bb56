//! Corrections of a proposal that the findings of the check require.

use std::f64::consts::TAU;

use bench_files::Channel;
use plant::Kind;

use super::Draft;
use crate::finding::{Finding, FindingId, Severity};
use crate::kinematics::IS_THE_RATE;
use crate::slips::{DEGREES, RPM};

/// Corrects a draft as a finding requires. Returns `false` if only the user can.
pub(super) fn mend(drafts: &mut [Draft], finding: &Finding) -> bool {
    let concerned = |draft: &&mut Draft| match &finding.experiment {
        Some(name) => draft.name == *name,
        None => draft.kind == Kind::SpinUp,
    };
    let mut changed = false;
    for draft in drafts
        .iter_mut()
        .filter(concerned)
        .filter(|draft| !draft.decided)
    {
        changed |= mend_one(draft, finding);
    }
    changed
}

fn mend_one(draft: &mut Draft, finding: &Finding) -> bool {
    if finding.finding == FindingId::HeldStart || finding.finding == FindingId::Hand {
        let until = finding.fix.strip_prefix("until = ");
        let until = until.and_then(|text| text.split(' ').next()?.parse().ok());
        if let Some(until_s) = until.filter(|until| draft.until_s.is_none_or(|old| *until < old)) {
            draft.until_s = Some(until_s);
            draft
                .questions
                .push(format!("{}: {}", finding.sentence, finding.fix));
            return true;
        }
        let from = finding.fix.strip_prefix("from = ");
        let Some(from_s) = from.and_then(|text| text.parse().ok()) else {
            return false;
        };
        if draft
            .from_s
            .as_ref()
            .is_some_and(|(before, _)| *before >= from_s)
        {
            return false;
        }
        draft.from_s = Some((from_s, finding.sentence.clone()));
        return true;
    }
    if finding.severity != Severity::Refuse {
        return false;
    }
    if finding.fix == IS_THE_RATE {
        return mend_rate(draft, finding);
    }
    if finding.finding == FindingId::AngleZero {
        let offset = finding.fix.strip_prefix("offset = { angle = ");
        let offset = offset.and_then(|text| text.split(" }").next()?.parse::<f64>().ok());
        let Some(offset) = offset.filter(|_| draft.offset_rad.is_none()) else {
            return false;
        };
        draft.offset_rad = Some((offset, finding.sentence.clone()));
        if finding.fix.contains("kind = \"driven\"") {
            draft.kind = Kind::Driven;
            draft.kind_reason = finding.sentence.clone();
        }
        return true;
    }
    if finding.finding == FindingId::Wrapped {
        return mend_wrapped(draft, finding);
    }
    if finding.finding == FindingId::WheelTurns || finding.finding == FindingId::BodyMoves {
        draft.kind = Kind::Driven;
        draft.kind_reason = finding.sentence.clone();
        if !draft
            .mapped
            .iter()
            .any(|one| one.channel == Channel::Current)
        {
            let reason = "the file has no current; if the motor was not off, correct it".to_owned();
            draft.held_current_a = Some((0.0, reason));
        }
        return true;
    }
    let (Some(factor), Some(channel)) = (
        finding.factor,
        finding.channel.as_deref().and_then(Channel::from_key),
    ) else {
        return false;
    };
    let is = |size: f64| (factor / size - 1.0).abs() < 0.01;
    if is(-1.0) {
        // The file does not say which of two channels has the wrong sign.
        draft
            .questions
            .push(format!("{}: {}", finding.sentence, finding.fix));
        if draft.signs.iter().any(|(signed, _)| *signed == channel) {
            return false;
        }
        draft.signs.push((channel, finding.sentence.clone()));
        return true;
    }
    let (channel, unit) = if channel == Channel::Rate && is(1.0 / DEGREES) {
        (Channel::Angle, "deg")
    } else if is(1e3) && matches!(channel, Channel::Time | Channel::Rate) {
        (Channel::Time, "ms")
    } else if is(1e3) && channel == Channel::Angle {
        (Channel::Angle, "mrad")
    } else if is(1.0 / TAU) && channel == Channel::Angle {
        (Channel::Angle, "rev")
    } else if is(1.0 / TAU) {
        (channel, "rev/s")
    } else if is(1e3) && channel == Channel::Current {
        (Channel::Current, "mA")
    } else if is(1e6) {
        (Channel::Time, "us")
    } else if is(DEGREES) && channel == Channel::Angle {
        (Channel::Angle, "deg")
    } else if is(DEGREES) {
        (channel, "deg/s")
    } else if is(RPM) && matches!(channel, Channel::WheelSpeed | Channel::Rate) {
        (channel, "rpm")
    } else {
        return false;
    };
    let Some(mapped) = draft.mapped.iter_mut().find(|one| one.channel == channel) else {
        return false;
    };
    if mapped.unit == Some(unit) {
        return false;
    }
    mapped.unit = Some(unit);
    mapped.reason = finding.sentence.clone();
    true
}

/// What was taken for the wheel's speed is the body's rate. Without a wheel and a current, the log is a free swing.
fn mend_rate(draft: &mut Draft, finding: &Finding) -> bool {
    let mut mapped = draft.mapped.iter_mut();
    let Some(one) = mapped.find(|one| one.channel == Channel::WheelSpeed) else {
        return false;
    };
    one.channel = Channel::Rate;
    one.reason = finding.sentence.clone();
    let is_alone = !draft
        .mapped
        .iter()
        .any(|one| matches!(one.channel, Channel::Current | Channel::WheelAngle));
    if is_alone && draft.kind == Kind::Driven {
        draft.kind = Kind::FreeSwing;
        draft.kind_reason = "the file has the body and not the wheel".to_owned();
        draft.held_current_a = None;
    }
    true
}

/// A sensor that starts again after a turn shows an angle, in the unit in which its range is one.
fn mend_wrapped(draft: &mut Draft, finding: &Finding) -> bool {
    let (Some(turns), Some(channel)) = (
        finding.factor,
        finding.channel.as_deref().and_then(Channel::from_key),
    ) else {
        return false;
    };
    let is = |size: f64| (turns / size - 1.0).abs() < 0.03;
    let unit = [
        (1.0, "rad"),
        (DEGREES, "deg"),
        (1.0 / TAU, "rev"),
        (1e3, "mrad"),
    ]
    .into_iter()
    .find(|(size, _)| is(*size))
    .map(|(_, unit)| unit);
    let has_angle = draft
        .mapped
        .iter()
        .any(|one| one.channel == Channel::WheelAngle);
    let Some(mapped) = draft.mapped.iter_mut().find(|one| one.channel == channel) else {
        return false;
    };
    let Some(unit) = unit else {
        // Counts: only the user knows how many are a turn.
        let question = format!("{}: {}", finding.sentence, finding.fix);
        if !draft.questions.contains(&question) {
            draft.questions.push(question);
        }
        return false;
    };
    let before = (mapped.channel, mapped.unit);
    if channel == Channel::WheelSpeed && !has_angle {
        mapped.channel = Channel::WheelAngle;
    }
    mapped.unit = Some(unit);
    mapped.reason = finding.sentence.clone();
    before != (mapped.channel, mapped.unit)
}
