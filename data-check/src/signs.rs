//! One wrong sign contradicts several other columns at once, and each of those comparisons alone can only say that one of
//! its two columns is wrong. Together they say which one: the fewest signs that, turned round, leave no contradiction.
//!
//! This holds for logs in which everything is free. In the others there are only two columns to compare.

use bench_files::{Bench, Channel};
use plant::Kind;

use crate::finding::{Finding, FindingId, Severity};
use crate::law;
use crate::view::{View, spoken};
use crate::wheel::{self, Answers};

/// The channels that have a sign.
const SIGNED: [Channel; 4] = [
    Channel::WheelSpeed,
    Channel::Current,
    Channel::Angle,
    Channel::Rate,
];

/// Two channels, and whether their signs agree.
type Pair = (Channel, Channel, bool);

/// Puts one finding in the place of several about the signs of one log.
pub(crate) fn one_cause(bench: &Bench, view: &View, answers: &Answers, found: &mut Vec<Finding>) {
    if !matches!(view.kind(), Kind::Balance | Kind::Driven) {
        return;
    }
    let is_of_signs = |finding: &Finding| {
        finding.experiment.as_deref() == Some(view.name())
            && finding.severity == Severity::Refuse
            && finding.factor == Some(-1.0)
    };
    let of_signs: Vec<&Finding> = found.iter().filter(|one| is_of_signs(one)).collect();
    if of_signs.is_empty() {
        return;
    }
    let with_wheel = wheel::agrees(view, answers);
    let gains = law::signs(bench, view);
    if gains[2].1 == Some(false) && with_wheel == Some(true) {
        return of_the_gains(found, is_of_signs);
    }
    if of_signs.len() < 2 {
        return;
    }
    let pairs = pairs(view, &of_signs, with_wheel, gains);
    let causes = causes(view, &pairs);
    if causes.is_empty() {
        return;
    }
    // What no statement of the bench enters comes first.
    let order = [
        FindingId::RateFactor,
        FindingId::Gains,
        FindingId::WheelSign,
        FindingId::CurrentSign,
    ];
    let first = order
        .iter()
        .find(|id| of_signs.iter().any(|one| one.finding == **id));
    let Some(first) = first.copied() else { return };
    let contradictions: Vec<String> = pairs
        .iter()
        .filter(|(_, _, agree)| !agree)
        .map(|(a, b, _)| format!("{} and {}", spoken(*a), spoken(*b)))
        .collect();
    let named = causes.iter().map(|cause| {
        let names: Vec<String> = cause.iter().map(|channel| spoken(*channel)).collect();
        names.join(" and ")
    });
    let sentence = format!(
        "the signs of {} contradict each other, with one cause: the wrong sign is that of {} (factor -1)",
        contradictions.join(", of "),
        named.collect::<Vec<String>>().join(", or of ")
    );
    let cures: Vec<String> = causes.iter().map(|cause| cure(view, cause)).collect();
    let finding = Finding::refusal(first, sentence)
        .in_experiment(view.name())
        .with_channel(causes[0][0].key())
        .with_factor(-1.0)
        .with_fix(cures.join("; or "));
    found.retain(|one| !is_of_signs(one));
    found.push(finding);
}

/// The wheel follows the current, but the current not the gains: no column is wrong.
fn of_the_gains(found: &mut [Finding], is_of_signs: impl Fn(&Finding) -> bool) {
    let of_gains = found
        .iter_mut()
        .filter(|finding| is_of_signs(finding) && finding.finding == FindingId::Gains);
    for finding in of_gains {
        let sentence = &finding.sentence;
        finding.sentence = format!("{sentence}; the wheel follows the current, so it is the gain");
        finding.fix = match finding.channel.as_deref() {
            Some("current") | None => "every gain with the other sign (u = −K x)".to_owned(),
            Some(channel) => format!("the gain of {channel} with the other sign (u = −K x)"),
        };
    }
}

/// What is known of the signs, each pair once.
fn pairs(
    view: &View,
    of_signs: &[&Finding],
    with_wheel: Option<bool>,
    gains: [(Channel, Option<bool>); 3],
) -> Vec<Pair> {
    let has = |id: FindingId| of_signs.iter().filter(|one| one.finding == id).count();
    let body = match view.samples(Channel::Angle) {
        Some(_) => Channel::Angle,
        None => Channel::Rate,
    };
    let mut pairs: Vec<Pair> = vec![];
    let mut add = |pair: Pair| {
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    };
    if let Some(agree) = with_wheel {
        add((Channel::WheelSpeed, Channel::Current, agree));
    }
    for (channel, agree) in gains {
        if let Some(agree) = agree {
            add((channel, Channel::Current, agree));
        }
    }
    if has(FindingId::WheelSign) > 0 {
        add((Channel::WheelSpeed, body, false));
    }
    // One of these findings is that of the wheel.
    if has(FindingId::CurrentSign) > usize::from(with_wheel == Some(false)) {
        add((body, Channel::Current, false));
    }
    if view.samples(Channel::Angle).is_some() && view.samples(Channel::Rate).is_some() {
        add((
            Channel::Angle,
            Channel::Rate,
            has(FindingId::RateFactor) == 0,
        ));
    }
    pairs
}

/// The smallest sets of channels that, turned round, make all pairs agree.
fn causes(view: &View, pairs: &[Pair]) -> Vec<Vec<Channel>> {
    let turned = |set: u32, channel: Channel| {
        let mut places = SIGNED.iter();
        let place = places.position(|one| *one == channel);
        place.is_some_and(|place| set & (1 << place) != 0)
    };
    let holds = |set: u32| {
        let mut pairs = pairs.iter();
        pairs.all(|(a, b, agree)| (turned(set, *a) == turned(set, *b)) == *agree)
    };
    let sets = (1..1 << SIGNED.len()).map(|set: u32| {
        let channels = SIGNED.into_iter();
        let channels = channels.filter(|channel| turned(set, *channel));
        (set, channels.collect::<Vec<Channel>>())
    });
    let possible: Vec<Vec<Channel>> = sets
        .filter(|(set, channels)| {
            holds(*set)
                && channels
                    .iter()
                    .all(|channel| view.samples(*channel).is_some())
        })
        .map(|(_, channels)| channels)
        .collect();
    let fewest = possible.iter().map(Vec::len).min();
    let smallest = possible.into_iter();
    smallest
        .filter(|channels| Some(channels.len()) == fewest)
        .collect()
}

/// The text for bench.toml that turns the signs of these channels round.
fn cure(view: &View, channels: &[Channel]) -> String {
    let stated = &view.experiment.report.stated;
    let is_turned = |channel: &Channel| {
        let mut stated = stated.iter().filter(|one| one.channel == *channel);
        stated.any(|one| one.sign == Some(-1.0))
    };
    let table = |channels: Vec<Channel>| {
        let entries: Vec<String> = channels
            .iter()
            .map(|channel| format!("{} = -1", channel.key()))
            .collect();
        format!("sign = {{ {} }}", entries.join(", "))
    };
    let (out, new): (Vec<Channel>, Vec<Channel>) = channels.iter().partition(|c| is_turned(c));
    match (out.is_empty(), new.is_empty()) {
        (true, _) => table(new),
        (false, true) => format!("take {} out", table(out)),
        (false, false) => format!("take {} out and set {}", table(out), table(new)),
    }
}
