//! What bench.toml says already about a column of which a finding says that it has another unit or sign. A key that
//! stands there and makes just the factor of the finding is the likely cause: whoever wrote it meant a column in another
//! unit than this one. No cure may ask for what stands there.

use bench_files::{Channel, Stated};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::slips::short;
use crate::view::{View, spoken};

/// Looks at what bench.toml states about the channels of the findings, and mends their cures.
pub(crate) fn mend(views: &[View], found: &mut [Finding]) {
    for finding in found {
        let Some(factor) = finding.factor else {
            continue;
        };
        let about: Vec<&View> = match &finding.experiment {
            Some(name) => views.iter().filter(|view| view.name() == name).collect(),
            // Only the spin-ups are judged together.
            None => {
                let spin_ups = views.iter().filter(|view| view.kind() == Kind::SpinUp);
                spin_ups.collect()
            }
        };
        // `signs` has looked there itself.
        if finding.fix.starts_with("take ") {
            continue;
        }
        let culprits = culprits(finding, factor);
        let undone = culprits.iter().find_map(|(channel, factor)| {
            let key = about
                .iter()
                .find_map(|view| key_that_makes(stated(view, *channel)?, *factor))?;
            Some((*channel, *factor, key))
        });
        if let Some((channel, factor, key)) = undone {
            let others = without_key(views, finding, channel);
            taken_out(finding, channel, factor, &key, &others);
        } else if let [view] = about.as_slice()
            && let Some(channel) = finding.channel.as_deref().and_then(Channel::from_key)
            && let Some(stated) = stated(view, channel)
            && finding
                .fix
                .contains(&format!("units = {{ {}", channel.key()))
        {
            in_the_place_of(finding, stated, factor);
        }
    }
}

fn stated<'v>(view: &View<'v>, channel: Channel) -> Option<&'v Stated> {
    let mut stated = view.experiment.report.stated.iter();
    stated.find(|one| one.channel == channel)
}

/// The channels that can cause a finding, each with the factor by which its samples would be too large.
fn culprits(finding: &Finding, factor: f64) -> Vec<(Channel, f64)> {
    let channel = finding.channel.as_deref().and_then(Channel::from_key);
    let Some(channel) = channel else {
        return vec![];
    };
    let own = (channel, factor);
    match (finding.finding, channel) {
        // A derivative is too small by what its angle is, or by what the time is too large.
        (FindingId::RateFactor, Channel::Rate) => {
            vec![own, (Channel::Angle, 1.0 / factor), (Channel::Time, factor)]
        }
        (FindingId::WheelSpeedFactor, Channel::WheelSpeed) => vec![
            own,
            (Channel::Current, 1.0 / factor),
            (Channel::Time, 1.0 / factor),
        ],
        (FindingId::WheelSpeedFactor | FindingId::CurrentFactor, Channel::Current) => vec![
            own,
            (Channel::WheelSpeed, 1.0 / factor),
            (Channel::Time, factor),
        ],
        (FindingId::CurrentSign, Channel::Current) => vec![own, (Channel::WheelSpeed, factor)],
        _ => vec![own],
    }
}

/// The key of bench.toml that makes the samples too large by `factor`, as it is written there.
fn key_that_makes(stated: &Stated, factor: f64) -> Option<String> {
    let key = stated.channel.key();
    let makes = |made: f64| (made / factor - 1.0).abs() < 0.01 && made != 1.0;
    if let Some(sign) = stated.sign
        && makes(sign)
    {
        return Some(format!("sign = {{ {key} = {sign} }}"));
    }
    if let Some(unit) = stated.unit
        && makes(stated.to_si)
    {
        return Some(format!("units = {{ {key} = \"{unit}\" }}"));
    }
    let scale = stated.scale.filter(|scale| makes(*scale))?;
    Some(format!("scale = {{ {key} = {scale} }}"))
}

/// The other logs of the wheel, without a word about this channel: of a log that differs from them by a unit, either it
/// has the key for nothing or they lack it.
fn without_key<'v>(views: &'v [View], finding: &Finding, channel: Channel) -> Vec<&'v str> {
    let Some(name) = &finding.experiment else {
        return vec![];
    };
    if finding.finding != FindingId::WheelSpeedFactor {
        return vec![];
    }
    let others = views.iter().filter(|view| {
        let lacks = |stated: &Stated| stated.unit.is_none() && stated.scale.is_none();
        view.kind() == Kind::SpinUp
            && view.name() != name
            && stated(view, channel).is_some_and(lacks)
    });
    others.map(View::name).collect()
}

fn taken_out(finding: &mut Finding, channel: Channel, factor: f64, key: &str, lacking: &[&str]) {
    let makes = if factor == -1.0 {
        "makes just that difference".to_owned()
    } else if factor < 1.0 {
        format!(
            "makes the {} {} times smaller",
            spoken(channel),
            short(1.0 / factor)
        )
    } else {
        format!(
            "makes the {} {} times larger",
            spoken(channel),
            short(factor)
        )
    };
    finding.sentence = format!("{}; but {key} in bench.toml {makes}", finding.sentence);
    // What names the same key would set it anew, or ask for what stands there.
    let own = format!("{{ {}", channel.key());
    let others = match finding.fix.contains(&own) {
        true if !lacking.is_empty() => {
            format!(
                "; or, if it is right, state it in the other logs of the wheel too: {}",
                lacking.join(", ")
            )
        }
        true => String::new(),
        false => format!("; or, if that is right, {}", finding.fix),
    };
    finding.fix = format!("take {key} out{others}");
}

/// Units are no factors on top of each other: the new one stands where the old one stood.
fn in_the_place_of(finding: &mut Finding, stated: &Stated, factor: f64) {
    let (key, Some(now)) = (stated.channel.key(), stated.unit) else {
        return;
    };
    let right = stated.channel.unit_with(stated.to_si / factor.abs());
    let place = format!("in the place of \"{now}\"");
    finding.fix = match right {
        Some(unit) if unit == now => return,
        Some(unit) => format!("units = {{ {key} = \"{unit}\" }} {place}"),
        None => return,
    };
}
