//! One experiment of bench.toml: what its entries say, and the log read as they say.

mod columns;
mod upright;

use std::path::{Path, PathBuf};

use plant::Kind;

use crate::channel::{Channel, NORMALISED};
use crate::csv_table;
use crate::error::{Error, Names, Problem};
use crate::experiment::{CurrentMeaning, Experiment};
use crate::files::Files;
use crate::keys;
use crate::log::{self, Note};
use crate::toml_section::Section;
use crate::toml_source::{Located, TomlSource};

/// The entries of bench.toml for one experiment.
pub(crate) struct ExperimentPlan {
    pub(crate) name: Located<String>,
    kind: Kind,
    file_key: Located<String>,
    file: PathBuf,
    columns: Vec<(Channel, Located<String>)>,
    units: Vec<(Channel, Located<f64>)>,
    scales: Vec<(Channel, Located<f64>)>,
    signs: Vec<(Channel, Located<f64>)>,
    offsets: Vec<(Channel, Located<f64>)>,
    held_current: Option<Located<f64>>,
    /// Whether the current column is a command without a unit.
    normalised: bool,
    current_meaning: CurrentMeaning,
    window: log::Window,
    time_step: Option<Located<f64>>,
    accept: Vec<String>,
}

impl ExperimentPlan {
    /// Reads the section `[[experiment]]`, without opening the log.
    ///
    /// # Errors
    /// The first entry that is wrong.
    pub(crate) fn read(section: &Section, folder: &Path) -> Result<ExperimentPlan, Error> {
        section.allow_only(&keys::names(keys::BENCH, "experiment"))?;
        let name = section.required_text("name", "name = \"free swing 20 deg\"")?;
        let kind_name = section.required_text(
            "kind",
            "kind = \"free-swing\" (or spin-up, balance, driven)",
        )?;
        let kind = Kind::from_name(&kind_name.value).ok_or_else(|| {
            section.error_at(
                "kind",
                Problem::UnknownName {
                    what: "kind of experiment".to_string(),
                    name: kind_name.value.clone(),
                    names: Names::new(Kind::ALL.map(Kind::name)),
                },
            )
        })?;
        let file_key = section.required_text("file", "file = \"free-swing-20deg.csv\"")?;
        let file = folder.join(&file_key.value);

        let current_meaning = match section.text("current_meaning")? {
            None => CurrentMeaning::Command,
            Some(text) => match text.value.as_str() {
                "command" => CurrentMeaning::Command,
                "measured" => CurrentMeaning::Measured,
                _ => {
                    return Err(section.error_at(
                        "current_meaning",
                        Problem::UnknownName {
                            what: "current_meaning".to_string(),
                            name: text.value,
                            names: Names::new(["command", "measured"]),
                        },
                    ));
                }
            },
        };
        let from_s = section.number("from")?;
        let until_s = section.number("until")?;
        let time_step = section.positive_number("time_step")?;
        if let (Some(from), Some(until)) = (&from_s, &until_s)
            && from.value >= until.value
        {
            return Err(section.error_at(
                "until",
                Problem::WindowReversed {
                    from_s: from.value,
                    until_s: until.value,
                },
            ));
        }
        Ok(ExperimentPlan {
            columns: by_channel(section, "columns", |table, key| {
                table.required_text(key, "the name of a column")
            })?,
            units: by_channel(section, "units", unit_scale)?,
            scales: by_channel(section, "scale", |table, key| {
                not_zero(table, key, "a factor other than 0")
            })?,
            signs: by_channel(section, "sign", |table, key| {
                not_zero(table, key, "1 or -1")
            })?,
            offsets: by_channel(section, "offset", |table, key| {
                require(table.number(key)?, table, key)
            })?,
            held_current: held_current(section, kind)?,
            normalised: is_normalised(section)?,
            window: log::Window {
                from_s: from_s.map(|from| from.value),
                until_s: until_s.map(|until| until.value),
                time_step_s: time_step.as_ref().map(|step| step.value),
                measured_current: current_meaning == CurrentMeaning::Measured,
            },
            time_step,
            accept: section
                .texts("accept")?
                .unwrap_or_default()
                .into_iter()
                .map(|finding| finding.value)
                .collect(),
            name,
            kind,
            file_key,
            file,
            current_meaning,
        })
    }

    /// Reads the log and checks it.
    ///
    /// # Errors
    /// The first thing that is wrong with the log, or with an entry that the log contradicts.
    pub(crate) fn load(
        self,
        files: Files,
        source: &TomlSource,
        section: &Section,
    ) -> Result<Experiment, Error> {
        let table = csv_table::open(files, &self.file).map_err(|error| match error.problem() {
            // The error points to the entry `file`, which is what the user must correct.
            Problem::NotFound | Problem::NotAFile { .. } => source.error(
                self.file_key.span.clone(),
                Problem::NoLog {
                    path: self.file.display().to_string(),
                    reason: error.problem().to_string(),
                },
            ),
            _ => error,
        })?;
        let uses = self.column_uses(source, section, &table)?;
        let of_file = self.units_of_file(&table, &uses);
        let unstated = self.unstated_units(&uses);
        let stated = self.stated(&uses);
        let log::SamplesOfLog {
            log: mut samples,
            beside,
            mut report,
            in_cells,
        } = log::read(table, &uses, self.window)?;
        report.notes.extend(of_file);
        let unstated = unstated.into_iter();
        let unstated = unstated.filter(|one| !in_cells.contains(&one.channel));
        report.unstated = unstated.collect();
        report.stated = stated;

        for (channel, sign) in &self.signs {
            if sign.value.abs() != 1.0 {
                report.notes.push(Note::SignIsAFactor {
                    channel: *channel,
                    factor: sign.value,
                });
            }
        }
        if self.normalised {
            report.notes.push(Note::NormalisedCommand);
        }
        if let Some(current) = &self.held_current
            && columns::useful(self.kind).contains(&Channel::Current)
        {
            samples.current_a = Some(vec![current.value; samples.len()]);
        }
        if self.kind == Kind::SpinUp && samples.current_a.is_none() {
            report.notes.push(Note::CurrentNotRecorded);
        }
        self.check_upright(section, &mut samples, &mut report)?;
        let line = source.line(&self.name.span);
        Ok(Experiment {
            name: self.name.value,
            kind: self.kind,
            file: self.file,
            log: samples,
            beside,
            current_meaning: self.current_meaning,
            accept: self.accept,
            line,
            report,
        })
    }
}

fn find<T>(list: &[(Channel, T)], channel: Channel) -> Option<&T> {
    list.iter()
        .find(|(found, _)| *found == channel)
        .map(|(_, value)| value)
}

/// Reads a table whose keys are channels.
fn by_channel<T>(
    section: &Section,
    key: &str,
    read: impl Fn(&Section, &'static str) -> Result<T, Error>,
) -> Result<Vec<(Channel, T)>, Error> {
    let Some(table) = section.section(key)? else {
        return Ok(Vec::new());
    };
    table.allow_only(&Channel::ALL.map(Channel::key))?;
    Channel::ALL
        .into_iter()
        .filter(|channel| table.has(channel.key()))
        .map(|channel| Ok((channel, read(&table, channel.key())?)))
        .collect()
}

/// A number that is not zero.
fn not_zero(table: &Section, key: &'static str, must_be: &str) -> Result<Located<f64>, Error> {
    let number = require(table.number(key)?, table, key)?;
    if number.value == 0.0 {
        return Err(table.error_at(
            key,
            Problem::OutOfRange {
                key: key.to_string(),
                value: 0.0,
                must_be: must_be.to_string(),
            },
        ));
    }
    Ok(number)
}

/// Returns a value whose key is known to exist.
fn require<T>(value: Option<T>, table: &Section, key: &str) -> Result<T, Error> {
    value.ok_or_else(|| table.error(table.missing(key, "a number")))
}

fn unit_scale(table: &Section, key: &'static str) -> Result<Located<f64>, Error> {
    let name = table.required_text(key, "a unit")?;
    let units = Channel::from_key(key).map_or(&[][..], Channel::units);
    match units.iter().find(|(unit, _)| *unit == name.value) {
        Some((_, scale)) => Ok(Located {
            value: *scale,
            span: name.span,
        }),
        None => Err(table.error_at(
            key,
            Problem::UnknownName {
                what: format!("unit of {key}"),
                name: name.value,
                names: Names::new(units.iter().map(|(unit, _)| unit)),
            },
        )),
    }
}

/// Whether `units` states that the current is a command without a unit.
fn is_normalised(section: &Section) -> Result<bool, Error> {
    let Some(table) = section.section("units")? else {
        return Ok(false);
    };
    let unit = table.text(Channel::Current.key())?;
    Ok(unit.is_some_and(|unit| unit.value == NORMALISED))
}

/// The held current of `constants`, A.
fn held_current(section: &Section, kind: Kind) -> Result<Option<Located<f64>>, Error> {
    let Some(table) = section.section("constants")? else {
        return Ok(None);
    };
    for key in table.keys() {
        if Channel::from_key(&key.value).is_some_and(|channel| channel != Channel::Current) {
            return Err(table.error_at(
                &key.value,
                Problem::NotAnInput {
                    key: key.value.clone(),
                },
            ));
        }
    }
    table.allow_only(&[Channel::Current.key()])?;
    let held = table.number(Channel::Current.key())?;
    if let Some(current) = &held
        && kind == Kind::FreeSwing
        && current.value != 0.0
    {
        return Err(table.error_at(
            Channel::Current.key(),
            Problem::ConstantWithoutInput { kind: kind.name() },
        ));
    }
    Ok(held)
}
