//! A proposal in parts: the user corrects one part, and the whole is written anew.

use std::collections::BTreeMap;

use bench_files::{Channel, Table, plain_unit};
use plant::Kind;
use serde::{Deserialize, Serialize};

use super::Draft;
use super::columns::Mapped;
use super::kind::HELD_AT_WHAT;

/// The reason that is written beside a line which the user has decided.
const BY_HAND: &str = "corrected by hand";

/// The choices for one file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choices {
    /// The kind of experiment.
    pub kind: String,
    /// Why.
    #[serde(default)]
    pub kind_reason: String,
    /// The columns that are used, at most one a channel.
    pub columns: Vec<ColumnChoice>,
    /// Added to the angle, rad.
    #[serde(default)]
    pub offset_rad: Option<f64>,
    /// The current at which the motor was held, where no column is the current, A.
    #[serde(default)]
    pub held_current_a: Option<f64>,
    /// The first second that is used.
    #[serde(default)]
    pub from_s: Option<f64>,
    /// The last one.
    #[serde(default)]
    pub until_s: Option<f64>,
    /// Seconds from line to line, where no column is the time.
    #[serde(default)]
    pub time_step_s: Option<f64>,
}

/// The channel of a column, with unit, sign and offset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColumnChoice {
    /// The channel: time, angle, rate, wheel_speed, wheel_angle or current.
    pub channel: String,
    /// The column.
    pub column: String,
    /// Its unit; `None`: the SI unit.
    #[serde(default)]
    pub unit: Option<String>,
    /// Whether its sign is the other way round.
    #[serde(default)]
    pub reversed: bool,
    /// Why.
    #[serde(default)]
    pub reason: String,
}

/// The corrections of a user to the proposal for dropped files.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corrections {
    /// Values of `[known]` by their keys.
    #[serde(default)]
    pub known: BTreeMap<String, f64>,
    /// The choices of files, by their names; those of the others are proposed.
    #[serde(default)]
    pub files: BTreeMap<String, Choices>,
}

/// The units that a channel may be in; the first is its SI unit.
pub fn units_of(channel: Channel) -> &'static [&'static str] {
    match channel {
        Channel::Time => &["s", "ms", "us", "ns"],
        Channel::Angle => &["rad", "mrad", "deg", "rev"],
        Channel::WheelAngle => &["rad", "mrad", "deg", "rev"],
        Channel::Rate | Channel::WheelSpeed => &["rad/s", "mrad/s", "deg/s", "rpm", "rev/s"],
        Channel::Current => &["A", "mA"],
    }
}

impl Draft {
    /// The choices that the draft makes.
    pub(super) fn choices(&self) -> Choices {
        Choices {
            kind: self.kind.name().to_owned(),
            kind_reason: self.kind_reason.clone(),
            columns: self
                .mapped
                .iter()
                .map(|one| {
                    let sign = self.signs.iter().find(|(signed, _)| *signed == one.channel);
                    ColumnChoice {
                        channel: one.channel.key().to_owned(),
                        column: one.column.clone(),
                        unit: one.unit.map(str::to_owned),
                        reversed: sign.is_some(),
                        reason: match sign {
                            Some((_, reason)) => format!("{}; {reason}", one.reason),
                            None => one.reason.clone(),
                        },
                    }
                })
                .collect(),
            offset_rad: self.offset_rad.as_ref().map(|(value, _)| *value),
            held_current_a: self.held_current_a.as_ref().map(|(value, _)| *value),
            from_s: self.from_s.as_ref().map(|(value, _)| *value),
            until_s: self.until_s,
            time_step_s: self.time_step_s,
        }
    }

    /// Replaces the proposal by the user's choices. A choice that equals the proposal keeps the
    /// reason of the proposal.
    ///
    /// # Errors
    /// A sentence: a kind, a channel, a column or a unit that is none; a column that is used twice.
    pub(super) fn choose(&mut self, choices: &Choices, table: &Table) -> Result<(), String> {
        let before = self.choices();
        let kind = Kind::from_name(&choices.kind);
        self.kind = kind.ok_or_else(|| {
            format!(
                "{}: \"{}\" is no kind of experiment",
                self.file, choices.kind
            )
        })?;
        if choices.kind != before.kind {
            self.kind_reason = BY_HAND.to_owned();
        }
        let mut mapped: Vec<Mapped> = vec![];
        let mut signs = vec![];
        for choice in &choices.columns {
            let (one, sign) = self.chosen(choice, &before, table)?;
            if mapped
                .iter()
                .any(|other| other.channel == one.channel || other.index == one.index)
            {
                return Err(format!(
                    "{}: each channel has one column, and each column one channel: \"{}\" is used twice",
                    self.file, one.column
                ));
            }
            signs.extend(sign.map(|reason| (one.channel, reason)));
            mapped.push(one);
        }
        self.unused = (0..table.names.len())
            .filter(|index| !mapped.iter().any(|one| one.index == *index))
            .map(|index| table.names[index].clone())
            .collect();
        (self.mapped, self.signs) = (mapped, signs);
        let kept = |value: Option<f64>, old: &Option<(f64, String)>| {
            let value = value?;
            let reason = match old {
                Some((before, reason)) if *before == value => reason.clone(),
                _ => BY_HAND.to_owned(),
            };
            Some((value, reason))
        };
        self.offset_rad = kept(choices.offset_rad, &self.offset_rad);
        self.held_current_a = kept(choices.held_current_a, &self.held_current_a);
        self.from_s = kept(choices.from_s, &self.from_s);
        self.until_s = choices.until_s;
        self.time_step_s = choices.time_step_s;
        if self.held_current_a.is_some() {
            self.questions.retain(|question| question != HELD_AT_WHAT);
        }
        self.decided = true;
        Ok(())
    }

    /// A column as it is chosen, with the reason of its sign where that is reversed.
    fn chosen(
        &self,
        choice: &ColumnChoice,
        before: &Choices,
        table: &Table,
    ) -> Result<(Mapped, Option<String>), String> {
        let file = &self.file;
        let channel = Channel::from_key(&choice.channel)
            .ok_or_else(|| format!("{file}: \"{}\" is no channel", choice.channel))?;
        let index = table.names.iter().position(|name| *name == choice.column);
        let index = index.ok_or_else(|| format!("{file} has no column \"{}\"", choice.column))?;
        let unit = match &choice.unit {
            None => None,
            Some(unit) => Some(
                plain_unit(unit)
                    .or_else(|| {
                        units_of(channel)
                            .iter()
                            .copied()
                            .find(|known| known == unit)
                    })
                    .filter(|unit| units_of(channel).contains(unit))
                    .ok_or_else(|| {
                        let known = units_of(channel).join(", ");
                        format!(
                            "{file}: \"{unit}\" is no unit of {}; known are {known}",
                            choice.channel
                        )
                    })?,
            ),
        };
        let old = before
            .columns
            .iter()
            .find(|old| old.channel == choice.channel);
        let same = |part: bool| old.is_some_and(|old| old.column == choice.column) && part;
        let unit_is_kept = old.is_some_and(|old| old.unit == choice.unit);
        let own = self.mapped.iter().find(|one| one.channel == channel);
        let reason = match own {
            Some(one) if same(unit_is_kept) => one.reason.clone(),
            _ => BY_HAND.to_owned(),
        };
        let sign = choice.reversed.then(|| {
            let known = self.signs.iter().find(|(signed, _)| *signed == channel);
            known.map_or_else(
                || format!("sign of {}: {BY_HAND}", channel.key()),
                |(_, reason)| reason.clone(),
            )
        });
        let mapped = Mapped {
            channel,
            index,
            column: choice.column.clone(),
            unit,
            reason,
        };
        Ok((mapped, sign))
    }
}
