//! Units that nothing states: neither bench.toml, nor the file, nor the name of the column. They are taken for SI. Where
//! the motion shows that this is right, nothing is said.

use std::collections::BTreeSet;

use bench_files::{Channel, UnstatedUnit};
use plant::Kind;

use crate::finding::{Finding, FindingId};
use crate::view::View;

/// The channels of experiments whose unit was compared with the motion and found right.
#[derive(Debug, Default)]
pub(crate) struct Settled(BTreeSet<(String, Channel)>);

impl Settled {
    pub fn add(&mut self, view: &View, channel: Channel) {
        self.0.insert((view.name().to_owned(), channel));
    }

    pub fn has(&self, view: &View, channel: Channel) -> bool {
        self.0.contains(&(view.name().to_owned(), channel))
    }
}

pub(crate) fn check(view: &View, settled: &Settled, out: &mut Vec<Finding>) {
    let unstated = &view.experiment.report.unstated;
    for one in unstated {
        let key = one.channel.key();
        let is_said = out.iter().any(|finding| {
            finding.experiment.as_deref() == Some(view.name())
                && finding.factor.is_some()
                && finding.channel.as_deref() == Some(key)
        });
        if one.channel == Channel::Time || is_said || !is_used(view, one) {
            continue;
        }
        let si = one.channel.si_unit();
        match one.name_says {
            Some(unit) if unit == si => {}
            Some(unit) => out.push(
                Finding::refusal(
                    FindingId::UnitUnstated,
                    format!(
                        "the column \"{}\" is taken to be in {si}, but its name says {unit}",
                        one.column
                    ),
                )
                .in_experiment(view.name())
                .with_channel(key)
                .with_fix(format!(
                    "units = {{ {key} = \"{unit}\" }}, or units = {{ {key} = \"{si}\" }} if the name is wrong"
                )),
            ),
            None if settled.has(view, one.channel) || names_si(&one.column, si) => {}
            None => out.push(
                Finding::warning(
                    FindingId::UnitUnstated,
                    format!(
                        "nothing states the unit of the column \"{}\", and this log cannot tell it: it is taken to be \
                         in {si}",
                        one.column
                    ),
                )
                .in_experiment(view.name())
                .with_channel(key)
                .with_fix(format!("units = {{ {key} = \"{si}\" }} if that is right")),
            ),
        }
    }
}

/// Whether the experiment's kind uses the channel: what stands still has no unit to be wrong.
fn is_used(view: &View, one: &UnstatedUnit) -> bool {
    match view.kind() {
        Kind::FreeSwing | Kind::SpinUp => view.samples(one.channel).is_some(),
        Kind::Balance | Kind::Driven => true,
    }
}

/// Whether a part of a name is the SI unit, as in `angle_rad_from_pot`.
fn names_si(column: &str, si: &str) -> bool {
    let lower = column.to_lowercase();
    let plain = si.to_lowercase().replace('/', "_");
    lower == plain
        || lower.starts_with(&format!("{plain}_"))
        || lower.contains(&format!("_{plain}_"))
        || lower.ends_with(&format!("_{plain}"))
}
