//! Units that nothing states: neither bench.toml, nor the file, nor the name of the column. They are taken for SI. Where
//! the motion shows that this is right, nothing is said.

use std::collections::BTreeSet;

use bench_files::{Channel, UnstatedUnit};
use plant::Kind;

use crate::finding::{Finding, FindingId, Severity};
use crate::view::View;

/// The channels of experiments whose unit was compared with the motion and found right.
#[derive(Clone, Debug, Default)]
pub(crate) struct Settled(BTreeSet<(String, Channel)>);

impl Settled {
    pub fn add(&mut self, view: &View, channel: Channel) {
        self.0.insert((view.name().to_owned(), channel));
    }

    pub fn join(&mut self, mut other: Settled) {
        self.0.append(&mut other.0);
    }

    pub fn has(&self, view: &View, channel: Channel) -> bool {
        self.0.contains(&(view.name().to_owned(), channel))
    }
}

pub(crate) fn check(view: &View, settled: &Settled, out: &mut Vec<Finding>) {
    let unstated = &view.experiment.report.unstated;
    // A log that is refused is checked again when it is mended.
    let is_refused = out.iter().any(|finding| {
        finding.experiment.as_deref() == Some(view.name()) && finding.severity == Severity::Refuse
    });
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
            _ if settled.has(view, one.channel) => {}
            Some(unit) => {
                let make = if has_another_meaning(&one.column) {
                    Finding::warning
                } else {
                    Finding::refusal
                };
                let sentence = format!(
                    "the column \"{}\" is taken to be in {si}, but its name says {unit}",
                    one.column
                );
                out.push(
                    make(FindingId::UnitUnstated, sentence)
                        .in_experiment(view.name())
                        .with_channel(key)
                        .with_fix(format!(
                            "units = {{ {key} = \"{unit}\" }}, or units = {{ {key} = \"{si}\" }} if the name is wrong"
                        )),
                );
            }
            None if is_refused || names_si(&one.column, si) => {}
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

/// Whether the ending of a name that says a unit is usual for something else too: reversed, radians per second, gradient,
/// moving average. Any other ending (`_deg`, `_rpm`, `[mA]`) is the word of whoever wrote the file against a default
/// that nobody wrote: one of the two is wrong, and the motion does not say which.
fn has_another_meaning(column: &str) -> bool {
    let lower = column.to_lowercase();
    let endings = ["_rev", "_rps", "_grad"];
    endings.iter().any(|ending| lower.ends_with(ending)) || column.ends_with("_ma")
}

/// Whether a part of a name is the SI unit, as in `angle_rad_from_pot`.
fn names_si(column: &str, si: &str) -> bool {
    let lower = column.to_lowercase();
    let plain = si.to_lowercase().replace('/', "_");
    lower == plain
        || lower.starts_with(&format!("{plain}_"))
        || lower.contains(&format!("_{plain}_"))
        || lower.ends_with(&format!("_{plain}"))
        || lower.ends_with(&format!("_{plain}s"))
}
