//! The assignment of a log's columns to channels.

use plant::Kind;

use super::{ExperimentPlan, find};
use crate::channel::Channel;
use crate::csv_table::OpenTable;
use crate::error::{Error, Names, Problem};
use crate::log::{ColumnUse, Note, Stated, UnstatedUnit};
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};
use crate::units_in_text::unit_of_name;

/// The channels that a kind of experiment uses. Other columns are not read, so that they cannot cause an error.
pub(super) fn useful(kind: Kind) -> &'static [Channel] {
    match kind {
        Kind::FreeSwing => &[Channel::Time, Channel::Angle, Channel::Rate],
        Kind::SpinUp => &[
            Channel::Time,
            Channel::WheelSpeed,
            Channel::WheelAngle,
            Channel::Current,
        ],
        Kind::Balance | Kind::Driven => &Channel::ALL,
    }
}

/// The channels of which a kind of experiment needs at least one, apart from time and current.
fn motion_needed(kind: Kind) -> (&'static [Channel], &'static str) {
    match kind {
        Kind::FreeSwing | Kind::Balance => (
            &[Channel::Angle, Channel::Rate],
            "the body's angle or its rate",
        ),
        Kind::SpinUp => (
            &[Channel::WheelSpeed, Channel::WheelAngle],
            "the wheel's speed",
        ),
        Kind::Driven => (
            &[Channel::Angle, Channel::WheelSpeed, Channel::WheelAngle],
            "the body's angle or the wheel's speed",
        ),
    }
}

impl ExperimentPlan {
    /// Notes on units that were taken from the file's own line of units.
    pub(super) fn units_of_file(&self, table: &OpenTable, uses: &[ColumnUse]) -> Vec<Note> {
        let found = uses.iter().filter_map(|column| {
            let channel = column.channel;
            let (unit, scale) = unit_of_file(table, channel, &column.name)?;
            let is_news = find(&self.units, channel).is_none() && scale != 1.0;
            is_news.then_some(Note::UnitFromFile { channel, unit })
        });
        found.collect()
    }

    /// The columns whose unit neither bench.toml nor the file states, so that they are taken for SI. A factor in
    /// `scale` states what the numbers are, and a standard name its unit.
    pub(super) fn unstated_units(&self, uses: &[ColumnUse]) -> Vec<UnstatedUnit> {
        let unstated = uses.iter().filter(|column| {
            column.stated_unit.is_none()
                && column.name != column.channel.standard_name()
                && find(&self.scales, column.channel).is_none()
        });
        unstated
            .map(|column| UnstatedUnit {
                channel: column.channel,
                column: column.name.clone(),
                name_says: unit_of_name(&column.name)
                    .filter(|unit| column.channel.units().iter().any(|(name, _)| name == unit)),
            })
            .collect()
    }

    /// What bench.toml states about the numbers of the columns.
    pub(super) fn stated(&self, uses: &[ColumnUse]) -> Vec<Stated> {
        let of = |column: &ColumnUse| {
            let channel = column.channel;
            let value = |list| find(list, channel).map(|one: &Located<f64>| one.value);
            Stated {
                channel,
                unit: value(&self.units).and_then(|scale| channel.unit_with(scale)),
                to_si: column.stated_unit.unwrap_or(1.0),
                scale: value(&self.scales),
                sign: value(&self.signs),
            }
        };
        uses.iter().map(of).collect()
    }

    /// The column of each channel. All errors in this mapping are reported here.
    pub(super) fn column_uses(
        &self,
        source: &TomlSource,
        section: &Section,
        log: &OpenTable,
    ) -> Result<Vec<ColumnUse>, Error> {
        let present = log.columns();
        for (channel, column) in &self.columns {
            if !present.contains(&column.value) {
                return Err(source.error(
                    column.span.clone(),
                    Problem::MappedColumnMissing {
                        key: channel.key(),
                        column: column.value.clone(),
                        file: self.file_key.value.clone(),
                        names: Names::new(present),
                    },
                ));
            }
        }
        let column_of = |channel: Channel| -> Option<&str> {
            match find(&self.columns, channel) {
                Some(column) => Some(column.value.as_str()),
                None => present
                    .iter()
                    .map(String::as_str)
                    .find(|name| *name == channel.standard_name()),
            }
        };
        if let (Some(held), Some(column)) = (&self.held_current, column_of(Channel::Current)) {
            return Err(source.error(
                held.span.clone(),
                Problem::ConstantAndColumn {
                    value: held.value,
                    column: column.to_string(),
                    file: self.file_key.value.clone(),
                },
            ));
        }
        if let (Some(step), Some(column)) = (&self.time_step, column_of(Channel::Time)) {
            return Err(source.error(
                step.span.clone(),
                Problem::TimeStepAndColumn {
                    column: column.to_string(),
                    file: self.file_key.value.clone(),
                },
            ));
        }
        for (index, (channel, column)) in self.columns.iter().enumerate() {
            let mut before = self.columns[..index].iter();
            if let Some((other, _)) = before.find(|(_, other)| other.value == column.value) {
                return Err(source.error(
                    column.span.clone(),
                    Problem::ColumnMappedTwice {
                        column: column.value.clone(),
                        first: other.key(),
                        second: channel.key(),
                    },
                ));
            }
        }
        for (key, list) in [
            ("units", &self.units),
            ("scale", &self.scales),
            ("sign", &self.signs),
            ("offset", &self.offsets),
        ] {
            for (channel, located) in list {
                if column_of(*channel).is_none() {
                    let problem = Problem::NoColumnFor {
                        key: channel.key().to_string(),
                        present: present.to_vec(),
                    };
                    // The section exists: the entry was read from it.
                    return Err(match section.section(key)? {
                        Some(table) => table.error_at(channel.key(), problem),
                        None => source.error(located.span.clone(), problem),
                    });
                }
            }
        }

        let used = useful(self.kind);
        let uses: Vec<ColumnUse> = Channel::ALL
            .into_iter()
            .filter_map(|channel| {
                let name = column_of(channel)?.to_string();
                let stated = |list| find(list, channel).map(|one: &Located<f64>| one.value);
                let factor = |list| stated(list).unwrap_or(1.0);
                // A unit in bench.toml takes precedence over one in the file.
                let of_file = unit_of_file(log, channel, &name).map(|(_, scale)| scale);
                let unit = stated(&self.units).or(of_file);
                Some(ColumnUse {
                    channel,
                    name,
                    scale: unit.unwrap_or(1.0) * factor(&self.scales) * factor(&self.signs),
                    stated_unit: unit,
                    is_beside: !used.contains(&channel),
                    offset: find(&self.offsets, channel).map_or(0.0, |offset| offset.value),
                })
            })
            .collect();
        let has = |channel: Channel| {
            let mut used = uses.iter().filter(|column| !column.is_beside);
            used.any(|column| column.channel == channel)
        };
        let missing = |channels: &[Channel], needs: &'static str, remark: &'static str| {
            let used: Vec<&str> = uses.iter().map(|column| column.name.as_str()).collect();
            let channel = channels[0];
            log.header_error(
                None,
                Problem::MissingColumn {
                    experiment: self.name.value.clone(),
                    kind: self.kind.name(),
                    needs,
                    present: present.to_vec(),
                    standard_names: channels.iter().map(|c| c.standard_name()).collect(),
                    key: channel.key(),
                    column: channel
                        .likely_column(present, &used)
                        .unwrap_or("its name there")
                        .to_string(),
                    remark: if log.has_header() {
                        remark
                    } else {
                        "; the file has no header line, so that its columns are numbered from 1"
                    },
                },
            )
        };
        if !has(Channel::Time) && self.time_step.is_none() {
            return Err(missing(
                &[Channel::Time],
                "the time",
                "; for a log without a time column, state the time from row to row: time_step = 0.005 (s)",
            ));
        }
        let (channels, needs) = motion_needed(self.kind);
        if !channels.iter().any(|channel| has(*channel)) {
            return Err(missing(channels, needs, ""));
        }
        let needs_current = matches!(self.kind, Kind::Balance | Kind::Driven);
        if needs_current && !has(Channel::Current) && self.held_current.is_none() {
            return Err(missing(
                &[Channel::Current],
                "the motor current",
                "; state a current that was held and not logged as constants = { current = 0.6 }",
            ));
        }
        Ok(uses)
    }
}

/// The unit of a channel from its file's line of units, with its factor to SI.
fn unit_of_file(table: &OpenTable, channel: Channel, column: &str) -> Option<(&'static str, f64)> {
    let unit = table.unit(column)?;
    channel
        .units()
        .iter()
        .find(|(name, _)| *name == unit)
        .copied()
}
